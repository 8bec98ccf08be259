"""Reads exported .msh files with Gmsh, for tests/check_exports.py: with_gmsh.py JOB.json"""

import json
import sys

import gmsh
import numpy as np


def read(key, file, arrays):
    """Mesh, groups, and the fields with their times."""
    gmsh.clear()
    gmsh.open(file)
    tags, positions, _ = gmsh.model.mesh.getNodes()
    arrays[f"{key}/positions"] = positions.reshape(-1, 3)[np.argsort(tags)]
    elements, corners = gmsh.model.mesh.getElementsByType(2)
    arrays[f"{key}/triangles"] = corners.reshape(-1, 3).astype(int)[np.argsort(elements)] - 1
    for dimension, group in gmsh.model.getPhysicalGroups():
        arrays[f"{key}/group/{gmsh.model.getPhysicalName(dimension, group)}/{dimension}"] = np.sort(gmsh.model.mesh.getNodesForPhysicalGroup(dimension, group)[0]).astype(int) - 1
    for view in gmsh.view.getTags():
        name = gmsh.option.getString(f"View[{gmsh.view.getIndex(view)}].Name")
        frames = int(gmsh.option.getNumber(f"View[{gmsh.view.getIndex(view)}].NbTimeStep"))
        for i in range(frames):
            kind, places, values, time, _ = gmsh.view.getModelData(view, i)
            values = np.array(values)[np.argsort(places)]
            arrays[f"{key}/field/{name.split(' ')[0]}/{i}"] = values
            arrays[f"{key}/field/{name.split(' ')[0]}/{i}/time"] = np.array(time)


def main():
    job, arrays = json.load(open(sys.argv[1])), {}
    gmsh.initialize(["gmsh"])
    gmsh.option.setNumber("General.Terminal", 0)
    for run, entry in job["runs"].items():
        for k, file in enumerate(entry["msh"]):
            read(f"{run}/msh/{k}", file, arrays)
    gmsh.finalize()
    np.savez(job["out"], **arrays)


main()
