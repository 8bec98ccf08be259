// A blade 300 mm long and 120 mm wide along its arc, curved with a radius of 150 mm; its root is at x = 0. Metres.
DefineConstant[ n = {16, Name "Parameters/n"} ];
SetFactory("OpenCASCADE");
radius = 0.15;
half = 0.06 / radius;
Point(1) = {0, 0, 0};
Point(2) = {0, -radius*Sin(half), radius*Cos(half)};
Point(3) = {0, radius*Sin(half), radius*Cos(half)};
Circle(1) = {3, 1, 2};
blade() = Extrude { 0.3, 0, 0 }{ Curve{1}; };
Recursive Delete { Point{1}; }
Physical Curve("root") = {1};
Physical Surface("blade") = {blade(1)};
MeshSize { : } = 0.12 / n;
