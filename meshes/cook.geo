// Cook's tapered panel in the plane z = 0: corners (0, 0), (48, 44), (48, 60), (0, 44). Normals point to +z.
// pattern  0  n x n cells cut by parallel diagonals (n even)
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length 48 / n
DefineConstant[
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
h = 48 / n;

Point(1) = {0, 0, 0, h};
Point(2) = {48, 44, 0, h};
Point(3) = {48, 52, 0, h};
Point(4) = {48, 60, 0, h};
Point(5) = {0, 44, 0, h};
For k In {1 : 5}
  Line(k) = {k, 1 + k % 5};
EndFor
Curve Loop(1) = {1 : 5};
Plane Surface(1) = {1};

Physical Point("A") = {3};  // middle of the loaded edge
Physical Curve("clamp") = {5};
Physical Curve("tip") = {2, 3};
Physical Surface("panel") = {1};

If (pattern < 2)
  Transfinite Curve{1, 4, 5} = n + 1;
  Transfinite Curve{2, 3} = Round(n / 2) + 1;
  If (pattern == 0)
    Transfinite Surface{1} = {1, 2, 4, 5} Left;
  Else
    Transfinite Surface{1} = {1, 2, 4, 5} Alternate;
  EndIf
Else
  Mesh.Algorithm = 6;
EndIf
