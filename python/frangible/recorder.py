"""Keeps what a world shows while somebody steps it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from .laid import Laid
from .recording import (
    Body,
    Bool,
    Float32,
    Float64,
    Recording,
    UInt32,
    product,
    rotation_matrix,
    without_sign_flips,
)
from .report import StepReport
from .skin import Skin

if TYPE_CHECKING:
    from ._frangible import World


@dataclass(frozen=True, slots=True, eq=False)
class SeenBody:
    """What is kept of a body when a frame first shows it."""

    id: int
    name: str
    mass: float
    #: [m^3]
    volume: float
    look: str | None
    #: Of `World.surface`.
    surface: tuple[Float32, UInt32, Bool, Float32]
    #: Of `World.material_frame`.
    material_frame: tuple[list[float], list[float]]
    parent: int | None
    #: See `Body.before`.
    before: Float64 | None


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Of all bodies of a frame, in the order of the world."""

    ids: npt.NDArray[np.uint64]
    #: (n, 3)
    positions: Float64
    #: (n, 4)
    orientations: Float64


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Of one body."""

    birth_frame: int
    #: (k, 3)
    positions: Float64
    #: (k, 4); neighbours do not flip sign.
    orientations: Float64


class Frames(Protocol):
    """The frames of a run, in memory or on a disk."""

    def bodies(self) -> Iterator[SeenBody]:
        """In order of appearance."""

    def reports(self) -> Sequence[StepReport]:
        """In order of their frames."""

    def paths(self) -> dict[int, Path]:
        """Of each body, by its id."""


class Store(Frames, Protocol):
    """Where frames are kept."""

    def add_body(self, body: SeenBody) -> None:
        """A body of the next frame that no frame before shows."""

    def add_frame(self, poses: Poses, report: StepReport | None) -> None:
        """The next frame, and the report of the step that led to it."""


class Memory:
    """Frames that are kept in memory."""

    def __init__(self) -> None:
        self._bodies: list[SeenBody] = []
        self._frames: list[Poses] = []
        self._reports: list[StepReport] = []

    def add_body(self, body: SeenBody) -> None:
        """See `Store`."""
        self._bodies.append(body)

    def add_frame(self, poses: Poses, report: StepReport | None) -> None:
        """See `Store`."""
        self._frames.append(poses)
        if report is not None:
            self._reports.append(report)

    def bodies(self) -> Iterator[SeenBody]:
        """See `Store`."""
        return iter(self._bodies)

    def reports(self) -> Sequence[StepReport]:
        """See `Store`."""
        return list(self._reports)

    def paths(self) -> dict[int, Path]:
        """See `Store`."""
        return {
            body_id: Path(first, positions, without_sign_flips(orientations))
            for body_id, first, positions, orientations in rows_of_bodies(self._frames)
        }


def rows_of_bodies(frames: list[Poses]) -> Iterator[tuple[int, int, Float64, Float64]]:
    """The id of each body that some frames show, the first of them, and its rows in their order."""
    ids = np.concatenate([poses.ids for poses in frames])
    frame_of_row = np.repeat(np.arange(len(frames)), [len(poses.ids) for poses in frames])
    order = np.argsort(ids, kind="stable")
    positions = np.concatenate([poses.positions for poses in frames])[order]
    orientations = np.concatenate([poses.orientations for poses in frames])[order]
    unique_ids, first = np.unique(ids[order], return_index=True)
    past = np.append(first[1:], len(ids))
    births = frame_of_row[order][first]
    for body_id, begin, end, birth in zip(
        unique_ids.tolist(), first.tolist(), past.tolist(), births.tolist(), strict=True
    ):
        yield body_id, birth, positions[begin:end], orientations[begin:end]


@dataclass(slots=True, eq=False)
class Known:
    """What a recorder needs of the frames behind it."""

    #: Number of steps.
    steps: int = 0
    #: Ids of frame 0, in the order of the scene.
    first_ids: list[int] = field(default_factory=list)
    #: The last frame.
    last: Poses | None = None
    #: Of all bodies that a frame showed.
    material_frames: dict[int, tuple[list[float], list[float]]] = field(default_factory=dict)
    #: Also of fragments that broke again before a frame showed them.
    parents: dict[int, int] = field(default_factory=dict)

    def note_fractures(self, report: StepReport) -> None:
        """A fragment's parents may have come and gone within the frame."""
        for fracture in report["fractures"]:
            for fragment in fracture["fragments"]:
                self.parents[fragment] = fracture["body"]

    def note_body(self, body: SeenBody) -> None:
        """A body that no frame showed before."""
        self.material_frames[body.id] = body.material_frame
        if body.parent is not None:
            self.parents[body.id] = body.parent

    def note_frame(self, poses: Poses) -> None:
        """The next frame; after its bodies."""
        if self.last is None:
            self.first_ids = poses.ids.tolist()
        else:
            self.steps += 1
        self.last = poses

    def source(self, body_id: int) -> int:
        """The body of the scene that this once was a part of."""
        while body_id in self.parents:
            body_id = self.parents[body_id]
        return body_id

    def place_in_parent(
        self, parent: int | None, material_frame: tuple[list[float], list[float]]
    ) -> Float64 | None:
        """Where a fragment was in the last frame, as a part of a body that it shows."""
        if self.last is None:
            return None
        rows = self.last.ids.tolist()
        while parent is not None and parent not in rows:
            parent = self.parents.get(parent)
        if parent is None:
            return None
        # Both have the same material: its place in the world, then the fragment's in it.
        row = rows.index(parent)
        position, orientation = self.last.positions[row], self.last.orientations[row]
        origin, turn = (np.array(part) for part in self.material_frames[parent])
        own_origin, own_turn = (np.array(part) for part in material_frame)
        turned = product(orientation, product(turn, own_turn * [-1.0, -1.0, -1.0, 1.0]))
        moved = rotation_matrix(orientation) @ origin - rotation_matrix(turned) @ own_origin
        return np.concatenate([position + moved, turned])


