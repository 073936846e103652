"""A scene of one mesh: what breaks, and what it is struck with, where and when."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from . import _frangible
from ._frangible import BuildError
from .first_touch import first_touch
from .io.mesh_files import USD_ENDINGS, check_ending, mesh_frame, mesh_strength, readable_mesh
from .io.reading import file_fault
from .material_presets import PRESETS
from .recording import Float64
from .scene_types import Body, Bonds, Breaking, HalfSpace, Look, Mesh, SceneDesc, Sphere, Starts
from .words import did_you_mean

#: Metres in a unit.
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048}
#: Half a turn back: z of a file goes up.
_Z_UP = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
#: Flight of a ball to which nobody gave a place or a time [s].
FLIGHT = 0.5
#: In which the way to the first touch of a falling ball is found: each leaves a tenth of the error
#: or less.
ROUNDS = 12
#: How long a scene goes on after the blow [s].
AFTER = 2.0
#: Of the earth [m/s^2].
GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Wishes:
    """What somebody wants of one mesh; lengths and places are the file's, in its unit and axes."""

    #: A preset of materials.
    material: str = "concrete"
    #: Kind of a pattern, or a file.
    pattern: str | None = None
    pieces: int | None = None
    #: An impulse [N s], or a material of the core's table.
    strength: float | str | None = None
    #: How far a break reaches from its blow, in the file's unit; the rest stays whole.
    reach: float | None = None
    #: What the glue between the file's closed parts, or a pattern's pieces, bears [Pa].
    glue: float | None = None
    #: Radius, and speed [m/s].
    ball: tuple[float, float] | None = None
    #: Where the ball comes from.
    origin: tuple[float, float, float] | None = None
    hit_at_frame: int | None = None
    ground: bool = False
    #: Downwards [m/s^2].
    gravity: float = GRAVITY
    #: What it looks like, if not like its material.
    look: Look | None = None
    up: Literal["y", "z"] | None = None
    #: A name of `UNITS`.
    unit: str | None = None
    frames_per_second: float = 30.0
    #: Of open parts, in the file's unit.
    thickness: float | None = None
    seed: int | None = None


def mesh_scene(path: str | os.PathLike[str], wishes: Wishes) -> SceneDesc:
    """The scene; `BuildError` for a file that is no mesh, or wishes that do not go together."""
    name = os.fspath(path)
    check_ending(name)
    _check(name, wishes)
    frame, scale, orientation = _frame(name, wishes)
    points, triangles = _points(name)
    # USD is read in metres, y up.
    world: Float64 = points if name.lower().endswith(USD_ENDINGS) else points @ frame.T
    low, high = world.min(axis=0), world.max(axis=0)
    painted = mesh_strength(name) if name.lower().endswith(USD_ENDINGS) else {}

    mesh = Body(
        Mesh(os.path.abspath(name), scale=scale, thickness=_thickness(frame, wishes)),
        name=os.path.splitext(os.path.basename(name))[0],
        material=wishes.material,
        orientation=orientation,
        breaking=None if wishes.glue is not None else _breaking(wishes, frame, painted),
        bonds=_bonds(wishes, painted),
        look=wishes.look,
    )
    bodies = [mesh]
    if wishes.ground:
        ground = Body(HalfSpace(), name="ground", motion="static", position=[0, float(low[1]), 0])
        bodies.insert(0, ground)
    frames = None
    if wishes.ball is not None:
        # What has no foot to stand on would tip over before the ball arrives.
        mesh.starts = Starts(when="struck")
        flight = _Flight(wishes, frame, world, triangles, 0.5 * (low + high))
        if wishes.ground and flight.start[1] - flight.radius < low[1]:
            raise BuildError(
                f"from: the ball would start {low[1] - flight.start[1] + flight.radius:.3g} m deep "
                "in the ground, must come from higher up, or faster, or hit sooner"
            )
        bodies.append(flight.body())
        if wishes.hit_at_frame is not None:
            frames = wishes.hit_at_frame + math.ceil(AFTER * wishes.frames_per_second)
    gravity = None if wishes.gravity == GRAVITY else [0.0, -wishes.gravity, 0.0]
    rate = wishes.frames_per_second
    return SceneDesc(bodies, frames_per_second=rate, frames=frames, gravity=gravity)


