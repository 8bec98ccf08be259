// Quarter of a hemisphere with a round hole at its pole (the z axis). The full hemisphere follows by mirroring in the planes
// x = 0 and y = 0. Normals point outwards. All vertices lie on the sphere.
// pattern  0  n x n cells in longitude and latitude, cut by parallel diagonals
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length (length of the equator) / n
DefineConstant[
  radius = {10, Name "Parameters/radius"},
  hole = {18, Name "Parameters/hole"},  // angle between pole and rim of the hole [degrees]
  n = {16, Name "Parameters/n"},
  pattern = {0, Name "Parameters/pattern"}
];
SetFactory("OpenCASCADE");
h = radius * Pi / 2 / n;
latitude = (90 - hole) * Pi / 180;

Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0, h};
Point(3) = {radius * Cos(latitude), 0, radius * Sin(latitude), h};
Circle(1) = {2, 1, 3};
swept[] = Extrude { {0, 0, 1}, {0, 0, 0}, Pi / 2 } { Curve{1}; };  // end curve, surface, two side curves
Recursive Delete { Point{1}; }

// The side curves are found by where they are: their numbers are the kernel's own business.
e = 1e-3 * radius;
surface = swept[1];
sym_x[] = Curve In BoundingBox {-e, -e, -e, e, radius + e, radius + e};
sym_y[] = Curve In BoundingBox {-e, -e, -e, radius + e, e, radius + e};
equator[] = Curve In BoundingBox {-e, -e, -e, radius + e, radius + e, e};
rim[] = Curve In BoundingBox {-e, -e, radius * Sin(latitude) - e, radius + e, radius + e, radius + e};
load_x[] = Point In BoundingBox {radius - e, -e, -e, radius + e, e, e};
load_y[] = Point In BoundingBox {-e, radius - e, -e, e, radius + e, e};

Physical Point("load_x") = load_x[];
Physical Point("load_y") = load_y[];
Physical Curve("sym_x") = sym_x[];  // in the plane x = 0
Physical Curve("sym_y") = sym_y[];  // in the plane y = 0
Physical Curve("equator") = equator[];
Physical Curve("hole") = rim[];
Physical Surface("shell") = surface;

If (pattern < 2)
  Transfinite Curve{sym_x[], sym_y[], equator[], rim[]} = n + 1;
  If (pattern == 0)
    Transfinite Surface{surface} Right;
  Else
    Transfinite Surface{surface} Alternate;
  EndIf
Else
  Mesh.MeshSizeMin = h;
  Mesh.MeshSizeMax = h;
  Mesh.Algorithm = 6;
EndIf
