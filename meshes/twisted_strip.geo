// Strip of length 12 twisted evenly by 90 degrees about its centre line, the x axis: at x = 0 its width lies along y,
// at x = 12 along z. Normals start along +z. All vertices lie on the helicoid.
// pattern  0  nx x ny cells cut by parallel diagonals (ny even)
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length 12 / nx; ny is not used
DefineConstant[
  width = {1.1, Name "Parameters/width"},
  nx = {48, Name "Parameters/nx"},
  ny = {4, Name "Parameters/ny"},
  pattern = {0, Name "Parameters/pattern"}
];
length = 12;  // a formula below must be a plain text, so length and twist cannot be parameters
h = length / nx;
// From here on, points are (u, v): position along and across the strip.
Parametric Surface(1) = "u" "v * Cos(Pi / 24 * u)" "v * Sin(Pi / 24 * u)";
Coordinates Surface 1;

Point(1) = {0, -width / 2, 0, h};
Point(2) = {length, -width / 2, 0, h};
Point(3) = {length, 0, 0, h};
Point(4) = {length, width / 2, 0, h};
Point(5) = {0, width / 2, 0, h};
Point(6) = {0, 0, 0, h};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Line(7) = {6, 3};
Curve Loop(1) = {1, 2, -7, 6};
Curve Loop(2) = {7, 3, 4, 5};
Surface(1) = {1};
Surface(2) = {2};
Euclidian Coordinates;

Physical Point("tip_centre") = {3};
Physical Curve("clamp") = {5, 6};
Physical Curve("tip") = {2, 3};
Physical Curve("sides") = {1, 4};
Physical Surface("strip") = {1, 2};

If (pattern < 2)
  Transfinite Curve{1, 4, 7} = nx + 1;
  Transfinite Curve{2, 3, 5, 6} = Round(ny / 2) + 1;
  If (pattern == 0)
    Transfinite Surface{1, 2} Right;
  Else
    Transfinite Surface{1, 2} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
