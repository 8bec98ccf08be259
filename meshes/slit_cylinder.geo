// Half of a cylinder slit along a generator; the axis is x. The slit is at angle 0 (y = 0, z = radius), the half ends
// at angle 180 degrees, opposite to the slit; angles turn from z towards -y. Normals point outwards. The end x = length
// is cut into 12 arcs of 15 degrees, so that a force along the circumference can be given.
// pattern  0  n_axial x n_circ cells cut by parallel diagonals (n_circ a multiple of 12)
//          1  the same, diagonals alternating (union jack; n_circ a multiple of 24)
//          2  unstructured, edge length (half circumference) / n_circ; n_axial is not used
DefineConstant[
  radius = {300, Name "Parameters/radius"},
  length = {900, Name "Parameters/length"},
  n_axial = {24, Name "Parameters/n_axial"},
  n_circ = {24, Name "Parameters/n_circ"},
  pattern = {0, Name "Parameters/pattern"}
];
h = radius * Pi / n_circ;

For i In {0 : 1}
  x = i * length;
  Point(100 * i + 1) = {x, 0, 0};
  For k In {0 : 12}
    angle = k * Pi / 12;
    Point(100 * i + 10 + k) = {x, -radius * Sin(angle), radius * Cos(angle), h};
  EndFor
  For k In {0 : 11}
    Circle(100 * i + 10 + k) = {100 * i + 10 + k, 100 * i + 1, 100 * i + 11 + k};
  EndFor
EndFor
For k In {0 : 12}
  Line(30 + k) = {10 + k, 110 + k};
EndFor
For k In {0 : 11}
  Curve Loop(k + 1) = {10 + k, 31 + k, -(110 + k), -(30 + k)};
  Surface(k + 1) = {k + 1};
  Physical Curve(Sprintf("arc_%g", k + 1)) = {110 + k};  // of the end x = length, from the slit on
EndFor

Physical Point("lip") = {110};        // end x = length of the lip
Physical Point("lip_start") = {10};
Physical Curve("slit") = {30};
Physical Curve("opposite") = {42};
Physical Curve("start") = {10 : 21};  // in the plane x = 0
Physical Surface("shell") = {1 : 12};

If (pattern < 2)
  Transfinite Curve{10 : 21, 110 : 121} = Round(n_circ / 12) + 1;
  Transfinite Curve{30 : 42} = n_axial + 1;
  If (pattern == 0)
    Transfinite Surface{1 : 12} Right;
  Else
    Transfinite Surface{1 : 12} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
