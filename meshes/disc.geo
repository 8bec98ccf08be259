// Flat disc in the plane z = 0 about the origin with a concentric inner disc. Normals point to +z.
// n counts the cells along a quarter of the circumference.
// pattern  0  cells cut by parallel diagonals (a square core, blocks around it)
//          1  the same, diagonals alternating (union jack; n even)
//          2  unstructured, edge length (quarter of the outer circumference) / n
DefineConstant[
  radius = {0.15, Name "Parameters/radius"},
  inner_radius = {0.06, Name "Parameters/inner_radius"},
  n = {12, Name "Parameters/n"},
  pattern = {2, Name "Parameters/pattern"},
  hole = {0, Name "Parameters/hole"}  // 1: without the inner disc
];
h = radius * Pi / 2 / n;

Point(1) = {0, 0, 0, h};
For k In {0 : 3}
  x = Cos(Pi / 4 + k * Pi / 2);
  y = Sin(Pi / 4 + k * Pi / 2);
  Point(10 + k) = {inner_radius * x, inner_radius * y, 0, h};
  Point(20 + k) = {radius * x, radius * y, 0, h};
EndFor
For k In {0 : 3}
  next = (k + 1) % 4;
  Circle(10 + k) = {10 + k, 1, 10 + next};
  Circle(20 + k) = {20 + k, 1, 20 + next};
EndFor

If (pattern == 2)
  Curve Loop(1) = {10 : 13};
  Curve Loop(2) = {20 : 23};
  Plane Surface(1) = {1};
  Plane Surface(2) = {2, 1};
  Point{1} In Surface{1};
  disc[] = {1};
  ring[] = {2};
  Mesh.Algorithm = 6;
Else
  // Core square, four blocks out to the inner circle, four blocks of the ring. The core is cut in four at the centre.
  n_half = Ceil(n / 2);
  n_core = Ceil(n / 4);
  n_ring = Ceil((radius - inner_radius) / h);
  core = 0.5 * inner_radius;
  For k In {0 : 3}
    x = Cos(Pi / 4 + k * Pi / 2);
    y = Sin(Pi / 4 + k * Pi / 2);
    Point(30 + k) = {core * x, core * y, 0, h};                                // corner of the core
    Point(40 + k) = {core * (x - y) / 2, core * (y + x) / 2, 0, h};            // middle of the side after corner k
    Point(50 + k) = {inner_radius * (x - y) / Sqrt(2), inner_radius * (y + x) / Sqrt(2), 0, h};
    Point(60 + k) = {radius * (x - y) / Sqrt(2), radius * (y + x) / Sqrt(2), 0, h};
  EndFor
  disc[] = {};
  ring[] = {};
  Delete { Curve{10 : 13}; Curve{20 : 23}; }
  For k In {0 : 3}
    next = (k + 1) % 4;
    Line(30 + k) = {30 + k, 40 + k};
    Line(40 + k) = {40 + k, 30 + next};
    Line(50 + k) = {1, 40 + k};
    Line(60 + k) = {30 + k, 10 + k};
    Line(70 + k) = {40 + k, 50 + k};
    Line(80 + k) = {10 + k, 20 + k};
    Line(90 + k) = {50 + k, 60 + k};
    Circle(100 + k) = {10 + k, 1, 50 + k};
    Circle(110 + k) = {50 + k, 1, 10 + next};
    Circle(120 + k) = {20 + k, 1, 60 + k};
    Circle(130 + k) = {60 + k, 1, 20 + next};
    Transfinite Curve{30 + k, 40 + k, 50 + k, 100 + k, 110 + k, 120 + k, 130 + k} = n_half + 1;
    Transfinite Curve{60 + k, 70 + k} = n_core + 1;
    Transfinite Curve{80 + k, 90 + k} = n_ring + 1;
  EndFor
  For k In {0 : 3}
    next = (k + 1) % 4;
    Curve Loop(200 + k) = {50 + k, 40 + k, 30 + next, -(50 + next)};
    Curve Loop(210 + k) = {60 + k, 100 + k, -(70 + k), -(30 + k)};
    Curve Loop(220 + k) = {70 + k, 110 + k, -(60 + next), -(40 + k)};
    Curve Loop(230 + k) = {80 + k, 120 + k, -(90 + k), -(100 + k)};
    Curve Loop(240 + k) = {90 + k, 130 + k, -(80 + next), -(110 + k)};
    For block In {20 : 24}
      s = 10 * block + k;
      Plane Surface(s) = {s};
      If (pattern == 0)
        Transfinite Surface{s} Right;
      Else
        Transfinite Surface{s} Alternate;
      EndIf
      If (block < 23)
        disc[] += s;
      Else
        ring[] += s;
      EndIf
    EndFor
  EndFor
EndIf

If (hole == 0)
  Physical Point("centre") = {1};
  Physical Surface("disc") = disc[];
Else
  Delete { Surface{disc[]}; }
EndIf
If (pattern == 2)
  Physical Curve("inner_edge") = {10 : 13};
  Physical Curve("edge") = {20 : 23};
Else
  Physical Curve("inner_edge") = {100 : 103, 110 : 113};
  Physical Curve("edge") = {120 : 123, 130 : 133};
EndIf
Physical Surface("ring") = ring[];