def _check(name: str, wishes: Wishes) -> None:
    if wishes.material not in PRESETS:
        near = did_you_mean(wishes.material, PRESETS)
        rule = f"must be one of {', '.join(PRESETS)}; a scene file has materials of your own"
        raise BuildError(f"material: {wishes.material!r}{near}, {rule}")
    if not name.lower().endswith(USD_ENDINGS) and (fault := file_fault(name)):
        raise BuildError(f"{name}: {fault}")
    if wishes.ball is None:
        needing: dict[str, Any] = {"from": wishes.origin, "hit_at_frame": wishes.hit_at_frame}
        for option, given in needing.items():
            if given is not None:
                raise BuildError(f"{option}: {given}, must come with a ball")
        if not wishes.ground:
            is_stage = name.lower().endswith(USD_ENDINGS)
            kind = (
                "is a stage without physics, so one mesh, which" if is_stage else "is a mesh that"
            )
            raise BuildError(
                f"{name}: {kind} would fall for ever, must have a ball to be struck with (--ball), "
                "or ground to stand on (--ground)"
            )
    elif not all(0.0 < number < math.inf for number in wishes.ball):
        raise BuildError(f"ball: {wishes.ball}, must be a radius and a speed > 0")
    if wishes.unit is not None and wishes.unit not in UNITS:
        rule = f"must be one of {', '.join(UNITS)}"
        raise BuildError(f"unit: {wishes.unit!r}{did_you_mean(wishes.unit, UNITS)}, {rule}")
    if name.lower().endswith(USD_ENDINGS):
        for option, said in (("unit", wishes.unit), ("up", wishes.up)):
            if said is not None:
                raise BuildError(f"{option}: {said}, must be left out for USD, which says it")


def _frame(
    name: str, wishes: Wishes
) -> tuple[Float64, float | None, tuple[float, float, float, float] | None]:
    """The matrix that takes the file's places to the world's, and the scale and orientation of the
    body."""
    if name.lower().endswith(USD_ENDINGS):
        return mesh_frame(name), None, None
    scale = UNITS[wishes.unit or "m"]
    if wishes.up != "z":
        return np.diag([scale] * 3), scale, None
    return scale * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), scale, _Z_UP


def _points(name: str) -> tuple[Float64, Float64]:
    with readable_mesh(name) as plain:
        vertices, triangles = _frangible.load_mesh(plain)
    return np.asarray(vertices, np.float64), np.asarray(triangles)


def _breaking(
    wishes: Wishes, frame: Float64, painted: dict[str, list[Any]]
) -> Breaking | None:
    """As far as it is wished, and painted on the mesh: the material decides the rest."""
    fields: dict[str, Any] = {
        "pattern": _pattern(wishes),
        "strength": wishes.strength,
        "pieces": wishes.pieces,
        "reach": None if wishes.reach is None else wishes.reach * _unit(frame),
    }
    if all(value is None for value in fields.values()):
        breaks = "strength" in PRESETS[wishes.material]
        return Breaking.from_dict(painted) if painted and breaks else None
    if "strength" not in PRESETS[wishes.material] and None in (
        fields["pattern"],
        fields["strength"],
    ):
        raise BuildError(
            f"material: {wishes.material!r} does not break, must come with a strength and a pattern"
        )
    return Breaking.from_dict({**fields, **painted})


