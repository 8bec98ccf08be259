// Half 0 <= y of the saddle z = x^2 - y^2 over the square -1/2 <= x, y <= 1/2. The other half follows by mirroring in
// the plane y = 0. Normals point upwards. All vertices lie on the saddle.
// pattern  0  n x n/2 cells cut by parallel diagonals (n even)
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length 1 / n
DefineConstant[
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
h = 1 / n;
// From here on, points are (u, v) = (x, y).
Parametric Surface(1) = "u" "v" "u * u - v * v";
Coordinates Surface 1;
Point(1) = {-0.5, 0, 0, h};
Point(2) = {0.5, 0, 0, h};
Point(3) = {0.5, 0.5, 0, h};
Point(4) = {-0.5, 0.5, 0, h};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Surface(1) = {1};
Euclidian Coordinates;

Physical Point("A") = {2};        // middle of the edge opposite to `clamp`
Physical Curve("middle") = {1};   // in the plane y = 0
Physical Curve("clamp") = {4};
Physical Curve("free_edges") = {2, 3};
Physical Surface("shell") = {1};

If (pattern < 2)
  Transfinite Curve{1, 3} = n + 1;
  Transfinite Curve{2, 4} = Round(n / 2) + 1;
  If (pattern == 0)
    Transfinite Surface{1} = {1, 2, 3, 4} Right;
  Else
    Transfinite Surface{1} = {1, 2, 3, 4} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
