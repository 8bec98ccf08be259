// Cylinder about the x axis, open at both ends, 0 <= x <= length, of n_axial x n_circ cells with alternating diagonals.
// Normals point outwards.
DefineConstant[
  radius = {0.1, Name "Parameters/radius"},
  length = {1, Name "Parameters/length"},
  n_axial = {48, Name "Parameters/n_axial"},
  n_circ = {32, Name "Parameters/n_circ"}  // a multiple of 4
];
h = length / n_axial;
For end In {0 : 1}
  a = 10 * end;
  x = end * length;
  Point(a + 9) = {x, 0, 0, h};
  For k In {0 : 3}
    Point(a + k + 1) = {x, radius * Cos(k * Pi / 2), radius * Sin(k * Pi / 2), h};
  EndFor
  For k In {0 : 3}
    Circle(a + k + 1) = {a + k + 1, a + 9, a + (k + 1) % 4 + 1};
    Transfinite Curve{a + k + 1} = n_circ / 4 + 1;
  EndFor
EndFor
For k In {1 : 4}
  Line(20 + k) = {k, 10 + k};
  Transfinite Curve{20 + k} = n_axial + 1;
EndFor
For k In {1 : 4}
  next = k % 4 + 1;
  Curve Loop(k) = {20 + k, 10 + k, -(20 + next), -k};
  Surface(k) = {-k};
  Transfinite Surface{k} = {k, 10 + k, 10 + next, next} AlternateRight;
EndFor
Physical Curve("start") = {1 : 4};
Physical Curve("end") = {11 : 14};
Physical Surface("tube") = {1 : 4};
