"""Reads exported files with VTK's readers, for tests/check_exports.py; runs in ParaView's Python: with_vtk.py JOB.json"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

READERS = {"obj": vtk.vtkOBJReader, "stl": vtk.vtkSTLReader, "ply": vtk.vtkPLYReader}


def triangles_of(data):
    return vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def read_glb(key, file, times, fps, arrays):
    """Blocks of a GLB at times; those that are not seen have no extent."""
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(file)
    reader.SetFrameRate(fps)
    reader.SetApplyDeformationsToGeometry(True)
    reader.UpdateInformation()
    reader.EnableAnimation(0)
    reader.UpdateInformation()
    arrays[f"{key}/times"] = np.array(reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    for i, time in enumerate(times):
        # At the very time of a step in an animation VTK still has what was before.
        reader.UpdateTimeStep(float(np.nextafter(np.float32(time), np.float32(np.inf))))
        blocks = reader.GetOutput().NewIterator()
        positions, triangles, first = [], [], 0
        while not blocks.IsDoneWithTraversal():
            block = blocks.GetCurrentDataObject()
            x = vtk_to_numpy(block.GetPoints().GetData())
            if np.ptp(x) > 0:
                positions.append(x.copy())
                triangles.append(triangles_of(block) + first)
                first += len(x)
            blocks.GoToNextItem()
        arrays[f"{key}/{i}/positions"], arrays[f"{key}/{i}/triangles"] = np.vstack(positions), np.vstack(triangles)


def read_mesh(key, file, arrays):
    reader = READERS[file.rsplit(".", 1)[1]]()
    reader.SetFileName(file)
    if file.endswith("stl"):
        reader.MergingOff()
    reader.Update()
    arrays[f"{key}/positions"] = vtk_to_numpy(reader.GetOutput().GetPoints().GetData())
    arrays[f"{key}/triangles"] = triangles_of(reader.GetOutput())


def main():
    job, arrays = json.load(open(sys.argv[1])), {}
    for run, entry in job["runs"].items():
        read_glb(f"{run}/glb", entry["files"]["glb"], entry["times"], job["fps"], arrays)
        for kind in READERS:
            read_mesh(f"{run}/{kind}/0", entry["files"][kind], arrays)
        for i, file in enumerate(entry["sequence"]):
            read_mesh(f"{run}/sequence/{i}", file, arrays)
    np.savez(job["out"], **arrays)


main()
