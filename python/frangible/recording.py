"""The course of a run: every body that lived, and where it was at every frame."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .convention import Convention
from .report import StepReport
from .skin import Skin

if TYPE_CHECKING:
    from ._frangible import World
    from .laid import Laid

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
UInt32 = npt.NDArray[np.uint32]
Bool = npt.NDArray[np.bool_]

#: Called after every frame with the number of frames done and the number of living bodies.
ProgressCallback = Callable[[int, int], None]

#: Called after every step with its report, and the wall-clock time of the step alone [ms].
StepCallback = Callable[[StepReport, float], None]


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
    #: [m^3], exact where its surface is in single precision; 0 for bodies without a volume, `None`
    #: in older caches.
    volume: float | None = None

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
    #: One report for every step, as `World.step` gave it; of a run that is kept on a disk they stay
    #: there.
    reports: Sequence[StepReport] = field(default_factory=list)
    #: Axes, unit and times that USD is written in: those of the stage that the scene came from.
    #: Everything here is in metres, y up.
    convention: Convention = Convention()

    def __repr__(self) -> str:
        return (
            f"<Recording of {self.shot!r}, {self.frames} frames at {self.fps:g} per second, "
            f"{len(self.bodies)} bodies>"
        )

    def _repr_html_(self) -> str:
        """The player, for a notebook."""
        from .notebook import recording_html

        return recording_html(self)

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
        from .recorder import Recorder

        check_frames(frames)
        recorder = Recorder(world, skins)
        step_frames(
            world, frames, on_step=lambda report, _: recorder.capture(report), progress=progress
        )
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
    done: int = 0,
) -> None:
    """Step a world ``frames`` times, of which ``done`` are behind it, or until ``stop`` says so
    after a step; `World.stop_step` may end one before it is done."""
    for frame in range(done + 1, frames + 1):
        begin = time.perf_counter()
        try:
            report = world.step()
        except KeyboardInterrupt:
            if stop():
                break
            raise
        on_step(report, 1e3 * (time.perf_counter() - begin))
        if progress is not None:
            progress(frame, report["bodies"])
        if stop():
            break


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