class Recorder:
    """Keeps the frames of a world that somebody steps, and each surface when its body is first
    seen."""

    def __init__(
        self,
        world: World,
        skins: dict[int, Laid] | None = None,
        store: Store | None = None,
        known: Known | None = None,
    ) -> None:
        """``skins`` are those of `scene_skins`, for bodies that are meshes. Without a ``store`` the
        frames are kept in memory; ``known`` is of the frames that one holds already."""
        self.world = world
        self._store: Store = Memory() if store is None else store
        self._known = Known() if known is None else known
        if self._known.last is None:
            self._capture_state(None)
        ids = self._known.first_ids
        self._skins = {ids[number]: skin for number, skin in (skins or {}).items()}

    @property
    def reports(self) -> list[StepReport]:
        """Of all steps so far."""
        return list(self._store.reports())

    def capture(self, report: StepReport) -> None:
        """Keep the state that a step led to, and its report."""
        self._known.note_fractures(report)
        self._capture_state(report)

    def finish(self, shot: str, fps: float) -> Recording:
        """Everything kept so far."""
        return assemble(self._store, self._known, self._skins, (shot, self.world.method, fps))

    def _capture_state(self, report: StepReport | None) -> None:
        world, known = self.world, self._known
        poses = Poses(world.ids, world.positions, world.orientations)

        # Bodies that appear for the first time.
        ids = poses.ids.tolist()
        new = [row for row, body_id in enumerate(ids) if body_id not in known.material_frames]
        if new:
            names, parents, masses, looks = world.names, world.parents, world.masses, world.looks
            volumes = world.volumes
            for row in new:
                frame = world.material_frame(ids[row])
                parent = known.parents.get(ids[row]) if parents[row] is None else parents[row]
                seen = SeenBody(
                    id=ids[row],
                    name=names[row],
                    mass=float(masses[row]),
                    volume=float(volumes[row]),
                    look=looks[row],
                    surface=world.surface(ids[row]),
                    material_frame=frame,
                    parent=parent,
                    before=known.place_in_parent(parent, frame),
                )
                self._store.add_body(seen)
                known.note_body(seen)
        self._store.add_frame(poses, report)
        known.note_frame(poses)


def recorded_body(
    seen: SeenBody, path: Path, known: Known, last: int, laid: tuple[Skin, Float32] | None
) -> Body:
    """A body with its path up to the ``last`` frame, and the skin that was laid on it."""
    vertices, triangles, interior, coordinates = seen.surface
    skin, coordinates = laid or (None, coordinates)
    # A body that the last frame does not show died the frame after its last row.
    death = path.birth_frame + len(path.positions)
    return Body(
        id=seen.id,
        name=seen.name,
        parent=known.parents.get(seen.id),
        source=known.source(seen.id),
        birth_frame=path.birth_frame,
        death_frame=None if death > last else death,
        mass=seen.mass,
        look=seen.look,
        vertices=vertices,
        triangles=triangles,
        interior=interior,
        coordinates=coordinates,
        positions=path.positions,
        orientations=path.orientations,
        skin=skin,
        before=seen.before,
        volume=seen.volume,
    )


def assemble(
    frames: Frames, known: Known, skins: dict[int, Laid], named: tuple[str, str, float]
) -> Recording:
    """The recording of all that is kept; ``named`` by its shot, method and frames per second."""
    seen = {body.id: body for body in frames.bodies()}
    # A skin is laid on all parts of a mesh at once.
    laid: dict[int, tuple[Skin, Float32]] = {}
    for source, skin in skins.items():
        own = [body for body in seen.values() if known.source(body.id) == source]
        found = skin.lay_on([(body.surface, body.material_frame) for body in own])
        laid.update(zip((body.id for body in own), found, strict=True))

    bodies = []
    for body_id, path in frames.paths().items():
        body = recorded_body(seen[body_id], path, known, known.steps, laid.get(body_id))
        bodies.append(body)
    shot, method, fps = named
    bodies.sort(key=lambda body: (body.birth_frame, body.id))
    return Recording(shot, method, fps, known.steps, bodies, frames.reports())
