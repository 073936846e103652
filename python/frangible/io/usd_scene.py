"""A UsdPhysics stage as a scene."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from .._frangible import BuildError
from ..convention import Convention
from ..recording import Float64
from ..scene_lines import PrimSkin
from .reading import FileNote, file_fault
from .usd_bodies import StageBody, find_bodies
from .usd_cameras import stage_cameras
from .usd_colliders import Fit, fit
from .usd_compound import Hulls, body_shape
from .usd_exact import with_exact_fields
from .usd_fracture import fracture_of, voxels_of
from .usd_frames import Frame, affine, frame_of, tidy, tidy_list
from .usd_groups import add_groups
from .usd_looks import has_look
from .usd_mass import Units, density, physics_material
from .usd_mesh import missing_files
from .usd_notes import Notes
from .usd_others import name_others
from .usd_own_mass import own_mass
from .usd_poses import is_animated, keyframes
from .usd_starts import add_start
from .usd_strength import add_vertex_strength
from .usd_stage import metres_from_stage, number_of, open_stage, short_number, time_code

#: Earth's gravity, where a stage leaves it open [m/s^2].
EARTH = 9.81
#: A longer range of times is no length of a shot [frames].
LONGEST = 10_000
#: Of a collider without a physics material. UsdPhysics leaves friction open and restitution 0.
FRICTION, RESTITUTION = 0.5, 0.0


def is_physics_stage(path: str) -> bool:
    """True if a stage has a body or a collider; `BuildError` if it is no stage."""
    if fault := file_fault(path):
        raise BuildError(f"{path}: {fault}")
    with open_stage(path) as stage:
        prims = stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
        return any(
            prim.HasAPI(UsdPhysics.RigidBodyAPI)
            or prim.HasAPI(UsdPhysics.CollisionAPI)
            or prim.IsA(UsdPhysics.Scene)
            for prim in prims
        )


@dataclass(frozen=True, slots=True)
class StageScene:
    """A scene, and what is not in it."""

    fields: dict[str, Any]
    convention: Convention
    #: Of bodies that are no meshes, by their numbers.
    skins: dict[int, PrimSkin]


def read_usd_scene(path: str) -> StageScene:
    """The scene of a stage, with paths of meshes relative to its folder. `FileNote` warnings name
    each kind of thing that a scene cannot hold.

    Of our own stages the fields come back as they were written, where the stage still says the
    same.
    """
    if fault := file_fault(path):
        raise BuildError(f"{path}: {fault}")
    with open_stage(path) as stage:
        importer = _Importer(path, stage)
        scene = importer.scene()
        scene = with_exact_fields(scene, importer.prims, stage, os.path.basename(path))
        convention = _convention(path, stage)
    if not scene["bodies"]:
        said = "; ".join(["has no body with a shape that collides", *importer.notes.sentences()])
        raise BuildError(f"{path}: {said}")
    for sentence in [*importer.missing, *importer.notes.sentences()]:
        warnings.warn(f"{path}: {sentence}", FileNote, stacklevel=2)
    # A body that came back as another shape has its own surface.
    skins = {
        number: skin
        for number, skin in importer.skins.items()
        if scene["bodies"][number]["shape"]["kind"] != "mesh"
    }
    return StageScene(scene, convention, skins)


def stage_convention(path: str) -> Convention:
    """Axes, unit and first time of a stage."""
    with open_stage(path) as stage:
        return _convention(path, stage)


def _convention(path: str, stage: Any) -> Convention:
    frame = metres_from_stage(path, stage)
    start = float(stage.GetStartTimeCode()) if stage.HasAuthoredTimeCodeRange() else 0.0
    up = "y" if frame[1, 1] > 0.0 else "z"
    return Convention(
        up,
        float(np.linalg.norm(frame[0])),
        start if math.isfinite(start) else 0.0,
        stage_cameras(stage, affine(frame.T, np.zeros(3))),
    )


def import_stage(path: str, stage: Any) -> tuple[dict[str, Any], list[Any]]:
    """The scene that a stage says by itself, and the prims of its bodies."""
    importer = _Importer(path, stage)
    return importer.scene(), importer.prims


@dataclass(frozen=True, slots=True)
class _Range:
    """Frames of a stage."""

    start: float
    frames: int | None
    rate: float


class _Importer:
    def __init__(self, path: str, stage: Any) -> None:
        self.path, self.stage = path, stage
        self.notes = Notes()
        self.missing = missing_files(stage)
        #: The prim of each body of the scene, and what those look like that are no meshes.
        self.prims: list[Any] = []
        self.skins: dict[int, PrimSkin] = {}
        self.hulls: Hulls = {}
        self.frame = metres_from_stage(path, stage)
        self.world: Float64 = affine(self.frame.T, np.zeros(3))
        metres = float(np.linalg.norm(self.frame[0]))
        kilograms = number_of(stage, "kilogramsPerUnit", 1.0)
        if not 0.0 < kilograms < math.inf:
            raise BuildError(f"{path}: kilogramsPerUnit: {kilograms}, must be a number > 0")
        self.units = Units(metres, kilograms)
        self.range = self._range()
        self.time = time_code(stage, None)

    def scene(self) -> dict[str, Any]:
        scene: dict[str, Any] = {"gravity": self._gravity()}
        scene["frames_per_second"] = self.range.rate
        if self.range.frames is not None:
            scene["frames"] = self.range.frames
        found = find_bodies(self.stage, self.world, self.time, self.notes)
        scene["bodies"] = []
        bodies = []
        for body in found:
            if (fields := self._body(body, len(self.prims))) is not None:
                scene["bodies"].append(fields)
                self.prims.append(body.prim)
                bodies.append(body)
        add_groups(self.stage, bodies, scene["bodies"], self.notes)
        colliding = {one.prim.GetPath() for body in found for one in body.colliders}
        name_others(self.stage, colliding, self.notes)
        return scene

    def _range(self) -> _Range:
        rate = float(self.stage.GetTimeCodesPerSecond())
        if not 1.0 <= rate <= 1e5:
            raise BuildError(f"{self.path}: timeCodesPerSecond: {rate}, must be between 1 and 1e5")
        if not self.stage.HasAuthoredTimeCodeRange():
            return _Range(0.0, None, rate)
        start, end = self.stage.GetStartTimeCode(), self.stage.GetEndTimeCode()
        frames = round(end - start) if math.isfinite(end - start) else 0
        if frames > LONGEST:
            self.notes.add(f"length of {frames} frames", "endTimeCode", "three seconds instead")
        return _Range(start, frames if 0 < frames <= LONGEST else None, rate)

    def _gravity(self) -> list[float]:
        scenes = [prim for prim in self.stage.Traverse() if prim.IsA(UsdPhysics.Scene)]
        for other in scenes[1:]:
            self.notes.add("a second PhysicsScene", other.GetPath())
        if not scenes:
            return [0.0, -EARTH, 0.0]
        scene = UsdPhysics.Scene(scenes[0])
        direction = np.array(scene.GetGravityDirectionAttr().Get(self.time), np.float64)
        length = short_number(float(scene.GetGravityMagnitudeAttr().Get(self.time)))
        strength = EARTH if length < 0.0 else length * self.units.metres
        if not np.any(direction):
            return [0.0, -strength + 0.0, 0.0]
        turned = self.frame @ direction
        found = strength * turned / np.linalg.norm(turned)
        return tidy_list(found)

    def _body(self, body: StageBody, number: int) -> dict[str, Any] | None:
        """A body of the scene, which gets a number; `None`, with a note, without a shape."""
        moves = body.motion != "static"
        fits = []
        kept = []
        for collider in body.colliders:
            if (found := fit(collider, self.path, self.time, moves, self.notes)) is not None:
                fits.append(found)
                kept.append(collider)
        if not fits:
            if not body.colliders:
                self.notes.add("rigid body without a collider", body.name)
            return None
        body.colliders = kept
        own = frame_of(body.world)
        shape, frame = body_shape(fits, own, body.name, self.hulls, self.notes)
        if shape["kind"] == "mesh":
            shape = {"kind": "mesh", "path": f"{os.path.basename(self.path)}<{body.name}>"}
            if body.motion == "dynamic" and (voxels := voxels_of(body.prim)):
                corners = np.concatenate([one.corners() for one in fits]) @ own.rotation.T
                longest = int(np.argmax(np.ptp(corners, axis=0)))
                need = [voxels if axis == longest else 1 for axis in range(3)]
                shape["resolution"] = {"voxels": need}
        elif any(has_look(collider.prim) for collider in body.colliders):
            rotation = frame.rotation @ own.rotation.T
            origin = (frame.origin - own.origin) @ own.rotation.T
            self.skins[number] = PrimSkin(body.name, rotation.tolist(), origin.tolist())
        fields: dict[str, Any] = {"name": body.name, "shape": shape}
        if body.motion != "dynamic":
            fields["motion"] = body.motion
        if frame.origin.any():
            fields["position"] = tidy_list(frame.origin)
        if (turn := frame.quaternion()) != [0.0, 0.0, 0.0, 1.0]:
            fields["orientation"] = turn
        fracture = fracture_of(body.prim) if body.motion == "dynamic" else {}
        if body.motion != "static":
            self._add_motion(fields, body)
        if body.motion == "dynamic":
            self._add_density(fields, body, fits, shape, "material" in fracture)
            add_vertex_strength(fracture, body, frame, self.path, self.time, self.notes)
            said = {**fields, **fracture}
            if masses := own_mass(said, body, frame, fits, self.units, self.notes):
                fields["mass_properties"] = masses
        elif body.motion == "kinematic" or is_animated(body.prim):
            self._add_poses(fields, body, frame, own)
        self._add_surface(fields, body, "material" in fracture)
        return {**fields, **fracture}

    def _add_motion(self, fields: dict[str, Any], body: StageBody) -> None:
        """Velocities, which are in the space of the prim's parent, and when it starts."""
        api = UsdPhysics.RigidBodyAPI(body.prim)
        parent = body.prim.GetParent()
        above = np.eye(4)
        if parent and not parent.IsPseudoRoot() and not body.is_instanced:
            cache = UsdGeom.XformCache(self.time)
            above = np.array(cache.GetLocalToWorldTransform(parent), np.float64)
        if body.prim.IsA(UsdGeom.Xformable) and UsdGeom.Xformable(body.prim).GetResetXformStack():
            above = np.eye(4)
        linear = api.GetVelocityAttr().Get(self.time)
        angular = api.GetAngularVelocityAttr().Get(self.time)
        if linear is not None and any(linear):
            numbers = np.array([short_number(number) for number in linear])
            moved = numbers @ (above @ self.world)[:3, :3]
            fields["linear_velocity"] = tidy_list(moved)
        if angular is not None and any(angular):
            numbers = np.radians([short_number(number) for number in angular])
            moved = numbers @ frame_of(above @ self.world).rotation
            fields["angular_velocity"] = [number + 0.0 for number in moved.tolist()]
        add_start(fields, body, self.range.start, self.time, self.notes)

    def _add_density(
        self,
        fields: dict[str, Any],
        body: StageBody,
        fits: list[Fit],
        shape: dict[str, Any],
        has_material: bool,
    ) -> None:
        says_so = any(
            prim.HasAPI(UsdPhysics.MassAPI)
            for prim in (body.prim, *(collider.prim for collider in body.colliders))
        ) or any(physics_material(collider.prim) is not None for collider in body.colliders)
        if has_material and not says_so:
            return
        found = density(body, fits, shape, self.path, self.time, self.units, self.notes)
        if found is not None:
            fields["density"] = tidy(found)

    def _add_surface(self, fields: dict[str, Any], body: StageBody, has_material: bool) -> None:
        """Friction and restitution of the colliders, which are one body's."""
        found = []
        for collider in body.colliders:
            prim = physics_material(collider.prim)
            if prim is None:
                found.append((FRICTION, RESTITUTION))
                continue
            api = UsdPhysics.MaterialAPI(prim)
            still, sliding, restitution = (
                short_number(float(attribute.Get(self.time) or 0.0))
                for attribute in (
                    api.GetStaticFrictionAttr(),
                    api.GetDynamicFrictionAttr(),
                    api.GetRestitutionAttr(),
                )
            )
            if still != sliding:
                self.notes.add("static friction of its own", prim.GetPath(), "the dynamic one")
            found.append((sliding, min(max(restitution, 0.0), 1.0)))
        if len(set(found)) > 1:
            self.notes.add(
                "colliders of several physics materials in a body",
                body.name,
                "have the first one's",
            )
        if has_material and all(
            physics_material(collider.prim) is None for collider in body.colliders
        ):
            return
        fields["friction"], fields["restitution"] = found[0]

    def _add_poses(self, fields: dict[str, Any], body: StageBody, shape: Frame, own: Frame) -> None:
        if not is_animated(body.prim) or self.range.frames is None:
            return
        if body.motion == "static":
            self.notes.add(
                "animated collider that is no kinematic body", body.name, "stays where it is first"
            )
        else:
            fields["path"] = keyframes(
                body.prim, shape, own, self.world, self.range.start, self.range.frames
            )
