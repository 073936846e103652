"""Prints as JSON what Blender shows of a file at each frame, and the materials of its objects.

Runs in an environment that has ``bpy``: look.py FILE FRAMES
"""

import json
import sys

import bpy

#: Smaller than this an object shows nothing [Blender units].
NOTHING = 1e-6


def main(path: str, frames: int) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.endswith(".glb"):
        bpy.ops.import_scene.gltf(filepath=path)
    elif path.endswith(".abc"):
        # Alembic counts seconds, too.
        bpy.context.scene.render.fps = 24
        bpy.ops.wm.alembic_import(filepath=path)
    else:
        bpy.ops.wm.usd_import(filepath=path)
    scene = bpy.context.scene
    meshes = [item for item in bpy.data.objects if item.type == "MESH"]
    shown = []
    for frame in range(frames + 1):
        # glTF counts seconds, which Blender turns into frames of the scene's rate.
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        places = {}
        for item in meshes:
            matrix = item.evaluated_get(graph).matrix_world
            if abs(matrix.to_3x3().determinant()) > NOTHING and not item.hide_render:
                places[item.name] = list(matrix.translation)
        shown.append(places)
    materials = {
        item.name: [slot.material and slot.material.name for slot in item.material_slots]
        for item in meshes
    }
    used = {item.name: len({face.material_index for face in item.data.polygons}) for item in meshes}
    answer = {
        "version": bpy.app.version_string,
        "frames": [scene.frame_start, scene.frame_end],
        "fps": scene.render.fps / scene.render.fps_base,
        "shown": shown,
        "materials": materials,
        "used": used,
    }
    print("LOOK " + json.dumps(answer))


main(sys.argv[1], int(sys.argv[2]))
