"""A pile of convex bodies in a file that any engine's program can read, and what those programs
write.

Little endian, no padding: the bytes ``FRANPILE``, the number of bodies (u32), seconds of a frame,
gravity (3); then for each body its shape, position (3), orientation x, y, z, w, velocity (3),
angular velocity (3), mass, principal moments of inertia (3), friction, restitution; float64 unless
it says otherwise. A shape is 0 (u32), the number of vertices (u32) and these (3 each) for a hull; 1
(u32) and half of the edge lengths (3) for a box; 2 (u32) and the radius for a ball. A body's frame
has its origin in the centre of mass and the principal axes, along which boxes lie. What is static
has infinite mass, is a box, and has the smallest friction and restitution of all, so that any rule
that engines have for a pair gives the same where all pieces are alike.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np

from .. import _frangible
from ..recording import Float64, rotation_matrix
from .run_process import STATE, BenchError

MAGIC = b"FRANPILE"

#: Half of the edge lengths of the box that stands for the ground [m]; its top is the ground.
GROUND = np.array([60.0, 1.0, 60.0])

#: Further from the middle than this [m], a piece is lost.
FAR = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """Of its vertices."""

    #: (v, 3), body frame [m].
    vertices: Float64

    @property
    def radius(self) -> float:
        """Of the ball around the origin that it lies in [m]."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    @property
    def width(self) -> float:
        """The least one along the axes [m]."""
        return float(np.ptp(self.vertices, axis=0).min())


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """Along the axes of the body's frame, around its origin."""

    #: Half of the edge lengths (3,) [m].
    half: Float64

    @property
    def radius(self) -> float:
        """Of the ball around the origin that it lies in [m]."""
        return float(np.linalg.norm(self.half))

    @property
    def width(self) -> float:
        """The least one along the axes [m]."""
        return 2.0 * float(self.half.min())


@dataclass(frozen=True, slots=True)
class Ball:
    """Around the origin of the body's frame."""

    #: [m]
    radius: float

    @property
    def width(self) -> float:
        """From side to side [m]."""
        return 2.0 * self.radius


