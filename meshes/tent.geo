// Four-point tent: the ruled surface between straight edges over the square -side/2 <= x, y <= side/2, whose corners lie at
// z = height/2 on one diagonal and -height/2 on the other. n x n cells with alternating diagonals. Normals point upwards.
DefineConstant[
  side = {8, Name "Parameters/side"},
  height = {3, Name "Parameters/height"},
  n = {24, Name "Parameters/n"}
];
a = side / 2;
Point(1) = {-a, -a, height / 2};
Point(2) = {a, -a, -height / 2};
Point(3) = {a, a, height / 2};
Point(4) = {-a, a, -height / 2};
For k In {1 : 4}
  Line(k) = {k, k % 4 + 1};
  Transfinite Curve{k} = n + 1;
EndFor
Curve Loop(1) = {1 : 4};
Surface(1) = {1};
Transfinite Surface{1} = {1, 2, 3, 4} Alternate;
Physical Point("corners") = {1 : 4};
Physical Curve("edge") = {1 : 4};
Physical Surface("sheet") = {1};
