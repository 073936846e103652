"""The course of a run: every body that lived, and where it was at every frame."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .convention import Convention
from .report import StepReport
from .skin import Skin

if TYPE_CHECKING:
    from ._frangible import World
    from .scene_looks import Laid

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
UInt32 = npt.NDArray[np.uint32]
Bool = npt.NDArray[np.bool_]

#: Called after every frame with the number of frames done and the number of living bodies.
ProgressCallback = Callable[[int, int], None]

#: Called after every step with its report.
StepCallback = Callable[[StepReport], None]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Body:
    """One body from its birth to its death, with its surface and its path.

    Frame ``f`` of its life is row ``f - birth_frame`` of ``positions`` and ``orientations``.
    """

    id: int
    name: str
    #: The body it broke off from; ``None`` for the bodies of the scene.
    parent: int | None
    #: The body of the scene that it once was a part of; itself for the bodies of the scene.
    source: int
    #: First frame that shows it; 0 is the state before the first step.
    birth_frame: int
    #: First frame that no longer shows it; ``None`` if it outlives the recording.
    death_frame: int | None
    #: [kg]; infinite for static and kinematic bodies.
    mass: float
    #: Its look: glass, concrete, brick, mortar, masonry, wood, stone or metal; ``None`` for a
    #: colour of no meaning.
    look: str | None
    #: (v, 3), body frame [m].
    vertices: Float32
    #: (t, 3) vertex indices, counter-clockwise seen from outside.
    triangles: UInt32
    #: (t,) whether a crack made the triangle.
    interior: Bool
    #: (t, 3, 2) texture coordinates of the triangles' corners, v up: those of the mesh's file where
    #: it has some, else [m].
    coordinates: Float32
    #: (k, 3) centre of mass, world frame [m].
    positions: Float64
    #: (k, 4) ``world_from_body`` as unit quaternions x, y, z, w; neighbours never flip sign.
    orientations: Float64
    #: Attributes of its mesh's file; `None` for all else.
    skin: Skin | None = None
    #: (7,) its position [m] and orientation a frame before its birth, as a part of the body that
    #: this frame shows in its place; `None` for bodies of the scene, and in older caches.
    before: Float64 | None = None

    def __repr__(self) -> str:
        last = "" if self.death_frame is None else f" to {self.death_frame - 1}"
        return (
            f"<Body {self.id} {self.name!r}, frames {self.birth_frame}{last or ' on'}, "
            f"{len(self.triangles)} triangles>"
        )

    @property
    def moves(self) -> bool:
        """True if it can move, or is seen to."""
        return math.isfinite(self.mass) or bool(np.any(self.positions != self.positions[0]))

    def alive(self, frame: int) -> bool:
        """True if the frame shows the body."""
        return self.birth_frame <= frame and (self.death_frame is None or frame < self.death_frame)

    def pose(self, frame: int) -> tuple[Float64, Float64]:
        """Position (3,) [m] and orientation (4,) at a frame of its life."""
        row = frame - self.birth_frame
        return self.positions[row], self.orientations[row]

    def vertices_world(self, frame: int) -> Float64:
        """(v, 3) vertices at a frame of its life, world frame [m]."""
        position, orientation = self.pose(frame)
        return self.vertices.astype(np.float64) @ rotation_matrix(orientation).T + position


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Recording:
    """A run from frame 0, the state before the first step, to frame ``frames``."""

    shot: str
    #: Which step advanced a frame.
    method: str
    fps: float
    #: Number of steps, and the last frame.
    frames: int
    #: Sorted by birth, then by id.
    bodies: list[Body]
    #: One report for every step, as `World.step` gave it.
    reports: list[StepReport] = field(default_factory=list)
    #: Axes, unit and times that USD is written in: those of the stage that the scene came from.
    #: Everything here is in metres, y up.
    convention: Convention = Convention()

    def __repr__(self) -> str:
        return (
            f"<Recording of {self.shot!r}, {self.frames} frames at {self.fps:g} per second, "
            f"{len(self.bodies)} bodies>"
        )

    @staticmethod
    def record(
        world: World,
        frames: int,
        *,
        shot: str = "",
        fps: float | None = None,
        progress: ProgressCallback | None = None,
        skins: dict[int, Laid] | None = None,
    ) -> Recording:
        """Step a world and keep everything it shows; `ValueError` without a frame to record."""
        check_frames(frames)
        recorder = Recorder(world, skins)
        step_frames(world, frames, on_step=recorder.capture, progress=progress)
        return recorder.finish(shot, fps if fps is not None else 1.0 / world.dt)

    def body(self, body_id: int) -> Body:
        """The body of that id; `KeyError` if none of the recording has it."""
        for body in self.bodies:
            if body.id == body_id:
                return body
        raise KeyError(f"no body has the id {body_id}")

    def alive(self, frame: int) -> list[Body]:
        """The bodies that a frame shows."""
        return [body for body in self.bodies if body.alive(frame)]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the recording in the format of the path's ending: .npz, .usda, .usdc, .glb, .html
        to play it, .png for a picture."""
        from .io.output import open_output

        open_output(os.fspath(path)).write(self)

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw energy by cause and momentum over time, as .png, .svg or .pdf."""
        from .io.output import open_plot

        open_plot(os.fspath(path)).write(self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Recording:
        """Read a recording back from a ``.npz`` cache."""
        from .io.cache import read_npz

        return read_npz(os.fspath(path))


def check_frames(frames: int) -> None:
    """`ValueError` for a number of frames that shows nothing."""
    if frames <= 0:
        raise ValueError(f"frames: {frames}, must be > 0")


def step_frames(
    world: World,
    frames: int,
    *,
    on_step: StepCallback,
    progress: ProgressCallback | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> list[float]:
    """Step a world ``frames`` times, or until ``stop`` says so after a step; the wall-clock time of
    each step alone [ms]."""
    step_ms = []
    for frame in range(1, frames + 1):
        begin = time.perf_counter()
        report = world.step()
        step_ms.append(1e3 * (time.perf_counter() - begin))
        on_step(report)
        if progress is not None:
            progress(frame, report["bodies"])
        if stop():
            break
    return step_ms


class Recorder:
    """Keeps the frames of a world that somebody steps, and each surface when its body is first
    seen."""

    def __init__(self, world: World, skins: dict[int, Laid] | None = None) -> None:
        """``skins`` are those of `scene_skins`, for bodies that are meshes."""
        self.world = world
        ids = world.ids.tolist()
        self._skins = {ids[number]: skin for number, skin in (skins or {}).items()}
        # Kept for each body; and for each fragment, where it was before it broke off.
        self._material_frames: dict[int, tuple[list[float], list[float]]] = {}
        self._before: dict[int, Float64] = {}
        self.reports: list[StepReport] = []
        # Kept for each frame: ids (n,), positions (n, 3), orientations (n, 4).
        self._ids: list[npt.NDArray[np.uint64]] = []
        self._positions: list[Float64] = []
        self._orientations: list[Float64] = []
        # Kept for each body, in order of appearance: name, mass, look and surface.
        self._seen: dict[int, tuple[str, float, str | None, Float32, UInt32, Bool, Float32]] = {}
        # Also knows the fragments that broke again before a frame showed them.
        self._parents: dict[int, int] = {}
        self._capture_state()

    def finish(self, shot: str, fps: float) -> Recording:
        """Everything kept so far."""
        return Recording(
            shot, self.world.method, fps, len(self.reports), self._bodies(), self.reports
        )

    def capture(self, report: StepReport) -> None:
        """Keep the state that a step led to, and its report."""
        self.reports.append(report)
        # A fragment's parents may have come and gone within the frame.
        for fracture in report["fractures"]:
            for fragment in fracture["fragments"]:
                self._parents[fragment] = fracture["body"]
        self._capture_state()

    def _capture_state(self) -> None:
        world = self.world
        ids = world.ids
        self._ids.append(ids)
        self._positions.append(world.positions)
        self._orientations.append(world.orientations)

        # Bodies that appear for the first time.
        new = [row for row, body_id in enumerate(ids.tolist()) if body_id not in self._seen]
        if not new:
            return
        names, parents, masses, looks = world.names, world.parents, world.masses, world.looks
        for row in new:
            body_id = int(ids[row])
            self._seen[body_id] = (
                names[row],
                float(masses[row]),
                looks[row],
                *world.surface(body_id),
            )
            self._material_frames[body_id] = world.material_frame(body_id)
            parent = parents[row]
            if parent is not None:
                self._parents[body_id] = parent
        if len(self._ids) > 1:
            self._place_in_parents([int(ids[row]) for row in new])

    def _place_in_parents(self, fragments: list[int]) -> None:
        """Keep where fragments were in the frame before, as parts of a body that it shows."""
        rows = {body_id: row for row, body_id in enumerate(self._ids[-2].tolist())}
        for fragment in fragments:
            parent = self._parents.get(fragment)
            while parent is not None and parent not in rows:
                parent = self._parents.get(parent)
            if parent is None:
                continue
            # Both have the same material: its place in the world, then the fragment's in it.
            row = rows[parent]
            position, orientation = self._positions[-2][row], self._orientations[-2][row]
            origin, turn = (np.array(part) for part in self._material_frames[parent])
            own_origin, own_turn = (np.array(part) for part in self._material_frames[fragment])
            turned = product(orientation, product(turn, own_turn * [-1.0, -1.0, -1.0, 1.0]))
            moved = rotation_matrix(orientation) @ origin - rotation_matrix(turned) @ own_origin
            self._before[fragment] = np.concatenate([position + moved, turned])

    def _bodies(self) -> list[Body]:
        # Gather the rows of every body, in frame order.
        ids = np.concatenate(self._ids)
        frame_of_row = np.repeat(np.arange(len(self._ids)), [len(ids) for ids in self._ids])
        order = np.argsort(ids, kind="stable")
        positions = np.concatenate(self._positions)[order]
        orientations = np.concatenate(self._orientations)[order]
        frame_of_row = frame_of_row[order]
        unique_ids, first = np.unique(ids[order], return_index=True)
        past = np.append(first[1:], len(ids))

        # A body that the last frame does not show died the frame after its last row.
        last_frame = len(self._ids) - 1
        laid = self._laid()
        bodies = []
        for body_id, begin, end in zip(
            unique_ids.tolist(), first.tolist(), past.tolist(), strict=True
        ):
            name, mass, look, vertices, triangles, interior, coordinates = self._seen[body_id]
            skin = None
            if body_id in laid:
                skin, coordinates = laid[body_id]
            death = int(frame_of_row[end - 1]) + 1
            bodies.append(
                Body(
                    id=body_id,
                    name=name,
                    parent=self._parents.get(body_id),
                    source=self._source(body_id),
                    birth_frame=int(frame_of_row[begin]),
                    death_frame=None if death > last_frame else death,
                    mass=mass,
                    look=look,
                    vertices=vertices,
                    triangles=triangles,
                    interior=interior,
                    coordinates=coordinates,
                    positions=positions[begin:end],
                    orientations=without_sign_flips(orientations[begin:end]),
                    skin=skin,
                    before=self._before.get(body_id),
                )
            )
        return sorted(bodies, key=lambda body: (body.birth_frame, body.id))

    def _laid(self) -> dict[int, tuple[Skin, Float32]]:
        """Skin and texture coordinates of each body that is a part of a mesh, all parts of one at
        once."""
        laid: dict[int, tuple[Skin, Float32]] = {}
        for source, skin in self._skins.items():
            own = [body_id for body_id in self._seen if self._source(body_id) == source]
            found = skin.lay_on(
                [(self._seen[body_id][3:], self._material_frames[body_id]) for body_id in own]
            )
            laid.update(zip(own, found, strict=True))
        return laid

    def _source(self, body_id: int) -> int:
        while body_id in self._parents:
            body_id = self._parents[body_id]
        return body_id


def without_sign_flips(orientations: Float64) -> Float64:
    """The same rotations (k, 4), each with the sign nearer to the one before, so that players
    interpolate the short way."""
    dots = np.einsum("ij,ij->i", orientations[1:], orientations[:-1])
    signs = np.concatenate([[1.0], np.cumprod(np.where(dots < 0.0, -1.0, 1.0))])
    flipped: Float64 = orientations * signs[:, None]
    return flipped


def product(left: Float64, right: Float64) -> Float64:
    """The rotation ``right``, then ``left``, as unit quaternions x, y, z, w."""
    vector = left[3] * right[:3] + right[3] * left[:3] + np.cross(left[:3], right[:3])
    both = np.append(vector, left[3] * right[3] - left[:3] @ right[:3])
    unit: Float64 = both / np.linalg.norm(both)
    return unit


def rotation_matrix(orientation: Float64) -> Float64:
    """(3, 3) rotation of a unit quaternion x, y, z, w."""
    x, y, z, w = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
