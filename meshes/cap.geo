// Quarter (x, y >= 0) of a spherical cap about the z axis. The full cap follows by mirroring in the planes x = 0 and y = 0.
// Normals point outwards. The defaults are the clamped cap of Bathe, Ramm & Wilson (1975), inches.
// n counts the cells from the pole to the rim.
// pattern  0  cells cut by parallel diagonals in each of three blocks (n even)
//          1  the same, diagonals alternating (union jack; n even)
//          2  unstructured, edge length (arc from the pole to the rim) / n
DefineConstant[
  radius = {22.27, Name "Parameters/radius"},
  half_angle = {26.67, Name "Parameters/half_angle"},  // degrees
  n = {12, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
a = half_angle * Pi / 180;
h = radius * a / n;
d = Sqrt(0.5);

Point(1) = {0, 0, 0};
Point(2) = {0, 0, radius, h};                                                                // pole
Point(3) = {radius * Sin(a), 0, radius * Cos(a), h};                                         // rim, y = 0
Point(4) = {0, radius * Sin(a), radius * Cos(a), h};                                         // rim, x = 0
Point(5) = {radius * Sin(a / 2), 0, radius * Cos(a / 2), h};
Point(6) = {0, radius * Sin(a / 2), radius * Cos(a / 2), h};
Point(7) = {radius * Sin(a) * d, radius * Sin(a) * d, radius * Cos(a), h};                   // middle of the rim
Point(8) = {radius * Sin(0.55 * a) * d, radius * Sin(0.55 * a) * d, radius * Cos(0.55 * a), h};
Point(9) = {0, 0, radius * Cos(a)};                                                          // centre of the rim
Circle(1) = {2, 1, 5};
Circle(2) = {5, 1, 3};
Circle(3) = {3, 9, 7};
Circle(4) = {7, 9, 4};
Circle(5) = {4, 1, 6};
Circle(6) = {6, 1, 2};
Circle(7) = {5, 1, 8};
Circle(8) = {7, 1, 8};
Circle(9) = {6, 1, 8};
Curve Loop(1) = {1, 7, -9, 6};
Curve Loop(2) = {2, 3, 8, -7};
Curve Loop(3) = {5, 9, -8, 4};
For k In {1 : 3}
  Surface(k) = {k} In Sphere{1};
EndFor

Physical Point("pole") = {2};
Physical Curve("rim") = {3, 4};
Physical Curve("sym_x") = {5, 6};  // in the plane x = 0
Physical Curve("sym_y") = {1, 2};  // in the plane y = 0
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
