// Octant x, y, z >= 0 of a sphere: a quarter of a closed hemisphere, without a singular point at the pole. Three blocks
// meet in the middle. Normals point outwards. All vertices lie on the sphere.
// n counts the cells along a quarter of a great circle.
// pattern  0  cells cut by parallel diagonals in each block (n even)
//          1  the same, diagonals alternating (union jack; n even)
//          2  unstructured, edge length (quarter of a great circle) / n
DefineConstant[
  radius = {10, Name "Parameters/radius"},
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
h = radius * Pi / 2 / n;
s = radius / Sqrt(2);
c = radius / Sqrt(3);

Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0, h};
Point(3) = {0, radius, 0, h};
Point(4) = {0, 0, radius, h};
Point(5) = {s, s, 0, h};
Point(6) = {0, s, s, h};
Point(7) = {s, 0, s, h};
Point(8) = {c, c, c, h};
Circle(1) = {2, 1, 5};
Circle(2) = {5, 1, 3};
Circle(3) = {3, 1, 6};
Circle(4) = {6, 1, 4};
Circle(5) = {4, 1, 7};
Circle(6) = {7, 1, 2};
Circle(7) = {5, 1, 8};
Circle(8) = {6, 1, 8};
Circle(9) = {7, 1, 8};
Curve Loop(1) = {1, 7, -9, 6};
Curve Loop(2) = {3, 8, -7, 2};
Curve Loop(3) = {5, 9, -8, 4};
For k In {1 : 3}
  Surface(k) = {k} In Sphere{1};
EndFor

Physical Point("load_x") = {2};
Physical Point("load_y") = {3};
Physical Point("pole") = {4};
Physical Curve("equator") = {1, 2};
Physical Curve("sym_x") = {3, 4};  // in the plane x = 0
Physical Curve("sym_y") = {5, 6};  // in the plane y = 0
Physical Surface("shell") = {1 : 3};

If (pattern < 2)
  Transfinite Curve{1 : 9} = Round(n / 2) + 1;
  If (pattern == 0)
    Transfinite Surface{1 : 3} Right;
  Else
    Transfinite Surface{1 : 3} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
