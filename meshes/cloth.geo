// Square cloth in the plane z = 0 about the origin, with an inner disc to hold it by. Normals point to +z. Unstructured.
DefineConstant[
  side = {0.3, Name "Parameters/side"},
  radius = {0.06, Name "Parameters/radius"},
  n = {30, Name "Parameters/n"}  // edges along a side
];
h = side / n;

Point(1) = {0, 0, 0, h};
For k In {0 : 3}
  x = Cos(Pi / 4 + k * Pi / 2);
  y = Sin(Pi / 4 + k * Pi / 2);
  Point(10 + k) = {radius * x, radius * y, 0, h};
  Point(20 + k) = {side * x / Sqrt(2), side * y / Sqrt(2), 0, h};
EndFor
For k In {0 : 3}
  next = (k + 1) % 4;
  Circle(10 + k) = {10 + k, 1, 10 + next};
  Line(20 + k) = {20 + k, 20 + next};
EndFor
Curve Loop(1) = {10 : 13};
Curve Loop(2) = {20 : 23};
Plane Surface(1) = {1};
Plane Surface(2) = {2, 1};
Point{1} In Surface{1};

Physical Point("centre") = {1};
Physical Curve("edge") = {20 : 23};
Physical Surface("disc") = {1};
Physical Surface("rest") = {2};
Mesh.Algorithm = 6;
