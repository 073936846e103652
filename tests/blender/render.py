"""Renders a frame of a file in Blender, and prints as JSON what it shows there.

Runs in an environment that has ``bpy``: render.py FILE FRAME PICTURE
"""

import json
import math
import sys

import bpy
from mathutils import Vector

#: Smaller than this an object shows nothing [Blender units].
NOTHING = 1e-6
#: Of the picture.
WIDTH, HEIGHT, SAMPLES = 480, 270, 16
#: Half of what a camera sees, from its axis [rad].
HALF_VIEW = 0.32


def main(path: str, frame: int, picture: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=path)
    scene = bpy.context.scene
    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    shown = []
    for item in bpy.data.objects:
        if item.type == "MESH":
            matrix = item.evaluated_get(graph).matrix_world
            if abs(matrix.to_3x3().determinant()) > NOTHING and not item.hide_render:
                shown.append((item, matrix.copy()))

    # The pieces, and not the ground, fill the picture.
    corners = [
        matrix @ Vector(corner)
        for item, matrix in shown
        if max(item.dimensions) < 5.0
        for corner in item.bound_box
    ]
    low, high = (Vector([choose(corner[k] for corner in corners) for k in range(3)]) for choose in (min, max))
    middle, radius = 0.5 * (low + high), 0.5 * (high - low).length
    add_camera(scene, middle, radius)
    add_light(scene)
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)
    materials = sorted({slot.material.name for item, _ in shown for slot in item.material_slots if slot.material})
    print("RENDERED " + json.dumps({"shown": len(shown), "materials": materials}))


def add_camera(scene, middle: Vector, radius: float) -> None:
    direction = Vector((-0.5, -1.0, 0.55)).normalized()
    camera = bpy.data.cameras.new("camera")
    camera.angle = 2.0 * HALF_VIEW
    item = bpy.data.objects.new("camera", camera)
    item.location = middle + radius / math.sin(HALF_VIEW) * direction
    item.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(item)
    scene.camera = item


def add_light(scene) -> None:
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy = 3.0
    sun.angle = 0.05
    item = bpy.data.objects.new("sun", sun)
    item.rotation_euler = (0.7, 0.2, 0.4)
    scene.collection.objects.link(item)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.5, 0.6, 0.8, 1.0)
    world.node_tree.nodes["Background"].inputs[1].default_value = 0.5
    scene.world = world


main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
