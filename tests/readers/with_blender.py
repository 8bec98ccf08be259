"""Reads exported files with Blender, for tests/check_exports.py: blender -b --factory-startup --python with_blender.py -- JOB.json"""

import json
import sys

import addon_utils
import bpy
import numpy as np

# The glTF importer of Blender 3.4 uses a name that the NumPy of the same Debian has dropped.
np.bool = bool


def empty(fps):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = fps


def shown():
    """Positions in the world and triangles of all objects that have an extent, as they are drawn, by their names backwards: sheet, bodies."""
    graph = bpy.context.evaluated_depsgraph_get()
    positions, triangles, first = [], [], 0
    for thing in sorted((o for o in bpy.context.scene.objects if o.type == "MESH"), key=lambda o: o.name, reverse=True):
        drawn = thing.evaluated_get(graph)
        mesh, world = drawn.to_mesh(), np.array(drawn.matrix_world)
        x, corners = np.empty(3 * len(mesh.vertices), np.float32), np.empty(len(mesh.loops), np.int32)
        mesh.vertices.foreach_get("co", x)
        mesh.loops.foreach_get("vertex_index", corners)
        x = x.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
        if np.ptp(x) > 0:
            positions.append(x)
            triangles.append(corners.reshape(-1, 3) + first)
            first += len(x)
        drawn.to_mesh_clear()
    return np.vstack(positions), np.vstack(triangles)


def put(arrays, key):
    arrays[f"{key}/positions"], arrays[f"{key}/triangles"] = shown()


def at(frame):
    """Goes to a frame that may lie between two."""
    bpy.context.scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))


def read_glb(key, file, times, fps, arrays):
    empty(fps)
    bpy.ops.import_scene.gltf(filepath=file)
    ends = [end for action in bpy.data.actions for end in action.frame_range]
    arrays[f"{key}/frames"] = np.array([min(ends), max(ends)])
    for i, time in enumerate(times):
        at(time * fps)
        put(arrays, f"{key}/{i}")


def read_meshes(key, files, arrays):
    for kind, read in (("obj", lambda f: bpy.ops.wm.obj_import(filepath=f, forward_axis="Y", up_axis="Z")),
                       ("stl", lambda f: bpy.ops.import_mesh.stl(filepath=f)), ("ply", lambda f: bpy.ops.import_mesh.ply(filepath=f))):
        empty(25)
        read(files[kind])
        put(arrays, f"{key}/{kind}/0")


def moved(kind, file, mesh, fps):
    """The mesh at the first step with the modifier that moves it; returns the modifier."""
    empty(fps)
    bpy.ops.wm.obj_import(filepath=mesh, forward_axis="Y", up_axis="Z")
    modifier = bpy.context.scene.objects[0].modifiers.new("motion", "MESH_CACHE")
    modifier.cache_format, modifier.filepath, modifier.interpolation = kind.upper(), file, "NONE"
    return modifier


def read_cache(key, kind, entry, fps, arrays):
    """Frame by frame, as sampled."""
    modifier = moved(kind, entry["files"][kind], entry["caches"][kind], fps)
    modifier.frame_start = 0
    for i in range(len(entry["times"])):
        at(i)
        put(arrays, f"{key}/{i}")


def read_mdd_in_time(key, entry, fps, arrays):
    """At the times that the file says, which only MDD does."""
    modifier = moved("mdd", entry["files"]["mdd"], entry["caches"]["mdd"], fps)
    modifier.play_mode, modifier.time_mode = "CUSTOM", "TIME"
    for i, time in enumerate(entry["times"]):
        modifier.eval_time = np.float32(time)
        bpy.context.view_layer.update()
        put(arrays, f"{key}/{i}")


def read_mdd_as_shapes(key, entry, fps, arrays):
    """The importer that makes a shape of every frame."""
    empty(fps)
    bpy.ops.wm.obj_import(filepath=entry["caches"]["mdd"], forward_axis="Y", up_axis="Z")
    addon_utils.enable("io_shape_mdd")
    bpy.context.view_layer.objects.active = bpy.context.scene.objects[0]
    bpy.ops.import_shape.mdd(filepath=entry["files"]["mdd"], frame_start=0, frame_step=1)
    for i in range(len(entry["times"])):
        at(i)
        put(arrays, f"{key}/{i}")


def main():
    job, arrays = json.load(open(sys.argv[sys.argv.index("--") + 1])), {}
    for run, entry in job["runs"].items():
        read_glb(f"{run}/glb", entry["files"]["glb"], entry["times"], job["fps"], arrays)
        read_meshes(run, entry["files"], arrays)
        for kind in entry["caches"]:
            read_cache(f"{run}/{kind}", kind, entry, job["fps"], arrays)
        if entry["caches"]:
            read_mdd_in_time(f"{run}/mdd_times", entry, job["fps"], arrays)
            read_mdd_as_shapes(f"{run}/mdd_shapes", entry, job["fps"], arrays)
    np.savez(job["out"], **arrays)


main()
