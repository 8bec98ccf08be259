// Flat equilateral triangle of the given height in the plane z = 0, its centroid at the origin, one corner on the
// positive x axis. Three blocks meet at the centroid. Normals point to +z.
// pattern  0  n/2 x n/2 cells in each block, cut by parallel diagonals (n even)
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length side / n
DefineConstant[
  height = {1, Name "Parameters/height"},
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
side = 2 * height / Sqrt(3);
h = side / n;

// Corners 1 to 3, middle 3 + k of the side from corner k to the next, centroid 7.
Point(1) = {2 * height / 3, 0, 0, h};
Point(2) = {-height / 3, side / 2, 0, h};
Point(3) = {-height / 3, -side / 2, 0, h};
Point(4) = {height / 6, side / 4, 0, h};
Point(5) = {-height / 3, 0, 0, h};
Point(6) = {height / 6, -side / 4, 0, h};
Point(7) = {0, 0, 0, h};
For k In {1 : 3}
  Line(k) = {k, 3 + k};
  Line(3 + k) = {3 + k, 1 + k % 3};
  Line(6 + k) = {3 + k, 7};
EndFor
For k In {1 : 3}
  previous = 1 + (k + 1) % 3;
  Curve Loop(k) = {k, 6 + k, -(6 + previous), 3 + previous};
  Plane Surface(k) = {k};
EndFor

Physical Point("centre") = {7};
Physical Curve("edge") = {1 : 6};
Physical Surface("plate") = {1 : 3};

If (pattern < 2)
  Transfinite Curve{1 : 9} = Round(n / 2) + 1;
  For k In {1 : 3}
    If (pattern == 0)
      Transfinite Surface{k} = {k, 3 + k, 7, 4 + (k + 1) % 3} Right;
    Else
      Transfinite Surface{k} = {k, 3 + k, 7, 4 + (k + 1) % 3} Alternate;
    EndIf
  EndFor
Else
  Mesh.Algorithm = 6;
EndIf
