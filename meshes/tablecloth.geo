// A cloth and two smaller squares on it. The cloth lies in z = 0, centred in y, from x = start to start + length; the squares
// lie about the z axis. Normals point to +z. Diagonals alternate.
DefineConstant[
  start = {-0.15, Name "Parameters/start"},
  length = {0.6, Name "Parameters/length"},  // of the cloth, along x
  width = {0.4, Name "Parameters/width"},    // along y
  side = {0.2, Name "Parameters/side"},      // of the squares
  gap = {0.002, Name "Parameters/gap"},     // between neighbours
  h = {0.0166667, Name "Parameters/h"}       // edge length
];
For k In {1 : 3}
  a = 10 * k;
  x0 = k == 1 ? start : -side / 2;
  x1 = k == 1 ? start + length : side / 2;
  ly = k == 1 ? width : side;
  z = (k - 1) * gap;
  Point(a) = {x0, -ly / 2, z, h};
  Point(a + 1) = {x1, -ly / 2, z, h};
  Point(a + 2) = {x1, ly / 2, z, h};
  Point(a + 3) = {x0, ly / 2, z, h};
  For i In {0 : 3}
    Line(a + i) = {a + i, a + (i + 1) % 4};
  EndFor
  Transfinite Curve{a, a + 2} = Ceil((x1 - x0) / h - 0.01) + 1;
  Transfinite Curve{a + 1, a + 3} = Ceil(ly / h - 0.01) + 1;
  Curve Loop(a) = {a, a + 1, a + 2, a + 3};
  Plane Surface(a) = {a};
  Transfinite Surface{a} AlternateRight;
EndFor
Physical Curve("pulled") = {11};
Physical Surface("cloth") = {10};
Physical Surface("lower") = {20};
Physical Surface("upper") = {30};