def _bonds(wishes: Wishes, painted: dict[str, list[Any]]) -> Bonds | None:
    """Glue between the file's parts or, if one is wished, the pieces of a pattern."""
    if wishes.glue is None:
        return None
    others = {"strength": wishes.strength, "pieces": wishes.pieces, "reach": wishes.reach}
    for option, given in others.items():
        if given is not None:
            raise BuildError(f"{option}: {given}, must be left out with glue")
    pattern = None if wishes.pattern is None else _pattern(wishes)
    fields = {"pattern": pattern, "tensile_strength": wishes.glue, "shear_strength": wishes.glue}
    said = {name: field for name, field in fields.items() if field is not None}
    return Bonds.from_dict({**said, **painted})


def _pattern(wishes: Wishes) -> dict[str, Any] | None:
    """The pattern that is wished, or the material's own with another seed."""
    name, kinds = wishes.pattern, dict(_frangible.patterns())
    seed = {} if wishes.seed is None else {"seed": wishes.seed}
    if name is None:
        own = PRESETS[wishes.material].get("pattern")
        return {**own, **seed} if own is not None and seed else None
    if name in kinds:
        return {"kind": name, **seed}
    if not os.path.exists(name):
        rule = f"must be one of {', '.join(kinds)}, or a file"
        raise BuildError(f"pattern: {name!r}{did_you_mean(name, kinds)}, {rule}")
    return {"kind": "file", "path": os.path.abspath(name)}


def _thickness(frame: Float64, wishes: Wishes) -> float | None:
    return None if wishes.thickness is None else wishes.thickness * _unit(frame)


def _unit(frame: Float64) -> float:
    """Metres in the file's unit."""
    return float(np.linalg.norm(frame[:, 0]))


class _Flight:
    """Of a ball to the middle of a mesh."""

    def __init__(
        self,
        wishes: Wishes,
        frame: Float64,
        points: Float64,
        triangles: Float64,
        target: Float64,
    ) -> None:
        assert wishes.ball is not None
        self.radius, self.speed = _unit(frame) * wishes.ball[0], wishes.ball[1]
        self.gravity = np.array([0.0, -wishes.gravity, 0.0])
        origin = None if wishes.origin is None else frame @ np.array(wishes.origin)
        direction = np.array([0.0, 0.0, -1.0]) if origin is None else target - origin
        length = float(np.linalg.norm(direction))
        if not length > 0.0:
            raise BuildError(f"from: {wishes.origin}, must not be the middle of the mesh")
        mesh = points, triangles
        self.direction = direction / length
        if wishes.hit_at_frame is not None:
            # In the middle of the step to that frame. It starts farther away on the same line.
            self.time = (wishes.hit_at_frame - 0.5) / wishes.frames_per_second
            touch = self._touch(mesh, target, wishes)
        elif origin is None:
            self.time = FLIGHT
            touch = self._touch(mesh, target, wishes)
        else:
            self.time = length / self.speed
            for _ in range(ROUNDS):
                touch = self._touch(mesh, target, wishes)
                way = touch - origin
                if way @ (target - origin) <= 0.0:
                    raise BuildError(f"from: {wishes.origin}, must be a place outside the mesh")
                self.direction = way / np.linalg.norm(way)
                self.time = float(np.linalg.norm(way)) / self.speed
        self.start: Float64 = touch - self.time * self.speed * self.direction
        #: The mesh does not fall meanwhile.
        self.velocity: Float64 = self.speed * self.direction - 0.5 * self.time * self.gravity

    def _touch(self, mesh: tuple[Float64, Float64], target: Float64, wishes: Wishes) -> Float64:
        """Where the ball's centre is when it touches on its way to the target, as it flies then."""
        last = self.speed * self.direction + 0.5 * self.time * self.gravity
        direction = last / np.linalg.norm(last)
        place = first_touch(*mesh, target, direction, self.radius)
        if place is None:
            where = "there" if wishes.origin is None else f"{wishes.origin}"
            raise BuildError(
                f"from: {where}, must be another place: the ball would fly to the middle of the "
                "mesh through a hole in it"
            )
        return target + place * direction

    def body(self) -> Body:
        return Body(
            Sphere(self.radius),
            name="ball",
            material="steel",
            position=self.start.tolist(),
            linear_velocity=self.velocity.tolist(),
        )
