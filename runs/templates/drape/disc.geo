// A disc of 300 mm whose inner 180 mm lie on the support of a drape tester. Cells are smallest at the edge of the support, where
// the fabric bends most, and grow away from it. Metres.
SetFactory("OpenCASCADE");
DefineConstant[ size = {0.0022, Name "Parameters/size"} ];
Disk(1) = {0, 0, 0, 0.15};
Disk(2) = {0, 0, 0, 0.09};
BooleanFragments{ Surface{1}; Delete; }{ Surface{2}; Delete; }
Physical Surface("support") = {2};
Physical Surface("overhang") = {3};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.16*Abs(Sqrt(x*x + y*y) - 0.09) - 0.1*(Sqrt(x*x + y*y) - 0.09)", size);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
