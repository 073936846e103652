"""Runs in Blender, or in a Python that has ``bpy``: blender_scene.py JOB draws what `blender` asks.

It imports nothing of the package.
"""

import json
import math
import os
import sys
from typing import Any

import bpy
from mathutils import Matrix, Vector

#: Apparent width of the lamp: soft shadows, as of a large window [degrees].
LAMP_WIDTH = 4.0
#: Half the height of the film behind a lens [mm].
HALF_FILM = 12.0
#: Reaches to the horizon, over the camera's distance.
FAR = 300.0


def main(job: dict[str, Any]) -> None:
    """Draw each frame of a job, and say so."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=job["stage"], import_cameras=False, import_lights=False)
    scene = bpy.context.scene
    for material in bpy.data.materials:
        _let_light_through(material)
    for floor in job["floors"]:
        _add_floor(scene, floor, job)
    _add_lamp(scene, job)
    _add_sky(scene, job)
    _add_camera(scene, job)
    _set_renderer(scene, job)
    for index, frame in enumerate(job["frames"]):
        scene.frame_set(frame)
        path = os.path.join(job["folder"], f"{index}.png")
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        print(f"FRANGIBLE PICTURE {path}", flush=True)


def z_up(vector: list[float]) -> Vector:
    """Blender's axes, to which it turns what it imports."""
    x, y, z = vector
    return Vector((x, -z, y))


def _let_light_through(material: Any) -> None:
    """What is half opaque in USD is clear glass in Blender."""
    nodes = material.node_tree.nodes if material.node_tree else ()
    for node in (one for one in nodes if one.type == "BSDF_PRINCIPLED"):
        alpha = node.inputs["Alpha"]
        if not alpha.is_linked and alpha.default_value < 1.0:
            alpha.default_value = 1.0
            node.inputs["Transmission Weight"].default_value = 1.0
            node.inputs["IOR"].default_value = 1.45


def _add_floor(scene: Any, floor: dict[str, Any], job: dict[str, Any]) -> None:
    half = FAR * job["distance"]
    mesh = bpy.data.meshes.new("floor")
    corners = [(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new("floor")
    material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*job["floor_colour"], 1.0)
    surface.inputs["Roughness"].default_value = 0.8
    mesh.materials.append(material)
    item = bpy.data.objects.new("floor", mesh)
    item.rotation_mode = "QUATERNION"
    item.rotation_quaternion = z_up(floor["normal"]).to_track_quat("Z", "Y")
    item.location = z_up(floor["middle"])
    scene.collection.objects.link(item)


def _add_lamp(scene: Any, job: dict[str, Any]) -> None:
    lamp = bpy.data.lights.new("lamp", "SUN")
    strongest = max(job["lamp_colour"])
    lamp.color = [part / strongest for part in job["lamp_colour"]]
    # A white surface that faces it sends back its colour.
    lamp.energy = math.pi * strongest
    lamp.angle = math.radians(LAMP_WIDTH)
    item = bpy.data.objects.new("lamp", lamp)
    item.rotation_mode = "QUATERNION"
    item.rotation_quaternion = z_up(job["lamp"]).to_track_quat("Z", "Y")
    scene.collection.objects.link(item)


def _add_sky(scene: Any, job: dict[str, Any]) -> None:
    """Haze at the horizon, darker above, for the camera; an even sky for what it lights."""
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    seen = nodes["Background"]
    light = nodes.new("ShaderNodeBackground")
    light.inputs["Color"].default_value = (*job["sky_colour"], 1.0)
    ramp = nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color = (*job["haze"], 1.0)
    ramp.color_ramp.elements[1].color = (*job["zenith"], 1.0)
    ramp.color_ramp.elements[1].position = 0.45
    direction = nodes.new("ShaderNodeTexCoord")
    height = nodes.new("ShaderNodeSeparateXYZ")
    links.new(direction.outputs["Generated"], height.inputs[0])
    links.new(height.outputs["Z"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], seen.inputs["Color"])
    path = nodes.new("ShaderNodeLightPath")
    mix = nodes.new("ShaderNodeMixShader")
    links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    links.new(light.outputs[0], mix.inputs[1])
    links.new(seen.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes["World Output"].inputs["Surface"])


def _add_camera(scene: Any, job: dict[str, Any]) -> None:
    lens = bpy.data.cameras.new("view")
    lens.sensor_fit = "VERTICAL"
    lens.sensor_height = 2.0 * HALF_FILM
    lens.clip_start = 1e-4 * job["distance"]
    lens.clip_end = 2.0 * FAR * job["distance"]
    item = bpy.data.objects.new("view", lens)
    item.rotation_mode = "QUATERNION"
    scene.collection.objects.link(item)
    scene.camera = item
    before = None
    for camera in job["cameras"]:
        item.location = z_up(camera["eye"])
        right, up, forward = (z_up(axis) for axis in camera["axes"])
        turn = Matrix((right, up, -forward)).transposed().to_quaternion()
        if before is not None and before.dot(turn) < 0.0:
            turn.negate()
        item.rotation_quaternion = before = turn
        lens.lens = HALF_FILM / camera["half_height"]
        if len(job["cameras"]) > 1:
            for holder, name in (
                (item, "location"), (item, "rotation_quaternion"), (lens, "lens"),
            ):  # fmt: skip
                holder.keyframe_insert(name, frame=camera["time"])


def _set_renderer(scene: Any, job: dict[str, Any]) -> None:
    scene.render.engine = "CYCLES"
    scene.cycles.samples = job["rays"]
    scene.cycles.use_denoising = True
    scene.cycles.seed = 0
    scene.render.use_persistent_data = True
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Punchy"
    scene.view_settings.exposure = 0.3
    if job["shutter"] > 0.0:
        scene.render.use_motion_blur = True
        scene.render.motion_blur_shutter = job["shutter"]
        scene.render.motion_blur_position = "END"


if __name__ == "__main__":
    with open(sys.argv[-1], encoding="utf-8") as file:
        main(json.load(file))
