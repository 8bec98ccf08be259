// Square plate 0 <= x, y <= side in the plane z = 0, or a rhombus: its left and right sides lean by the angle `skew`
// towards +x. Normals point to +z. The point "centre" exists for even n, and always for pattern 2.
// pattern  0  n x n cells cut by parallel diagonals
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length side / n
DefineConstant[
  side = {1, Name "Parameters/side"},
  skew = {0, Name "Parameters/skew"},  // [degrees]
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
h = side / n;
lean = Sin(skew * Pi / 180);
rise = Cos(skew * Pi / 180);
half = (pattern < 2 && n % 2 == 0) ? 2 : 1;  // blocks per direction; with 2 x 2 blocks the centre is a corner of all

// Points (i, j) of the blocks are numbered 1 + i + 3 j.
For j In {0 : half}
  For i In {0 : half}
    Point(1 + i + 3 * j) = {(i + j * lean) * side / half, j * rise * side / half, 0, h};
  EndFor
EndFor
// Line (i, j) along x starts at point (i, j) and has its number plus 10; along y plus 20.
For j In {0 : half}
  For i In {0 : half - 1}
    Line(11 + i + 3 * j) = {1 + i + 3 * j, 2 + i + 3 * j};
    Line(21 + j + 3 * i) = {1 + j + 3 * i, 4 + j + 3 * i};
    Transfinite Curve{11 + i + 3 * j, 21 + j + 3 * i} = n / half + 1;
  EndFor
EndFor
blocks[] = {};
For j In {0 : half - 1}
  For i In {0 : half - 1}
    p = 1 + i + 3 * j;
    Curve Loop(p) = {10 + p, 21 + p, -(13 + p), -(20 + p)};
    Plane Surface(p) = {p};
    blocks[] += p;
    If (pattern == 0)
      Transfinite Surface{p} = {p, p + 1, p + 4, p + 3} Right;
    ElseIf (pattern == 1)
      // Blocks of an odd number of cells start with the other diagonal, so that the diagonals alternate throughout.
      If ((i + j) % 2 == 1 && (n / half) % 2 == 1)
        Transfinite Surface{p} = {p, p + 1, p + 4, p + 3} AlternateLeft;
      Else
        Transfinite Surface{p} = {p, p + 1, p + 4, p + 3} AlternateRight;
      EndIf
    EndIf
  EndFor
EndFor

If (half == 2)
  Physical Point("centre") = {5};
  Physical Curve("bottom") = {11, 12};
  Physical Curve("top") = {17, 18};
  Physical Curve("left") = {21, 24};
  Physical Curve("right") = {23, 26};
Else
  Physical Curve("bottom") = {11};
  Physical Curve("top") = {14};
  Physical Curve("left") = {21};
  Physical Curve("right") = {22};
EndIf
If (pattern == 2)
  Point(10) = {(1 + lean) * side / 2, rise * side / 2, 0, h};
  Point{10} In Surface{1};
  Physical Point("centre") = {10};
  Mesh.Algorithm = 6;
EndIf
Physical Surface("plate") = blocks[];
