// A ring of radii 60 and 100 mm with a slit along the positive x axis, whose sides are separate edges. Metres.
DefineConstant[ n = {12, Name "Parameters/n"} ];
inner = 0.06;
outer = 0.1;
Point(1) = {0, 0, 0};
For k In {0 : 4}
  Point(10 + k) = {inner*Cos(k*Pi/2), inner*Sin(k*Pi/2), 0};
  Point(20 + k) = {outer*Cos(k*Pi/2), outer*Sin(k*Pi/2), 0};
  Line(10 + k) = {10 + k, 20 + k};
EndFor
For k In {0 : 3}
  Circle(20 + k) = {10 + k, 1, 11 + k};
  Circle(30 + k) = {20 + k, 1, 21 + k};
  Curve Loop(k + 1) = {10 + k, 30 + k, -(11 + k), -(20 + k)};
  Plane Surface(k + 1) = {k + 1};
  Transfinite Curve{20 + k, 30 + k} = 5*n/2 + 1;
  Transfinite Surface{k + 1} = {10 + k, 20 + k, 21 + k, 11 + k} Right;
EndFor
Transfinite Curve{10 : 14} = n + 1;
Physical Point("corner") = {20};
Physical Curve("lifted") = {10};
Physical Curve("clamped") = {14};
Physical Surface("ring") = {1 : 4};
