// Octant of a cylinder whose axis is y: x, y, z >= 0. The full cylinder of the given length follows by mirroring in the planes
// x = 0, y = 0 and z = 0. Normals point outwards. The defaults are the cylinder pulled by two opposite forces; the pinched
// cylinder has radius = 100, length = 200.
// pattern  0  n_axial x n_circ cells cut by parallel diagonals
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length (quarter circumference) / n_circ; n_axial is not used
DefineConstant[
  radius = {4.953, Name "Parameters/radius"},
  length = {10.35, Name "Parameters/length"},  // of the full cylinder
  n_axial = {20, Name "Parameters/n_axial"},
  n_circ = {30, Name "Parameters/n_circ"},
  pattern = {0, Name "Parameters/pattern"}
];
SetFactory("OpenCASCADE");
h = radius * Pi / 2 / n_circ;

Point(1) = {0, 0, 0};
Point(2) = {0, 0, radius, h};
Point(3) = {radius, 0, 0, h};
Circle(1) = {3, 1, 2};
swept[] = Extrude { 0, length / 2, 0 } { Curve{1}; };
Recursive Delete { Point{1}; }

e = 1e-3 * radius;
surface = swept[1];
middle[] = Curve In BoundingBox {-e, -e, -e, radius + e, e, radius + e};
end[] = Curve In BoundingBox {-e, length / 2 - e, -e, radius + e, length / 2 + e, radius + e};
crown[] = Curve In BoundingBox {-e, -e, -e, e, length / 2 + e, radius + e};
flank[] = Curve In BoundingBox {-e, -e, -e, radius + e, length / 2 + e, e};
a[] = Point In BoundingBox {-e, -e, radius - e, e, e, radius + e};
b[] = Point In BoundingBox {radius - e, -e, -e, radius + e, e, e};
c[] = Point In BoundingBox {radius - e, length / 2 - e, -e, radius + e, length / 2 + e, e};

Physical Point("A") = a[];            // (0, 0, radius), under the force
Physical Point("B") = b[];            // (radius, 0, 0)
Physical Point("C") = c[];            // (radius, length / 2, 0)
Physical Curve("middle") = middle[];  // in the plane y = 0
Physical Curve("end") = end[];        // in the plane y = length / 2
Physical Curve("crown") = crown[];    // in the plane x = 0
Physical Curve("flank") = flank[];    // in the plane z = 0
Physical Surface("shell") = surface;

If (pattern < 2)
  Transfinite Curve{middle[], end[]} = n_circ + 1;
  Transfinite Curve{crown[], flank[]} = n_axial + 1;
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
