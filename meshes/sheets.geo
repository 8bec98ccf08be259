// Square sheets about the z axis, one above the other, the lowest in z = 0. Normals point to +z. Sheet k (from 1) is the
// surface "sheet k" with the sides "left k" (x least), "right k", "front k" (y least) and "back k".
// pattern  0  n x n cells cut by parallel diagonals
//          1  the same, diagonals alternating
//          2  unstructured, edge length side / n
DefineConstant[
  sheets = {3, Name "Parameters/sheets"},
  side = {1, Name "Parameters/side"},
  gap = {0.01, Name "Parameters/gap"},    // between neighbours
  turn = {0, Name "Parameters/turn"},     // angle about z from each to the next [degrees]
  n = {16, Name "Parameters/n"},
  pattern = {1, Name "Parameters/pattern"}
];
h = side / n;
For k In {1 : sheets}
  a = 10 * k;
  angle = (k - 1) * turn * Pi / 180;
  For i In {0 : 3}
    corner = angle + Pi / 4 + (i + 2) * Pi / 2;
    Point(a + i) = {side / Sqrt(2) * Cos(corner), side / Sqrt(2) * Sin(corner), (k - 1) * gap, h};
  EndFor
  For i In {0 : 3}
    Line(a + i) = {a + i, a + (i + 1) % 4};
  EndFor
  Curve Loop(a) = {a, a + 1, a + 2, a + 3};
  Plane Surface(a) = {a};
  If (pattern < 2)
    Transfinite Curve{a, a + 1, a + 2, a + 3} = n + 1;
    If (pattern == 0)
      Transfinite Surface{a} Right;
    Else
      Transfinite Surface{a} AlternateRight;
    EndIf
  EndIf
  Physical Curve(Sprintf("front %g", k)) = {a};
  Physical Curve(Sprintf("right %g", k)) = {a + 1};
  Physical Curve(Sprintf("back %g", k)) = {a + 2};
  Physical Curve(Sprintf("left %g", k)) = {a + 3};
  Physical Surface(Sprintf("sheet %g", k)) = {a};
EndFor
Mesh.Algorithm = 6;
