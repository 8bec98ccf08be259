// Flat annulus in the plane z = 0, slit along the positive x axis. Normals point to +z. The two lips of the slit lie on each
// other and have separate vertices: the free lip at angle 0, the clamped lip at angle 360 degrees.
// pattern  0  n_radial x n_circ cells cut by parallel diagonals
//          1  the same, diagonals alternating (union jack; n_circ a multiple of 8)
//          2  unstructured, edge length (ro - ri) / n_radial; n_circ is not used
DefineConstant[
  ri = {6, Name "Parameters/ri"},
  ro = {10, Name "Parameters/ro"},
  n_radial = {12, Name "Parameters/n_radial"},
  n_circ = {120, Name "Parameters/n_circ"},
  pattern = {0, Name "Parameters/pattern"}
];
h = (ro - ri) / n_radial;

// Four sectors with a whole number of cells each.
cells[] = {0, Round(n_circ / 4), Round(n_circ / 2), Round(3 * n_circ / 4), n_circ};
If (pattern == 2)
  cells[] = {0, 1, 2, 3, 4};
EndIf
Point(1) = {0, 0, 0};
For k In {0 : 4}
  angle = 2 * Pi * cells[k] / cells[4];
  x = Cos(angle);
  y = Sin(angle);
  If (k == 4)
    x = 1;
    y = 0;
  EndIf
  Point(10 + k) = {ri * x, ri * y, 0, h};
  Point(20 + k) = {ro * x, ro * y, 0, h};
  Line(10 + k) = {10 + k, 20 + k};
EndFor
For k In {0 : 3}
  Circle(20 + k) = {10 + k, 1, 11 + k};
  Circle(30 + k) = {20 + k, 1, 21 + k};
  Curve Loop(k + 1) = {10 + k, 30 + k, -(11 + k), -(20 + k)};
  Plane Surface(k + 1) = {k + 1};
EndFor

Physical Point("A") = {10};  // inner end of the free lip
Physical Point("B") = {20};  // outer end of the free lip
Physical Curve("free_lip") = {10};
Physical Curve("clamped_lip") = {14};
Physical Curve("inner") = {20 : 23};
Physical Curve("outer") = {30 : 33};
Physical Surface("plate") = {1 : 4};

If (pattern < 2)
  For k In {0 : 3}
    Transfinite Curve{20 + k, 30 + k} = cells[k + 1] - cells[k] + 1;
    If (pattern == 0)
      Transfinite Surface{k + 1} = {10 + k, 20 + k, 21 + k, 11 + k} Right;
    Else
      Transfinite Surface{k + 1} = {10 + k, 20 + k, 21 + k, 11 + k} Alternate;
    EndIf
  EndFor
  Transfinite Curve{10 : 14} = n_radial + 1;
Else
  Mesh.Algorithm = 6;
EndIf
