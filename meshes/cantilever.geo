// Rectangular strip in the plane z = 0, x along its length. Normals point to +z.
// pattern  0  nx x ny rectangles cut by parallel diagonals
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length `length` / nx
DefineConstant[
  length = {10, Name "Parameters/length"},
  width = {1, Name "Parameters/width"},
  nx = {40, Name "Parameters/nx"},
  ny = {4, Name "Parameters/ny"},
  pattern = {0, Name "Parameters/pattern"}
];
h = length / nx;

Point(1) = {0, 0, 0, h};
Point(2) = {length, 0, 0, h};
Point(3) = {length, width, 0, h};
Point(4) = {0, width, 0, h};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

Physical Curve("clamp") = {4};
Physical Curve("tip") = {2};
Physical Curve("sides") = {1, 3};
Physical Curve("side_low") = {1};   // y = 0
Physical Curve("side_high") = {3};  // y = width
Physical Surface("plate") = {1};

If (pattern < 2)
  Transfinite Curve{1, 3} = nx + 1;
  Transfinite Curve{2, 4} = ny + 1;
  If (pattern == 0)
    Transfinite Surface{1} = {1, 2, 3, 4} Right;
  Else
    Transfinite Surface{1} = {1, 2, 3, 4} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