@dataclass(frozen=True, slots=True, eq=False)
class Pile:
    """A scene of convex bodies that do not break, as it starts; one row for each body."""

    scene: dict[str, Any]
    shapes: list[Hull | Box | Ball]
    #: (n,) of the balls around the origins of the bodies' frames that their shapes lie in [m].
    radii: Float64
    #: (n, `STATE`).
    start: Float64
    #: (n,) [kg]; infinite for what is static.
    masses: Float64
    #: (n, 3) about the principal axes [kg m^2].
    inertias: Float64

    @property
    def moves(self) -> Any:
        """(n,) whether a body can move."""
        return np.isfinite(self.masses)

    @property
    def widths(self) -> Float64:
        """(n,) the least ones of the bodies along the axes of their frames [m]."""
        return np.array([shape.width for shape in self.shapes])

    @property
    def ground(self) -> float:
        """How high the ground is [m]: the lowest that something static reaches up to."""
        shapes = [
            (self.shapes[row], self.start[row, 1]) for row in np.flatnonzero(~self.moves).tolist()
        ]
        return float(
            min(height + shape.half[1] for shape, height in shapes if isinstance(shape, Box))
        )

    @staticmethod
    def of_shot(shot: str) -> Pile:
        """The bodies of a shot; `BenchError` if it is no pile of convex bodies that do not
        break."""
        return Pile.of_scene(shot, json.loads(_frangible.shot_scene(shot)))

    @staticmethod
    def of_scene(name: str, scene: dict[str, Any]) -> Pile:
        """The bodies of a scene; `BenchError` names it if it is no pile of convex bodies that do
        not break."""
        for body in scene["bodies"]:
            check(name, body)
        world = _frangible.World.build(json.dumps(scene), 1)
        start = np.concatenate(
            [world.positions, world.orientations, world.velocities, world.angular_velocities],
            axis=1,
        )
        shapes, inertias = list[Hull | Box | Ball](), np.zeros((len(start), 3))
        for row, (body, number) in enumerate(zip(scene["bodies"], world.ids.tolist(), strict=True)):
            kind = body["shape"]["kind"]
            if kind == "half-space":
                shapes.append(Box(GROUND))
                start[row] = 0.0
                start[row, 1], start[row, 6] = body["position"][1] - GROUND[1], 1.0
                continue
            surface, triangles, _, _ = world.surface(number)
            corners = surface.astype(np.float64)
            if kind == "sphere":
                shapes.append(Ball(body["shape"]["radius"]))
                inertias[row] = 0.4 * world.masses[row] * body["shape"]["radius"] ** 2
                continue
            shapes.append(
                Box(corners.max(axis=0)) if kind == "box" else Hull(np.unique(corners, axis=0))
            )
            if np.isfinite(world.masses[row]):
                properties = _frangible.mesh_mass((corners, triangles))
                density = world.masses[row] / properties["volume_m3"]
                inertias[row] = density * np.diag(np.array(properties["unit_inertia_m5"]))
        radii = np.array([shape.radius for shape in shapes])
        return Pile(scene, shapes, radii, start, world.masses, inertias)

    def write(self, file: BinaryIO) -> None:
        """Write the file that the module describes."""
        dt = 1.0 / self.scene["frames_per_second"]
        coefficients = np.array(
            [[body["friction"], body["restitution"]] for body in self.scene["bodies"]]
        )
        coefficients[~self.moves] = coefficients.min(axis=0)
        file.write(MAGIC + struct.pack("<I4d", len(self.start), dt, *self.scene["gravity"]))
        for row in range(len(self.start)):
            numbers = (*self.start[row], self.masses[row], *self.inertias[row], *coefficients[row])
            file.write(_shape_bytes(self.shapes[row]))
            file.write(struct.pack(f"<{len(numbers)}d", *numbers))

    def energies(self, states: Float64) -> Float64:
        """(f,) kinetic and potential energy [J] of all pieces in states (f, n, `STATE`), of those
        that are not lost."""
        return np.array([self._energy(state) for state in states])

    def _energy(self, state: Float64) -> float:
        kept = self.moves & ~self.lost(state)
        masses, state = self.masses[kept], state[kept]
        height = -(state[:, :3] @ np.array(self.scene["gravity"]))
        turning = np.einsum(
            "nij,ni->nj", rotation_matrix(state[:, 3:7].T).transpose(2, 0, 1), state[:, 10:]
        )
        kinetic = 0.5 * masses * np.einsum("ni,ni->n", state[:, 7:10], state[:, 7:10])
        rotational = 0.5 * np.einsum("ni,ni,ni->n", self.inertias[kept], turning, turning)
        return float(np.sum(masses * height + kinetic + rotational))

    def lost(self, state: Float64) -> Any:
        """(n,) which pieces are wholly below the ground, far away, or nowhere; what only sank in is
        not lost, but overlaps."""
        position = state[:, :3]
        below = position[:, 1] + self.radii < self.ground
        with np.errstate(invalid="ignore"):
            gone = ~np.isfinite(position).all(axis=1) | (np.abs(position) > FAR).any(axis=1)
        return self.moves & (below | gone)

    def penetrations(self, state: Float64) -> Float64:
        """(k,) how deep overlapping pairs are [m] in a state (n, `STATE`), by the engine of this
        package, whose state it may not be."""
        kept = np.flatnonzero(~self.moves | ~self.lost(state))
        bodies = [
            self._at(row, state[row]) if self.moves[row] else self.scene["bodies"][row]
            for row in kept.tolist()
        ]
        return _frangible.World.build(json.dumps(self.scene | {"bodies": bodies}), 1).penetrations()

    def _at(self, row: int, state: Float64) -> dict[str, Any]:
        """A body of the scene where a state has it: the scene says where the shape's own frame is,
        not the body's."""
        body, start = self.scene["bodies"][row], self.start[row]
        unturned = start[3:7] * np.array([-1.0, -1.0, -1.0, 1.0])
        from_start = product(state[3:7] / np.linalg.norm(state[3:7]), unturned)
        offset = np.array(body["position"]) - start[:3]
        moved: dict[str, Any] = body | {
            "position": (state[:3] + rotation_matrix(from_start) @ offset).tolist(),
            "orientation": product(from_start, np.array(body["orientation"])).tolist(),
        }
        return moved


def load_states(path: str, pile: Pile) -> Float64:
    """The states that a program wrote, (f, n, `STATE`)."""
    numbers = np.fromfile(path, dtype="<f4").astype(np.float64)
    return numbers.reshape(-1, len(pile.start), STATE)


def product(left: Float64, right: Float64) -> Float64:
    """Of two quaternions x, y, z, w: first the right rotation, then the left."""
    vector = left[3] * right[:3] + right[3] * left[:3] + np.cross(left[:3], right[:3])
    return np.append(vector, left[3] * right[3] - left[:3] @ right[:3])


def _shape_bytes(shape: Hull | Box | Ball) -> bytes:
    match shape:
        case Hull(vertices):
            return struct.pack("<2I", 0, len(vertices)) + vertices.astype("<f8").tobytes()
        case Box(half):
            return struct.pack("<I3d", 1, *half)
        case Ball(radius):
            return struct.pack("<Id", 2, radius)


def check(shot: str, body: dict[str, Any]) -> None:
    """`BenchError` if other engines cannot have a body."""
    kind, is_static = body["shape"]["kind"], body["motion"] == "static"
    is_convex = kind in (("box", "half-space") if is_static else ("hull", "box", "sphere"))
    if not is_convex or body["motion"] == "kinematic" or "breaking" in body or "bonds" in body:
        raise BenchError(
            f"{shot}: body '{body['name']}', must be a hull, a box or a sphere that does not "
            "break, for other engines to run it"
        )
