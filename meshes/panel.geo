// Quarter of a cylindrical panel whose axis is y: x, y >= 0, angle from the z axis between 0 and half_angle. The full panel
// follows by mirroring in the planes x = 0 and y = 0. Normals point outwards. The defaults are the hinged roof of Sze, Liu &
// Lo (2004).
// pattern  0  n_axial x n_circ cells cut by parallel diagonals
//          1  the same, diagonals alternating (union jack)
//          2  unstructured, edge length (half arc) / n_circ; n_axial is not used
DefineConstant[
  radius = {2540, Name "Parameters/radius"},
  length = {508, Name "Parameters/length"},          // of the full panel
  half_angle = {0.1, Name "Parameters/half_angle"},  // radian
  n_axial = {16, Name "Parameters/n_axial"},
  n_circ = {16, Name "Parameters/n_circ"},
  pattern = {0, Name "Parameters/pattern"}
];
SetFactory("OpenCASCADE");
h = radius * half_angle / n_circ;
x_edge = radius * Sin(half_angle);
z_edge = radius * Cos(half_angle);

Point(1) = {0, 0, 0};
Point(2) = {0, 0, radius, h};
Point(3) = {x_edge, 0, z_edge, h};
Circle(1) = {3, 1, 2};
swept[] = Extrude { 0, length / 2, 0 } { Curve{1}; };
Recursive Delete { Point{1}; }

e = 1e-4 * length;
surface = swept[1];
middle[] = Curve In BoundingBox {-e, -e, -e, x_edge + e, e, radius + e};
end[] = Curve In BoundingBox {-e, length / 2 - e, -e, x_edge + e, length / 2 + e, radius + e};
crown[] = Curve In BoundingBox {-e, -e, radius - e, e, length / 2 + e, radius + e};
edge[] = Curve In BoundingBox {x_edge - e, -e, z_edge - e, x_edge + e, length / 2 + e, z_edge + e};
c[] = Point In BoundingBox {-e, -e, radius - e, e, e, radius + e};
crown_end[] = Point In BoundingBox {-e, length / 2 - e, radius - e, e, length / 2 + e, radius + e};
edge_middle[] = Point In BoundingBox {x_edge - e, -e, z_edge - e, x_edge + e, e, z_edge + e};

Physical Point("C") = c[];                       // centre of the full panel
Physical Point("crown_end") = crown_end[];       // middle of a curved edge
Physical Point("edge_middle") = edge_middle[];   // middle of a straight edge
Physical Curve("middle") = middle[];             // in the plane y = 0
Physical Curve("end") = end[];                   // curved edge, in the plane y = length / 2
Physical Curve("crown") = crown[];               // in the plane x = 0
Physical Curve("edge") = edge[];                 // straight edge
Physical Surface("shell") = surface;

If (pattern < 2)
  Transfinite Curve{middle[], end[]} = n_circ + 1;
  Transfinite Curve{crown[], edge[]} = n_axial + 1;
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
