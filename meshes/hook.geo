// Curved strip of constant width along z: an arc of radius r1 over angle1 from the end x = y = 0, followed smoothly by
// an arc of radius r2, turned the other way, over angle2. Normals of the first arc point towards its centre (0, r1).
// pattern  0  cells cut by parallel diagonals: n across, and as many along each arc as keeps them nearly square
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length width / n
DefineConstant[
  r1 = {14, Name "Parameters/r1"},
  r2 = {46, Name "Parameters/r2"},
  angle1 = {60, Name "Parameters/angle1"},   // [degrees]
  angle2 = {150, Name "Parameters/angle2"},  // [degrees], below 180
  width = {20, Name "Parameters/width"},
  n = {8, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
h = width / n;
a1 = angle1 * Pi / 180;
a2 = angle2 * Pi / 180;
xc = (r1 + r2) * Sin(a1);       // centre of the second arc
yc = r1 - (r1 + r2) * Cos(a1);

For k In {0 : 1}
  Point(1 + 10 * k) = {0, r1, k * width};
  Point(2 + 10 * k) = {xc, yc, k * width};
  Point(3 + 10 * k) = {0, 0, k * width, h};
  Point(4 + 10 * k) = {r1 * Sin(a1), r1 - r1 * Cos(a1), k * width, h};
  Point(5 + 10 * k) = {xc - r2 * Sin(a1 - a2), yc + r2 * Cos(a1 - a2), k * width, h};
  Circle(1 + 10 * k) = {3 + 10 * k, 1 + 10 * k, 4 + 10 * k};
  Circle(2 + 10 * k) = {4 + 10 * k, 2 + 10 * k, 5 + 10 * k};
EndFor
For k In {3 : 5}
  Line(k) = {k, k + 10};
EndFor
Curve Loop(1) = {3, 11, -4, -1};
Curve Loop(2) = {4, 12, -5, -2};
Surface(1) = {1};
Surface(2) = {2};

Physical Curve("clamp") = {3};
Physical Curve("tip") = {5};
Physical Curve("sides") = {1, 2, 11, 12};
Physical Surface("shell") = {1, 2};

If (pattern < 2)
  Transfinite Curve{1, 11} = Ceil(r1 * a1 / h) + 1;
  Transfinite Curve{2, 12} = Ceil(r2 * a2 / h) + 1;
  Transfinite Curve{3 : 5} = n + 1;
  If (pattern == 0)
    Transfinite Surface{1, 2} Right;
  Else
    Transfinite Surface{1, 2} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
