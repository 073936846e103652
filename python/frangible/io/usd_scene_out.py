"""A scene as a UsdPhysics stage, which `usd_scene` reads back without loss."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from .. import _frangible
from ..material_presets import PRESETS
from ..names import unique_names
from ..recording import Float64
from ..scene_fields import with_relative_paths
from ..scene_materials import with_materials
from .mesh_files import readable_mesh
from .usd_exact import keep_exact_fields
from .usd_fracture import write_fracture
from .usd_frames import rotation_of
from .usd_groups import write_filtered_pairs
from .usd_own_mass import write_own_mass
from .usd_scene import import_stage
from .usd_stage import mark
from .usd_starts import write_start

#: The marker of a stage that a scene was written as.
SCENE = "scene"
#: Half the side of the square that an endless plane is drawn as [m].
PLANE = 50.0


def write_usd_scene(scene: dict[str, Any], path: str, final: str) -> None:
    """Write ``.usda`` or ``.usdc``, in metres and kilograms, y up. ``final`` is the name that the
    file gets: paths of files in its folder become relative to it."""
    exact = with_relative_paths(scene, final)
    resolved = with_materials(scene)
    fields = _frangible.scene_schema()["properties"]
    rate = float(resolved.get("frames_per_second") or fields["frames_per_second"]["default"])

    # The stage as other programs read it.
    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    if resolved.get("frames") is not None:
        stage.SetStartTimeCode(0.0)
        stage.SetEndTimeCode(float(resolved["frames"]))
    mark(stage, SCENE)
    root = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(root)
    _write_gravity(stage, resolved.get("gravity") or fields["gravity"]["default"])
    writer = _Writer(stage)
    names = ["PhysicsScene", "PhysicsMaterials"]
    names += [str(body.get("name") or "body").rpartition("/")[2] for body in resolved["bodies"]]
    own_names = list(unique_names(names))[2:]
    for body, said, name in zip(resolved["bodies"], scene["bodies"], own_names, strict=True):
        # Materials of the scene's own are no other program's: what they decide is written.
        is_preset = _has_preset(said, scene)
        writer.write(f"/World/{name}", body, {**body, **said} if is_preset else body)

    paths = [f"/World/{name}" for name in own_names]
    write_filtered_pairs(stage, paths, resolved["bodies"])

    # What it says otherwise than the scene is kept beside it.
    read, prims = import_stage(path, stage)
    file = os.path.basename(path)
    for body, back, prim in zip(exact["bodies"], read.pop("bodies"), prims, strict=True):
        keep_exact_fields(prim, body, back, file)
    keep_exact_fields(
        root, {field: exact[field] for field in exact if field != "bodies"}, read, file
    )
    stage.GetRootLayer().Save()


def _has_preset(body: dict[str, Any], scene: dict[str, Any]) -> bool:
    name = body.get("material")
    return isinstance(name, str) and name in PRESETS and name not in (scene.get("materials") or {})


def _write_gravity(stage: Any, gravity: list[float]) -> None:
    scene = UsdPhysics.Scene.Define(stage, "/World/PhysicsScene")
    length = math.hypot(*gravity)
    scene.CreateGravityMagnitudeAttr(length)
    if length > 0.0:
        direction = [number / length for number in gravity]
        scene.CreateGravityDirectionAttr(Gf.Vec3f(*direction))


class _Writer:
    def __init__(self, stage: Any) -> None:
        self.stage = stage
        self.defaults = _frangible.scene_schema()["$defs"]["BodyDesc"]["properties"]
        #: Materials by friction and restitution.
        self.materials: dict[tuple[float, float], Any] = {}

    def write(self, path: str, body: dict[str, Any], said: dict[str, Any]) -> None:
        """A body with all that its material decides, and as its schema shall say it."""
        shape = body["shape"]
        place = np.array(self._value(body, "position"), np.float64)
        turn = [float(number) for number in self._value(body, "orientation")]
        if shape["kind"] == "cone":
            # USD's is placed by the middle of its height.
            place = place + 0.25 * shape["height"] * rotation_of(turn)[1]
        colliders = self._shape(path, shape)
        prim = self.stage.GetPrimAtPath(path)
        _place(UsdGeom.Xformable(prim), place, turn, _sizes(shape))
        motion = body.get("motion", "dynamic")
        for collider in colliders:
            UsdPhysics.CollisionAPI.Apply(collider)
            self._bind(collider, body)
        if motion == "static":
            return
        api = UsdPhysics.RigidBodyAPI.Apply(prim)
        if motion == "kinematic":
            api.CreateKinematicEnabledAttr(True)
        linear = self._value(body, "linear_velocity")
        angular = self._value(body, "angular_velocity")
        if any(linear):
            api.CreateVelocityAttr(Gf.Vec3f(*[float(number) for number in linear]))
        if any(angular):
            turned = [math.degrees(number) for number in angular]
            api.CreateAngularVelocityAttr(Gf.Vec3f(*turned))
        if motion == "dynamic":
            UsdPhysics.MassAPI.Apply(prim).CreateDensityAttr(float(self._value(body, "density")))
            write_own_mass(prim, body)
            write_start(prim, body)
            write_fracture(prim, said)

    def _value(self, body: dict[str, Any], field: str) -> Any:
        value = body.get(field)
        return self.defaults[field]["default"] if value is None else value

    def _shape(self, path: str, shape: dict[str, Any]) -> list[Any]:
        """The prims that collide, of which the first or their parent is at the path."""
        match shape["kind"]:
            case "half-space":
                plane = UsdGeom.Plane.Define(self.stage, path)
                plane.CreateAxisAttr("Y")
                plane.CreateWidthAttr(2.0 * PLANE)
                plane.CreateLengthAttr(2.0 * PLANE)
                return [plane.GetPrim()]
            case "box":
                cube = UsdGeom.Cube.Define(self.stage, path)
                cube.CreateSizeAttr(1.0)
                return [cube.GetPrim()]
            case "sphere":
                sphere = UsdGeom.Sphere.Define(self.stage, path)
                sphere.CreateRadiusAttr(float(shape["radius"]))
                return [sphere.GetPrim()]
            case "cylinder" | "capsule" | "cone" as kind:
                define = getattr(UsdGeom, kind.capitalize()).Define
                round_shape = define(self.stage, path)
                round_shape.CreateAxisAttr("Y")
                round_shape.CreateRadiusAttr(float(shape["radius"]))
                round_shape.CreateHeightAttr(float(shape["height"]))
                return [round_shape.GetPrim()]
            case "compound":
                UsdGeom.Xform.Define(self.stage, path)
                return [
                    self._part(f"{path}/part_{index}", part)
                    for index, part in enumerate(shape["parts"])
                ]
            case _:
                return [self._mesh(path, shape)]

    def _part(self, path: str, part: dict[str, Any]) -> Any:
        (prim,) = self._shape(path, part)
        place = np.array(part.get("position") or [0.0] * 3, np.float64)
        turn = [float(number) for number in part.get("orientation") or [0.0, 0.0, 0.0, 1.0]]
        _place(UsdGeom.Xformable(prim), place, turn, _sizes(part))
        return prim

    def _mesh(self, path: str, shape: dict[str, Any]) -> Any:
        points, triangles = _surface(shape)
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        single = np.ascontiguousarray(points, np.float32)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(single))
        counts = np.full(len(triangles), 3, np.int32)
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
        corners = np.ascontiguousarray(triangles, np.int32).ravel()
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
        low, high = single.min(axis=0).tolist(), single.max(axis=0).tolist()
        mesh.CreateExtentAttr([Gf.Vec3f(*low), Gf.Vec3f(*high)])
        if shape["kind"] == "hull":
            api = UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim())
            api.CreateApproximationAttr("convexHull")
        return mesh.GetPrim()

    def _bind(self, prim: Any, body: dict[str, Any]) -> None:
        key = float(self._value(body, "friction")), float(self._value(body, "restitution"))
        if key not in self.materials:
            path = f"/World/PhysicsMaterials/material_{len(self.materials)}"
            material = UsdShade.Material.Define(self.stage, path)
            api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
            api.CreateStaticFrictionAttr(key[0])
            api.CreateDynamicFrictionAttr(key[0])
            api.CreateRestitutionAttr(key[1])
            self.materials[key] = material
        binding = UsdShade.MaterialBindingAPI.Apply(prim)
        strength = UsdShade.Tokens.weakerThanDescendants
        binding.Bind(self.materials[key], strength, "physics")


def _sizes(shape: dict[str, Any]) -> list[float] | None:
    return shape["size"] if shape["kind"] == "box" else None


def _place(xform: Any, place: Float64, turn: list[float], sizes: list[float] | None) -> None:
    double = UsdGeom.XformOp.PrecisionDouble
    x, y, z, w = turn
    xform.AddTranslateOp(double).Set(Gf.Vec3d(*place.tolist()))
    xform.AddOrientOp(double).Set(Gf.Quatd(w, x, y, z).GetNormalized())
    if sizes is not None:
        xform.AddScaleOp(double).Set(Gf.Vec3d(*[float(size) for size in sizes]))


def _surface(shape: dict[str, Any]) -> tuple[Float64, Any]:
    """Points and triangles of a shape that is no closed form, in its frame [m]."""
    if shape["kind"] == "mesh":
        with readable_mesh(str(shape["path"])) as plain:
            points, triangles = _frangible.load_mesh(plain)
        return np.asarray(points) * float(shape.get("scale") or 1.0), triangles
    if shape["kind"] == "triangles":
        return np.array(shape["positions"], np.float64), np.array(shape["triangles"])
    if shape["kind"] == "heightfield":
        return _heightfield(shape)
    # The core knows the faces of a hull.
    points = np.array(shape["points"], np.float64)
    body = {"shape": {"kind": "hull", "points": points.tolist()}, "motion": "static"}
    world = _frangible.World.build({"bodies": [body]}, 1)
    (only,) = world.ids.tolist()
    vertices, triangles, *_ = world.surface(only)
    place, turn = world.positions[0], world.orientations[0]
    return vertices @ rotation_of(turn.tolist()) + place, triangles


def _heightfield(shape: dict[str, Any]) -> tuple[Float64, Any]:
    heights = np.array(shape["heights"], np.float64)
    rows, columns = heights.shape
    across, along = shape["spacing"]
    z, x = np.meshgrid(
        (np.arange(rows) - 0.5 * (rows - 1)) * along,
        (np.arange(columns) - 0.5 * (columns - 1)) * across,
        indexing="ij",
    )
    points = np.stack([x, heights, z], axis=-1).reshape(-1, 3)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    near = np.stack([first, first + columns, first + 1], axis=1)
    far = np.stack([first + 1, first + columns, first + columns + 1], axis=1)
    return points, np.concatenate([near, far])
