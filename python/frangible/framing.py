"""The subject of a shot: the bodies that break, or without a break those that move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .recording import Body, Bool, Float64, Recording

#: Frames that are looked at, spread evenly; a shot changes little between two of them.
SAMPLED_FRAMES = 32
#: The subject is seen this long before its first break [s].
BEFORE_BREAK = 0.4
#: Part of the weight that lies outside the frame on each side of each axis, at most.
STRAGGLERS = 0.06
#: How far beyond it what is no straggler may lie, over its size.
NEARBY = 0.35
#: Places that are checked for whether something hides them, about.
HIDEABLE = 60
#: How far fragments are followed along x, up and along z, and how far down, over the diagonal of
#: what broke: they fly off, but fall onto something.
REACH, FALL = 0.5, 1.5


@dataclass(frozen=True, slots=True)
class Subject:
    """The points that the camera must see, world frame."""

    #: (n, 3) points [m].
    points: Float64
    #: (3,) extents of its heaviest part before it breaks or moves [m].
    extents: Float64
    #: (3,) how far its parts are from where that one was at first, on average [m].
    drift: Float64
    #: (k, 3) some middles of its parts, which nothing should hide [m].
    middles: Float64
    #: Corners (b, 2, 3) of boxes around everything else, along the world's axes [m].
    others: Float64


@dataclass(frozen=True, slots=True)
class _Boxes:
    """Boxes along the world's axes, one for each body and frame looked at."""

    #: (n, 3) [m].
    centres: Float64
    halves: Float64
    #: (n,) mass of the body [kg].
    masses: Float64

    def within(self, low: Float64, high: Float64) -> Bool:
        """(n,) whether their centres lie in a box."""
        inside: Bool = np.all((self.centres >= low) & (self.centres <= high), axis=1)
        return inside

    def corners(self) -> Float64:
        """(8 n, 3) [m]."""
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        every: Float64 = self.centres[:, None] + signs * self.halves[:, None]
        return every.reshape(-1, 3)


def find_subject(recording: Recording) -> Subject:
    """The subject of the recording; a box on the floor if nothing has a surface."""
    solid = [body for body in recording.bodies if len(body.vertices)]
    broken = {body.source for body in solid if body.parent is not None and body.birth_frame > 0}
    if broken:
        return _what_breaks(recording, [body for body in solid if body.source in broken])
    movable = [body for body in solid if body.moves] or solid
    if not movable:
        nothing = np.zeros((0, 3))
        points = np.array([[-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]])
        return Subject(points, np.ones(3), np.zeros(3), nothing, nothing.reshape(0, 2, 3))

    # A body on rails, or from far away, is there for the body that it strikes.
    shown = _together([body for body in movable if np.isfinite(body.mass)] or movable)
    boxes = _boxes(shown, _spread(0, recording.frames))
    low, high = _typical(boxes, np.ones(len(boxes.masses)))
    return _subject(recording, shown, boxes, *_around(boxes, low, high))


def _together(bodies: list[Body]) -> list[Body]:
    """The bodies that are close to each other at first, as most are."""
    boxes = _boxes(bodies, [body.birth_frame for body in bodies], paired=True)
    distances = np.linalg.norm(boxes.centres - np.median(boxes.centres, axis=0), axis=1)
    sizes = np.linalg.norm(boxes.halves, axis=1)
    near = distances <= 1.6 * np.quantile(distances, 0.75) + 2.0 * np.median(sizes)
    return [body for body, keep in zip(bodies, near, strict=True) if keep]


def _what_breaks(recording: Recording, family: list[Body]) -> Subject:
    """Bodies shortly before they break, and their fragments within reach."""
    # Each source until its first break; of many, a straggler on either side does not matter.
    breaks = {body.source: recording.frames + 1 for body in family}
    for body in family:
        if body.birth_frame > 0:
            breaks[body.source] = min(breaks[body.source], body.birth_frame)
    wholes = [body for body in family if body.birth_frame < breaks[body.source]] or family
    last = [
        max(body.birth_frame, min(breaks[body.source] - 1, _last_frame(body))) for body in wholes
    ]
    struck = _boxes(wholes, last, paired=True)
    low, high = _around(struck, *_typical(struck, struck.masses))

    # All frames that show it, but no farther than its fragments are worth following.
    first = max(0, min(breaks.values()) - max(1, round(BEFORE_BREAK * recording.fps)))
    frames = _spread(first, recording.frames)
    boxes = _boxes(family, frames)
    flown_low, flown_high = _around(boxes, *_typical(boxes, boxes.masses))
    diagonal = float(np.linalg.norm(high - low))
    lowest, highest = low - diagonal * np.array([REACH, FALL, REACH]), high + diagonal * REACH
    low = np.minimum(low, np.maximum(flown_low, lowest))
    high = np.maximum(high, np.minimum(flown_high, highest))
    pairs = zip(_parts(struck), _parts(boxes), strict=True)
    both = _Boxes(*(np.concatenate(pair) for pair in pairs))
    return _subject(recording, family, both, low, high)


def _subject(
    recording: Recording, family: list[Body], boxes: _Boxes, low: Float64, high: Float64
) -> Subject:
    near = boxes.within(low, high)
    points = np.clip(boxes.corners()[np.repeat(near, 8)], low, high)
    # The heaviest part, and where all of them go; that counts even out of reach.
    main = max((body for body in family if body.birth_frame == family[0].birth_frame), key=_weight)
    drift = np.average(boxes.centres - main.positions[0], axis=0, weights=boxes.masses)
    middles = boxes.centres[near]
    shown = {body.id for body in family}
    beside = [body for body in recording.alive(0) if len(body.vertices) and body.id not in shown]
    around = _boxes([body for body in beside if _stays(body)], [0])
    return Subject(
        points if len(points) else np.array([low, high]),
        np.ptp(main.vertices_world(main.birth_frame), axis=0),
        drift,
        middles[:: max(1, len(middles) // HIDEABLE)],
        np.stack([around.centres - around.halves, around.centres + around.halves], axis=1),
    )


def _stays(body: Body) -> bool:
    """True if it goes no farther than half its size."""
    way = np.linalg.norm(np.ptp(body.positions, axis=0))
    return bool(way < 0.5 * np.linalg.norm(np.ptp(body.vertices, axis=0)))


def _weight(body: Body) -> float:
    """Mass [kg]; whatever has none of its own, like a ball on rails, weighs nothing here."""
    return body.mass if np.isfinite(body.mass) and body.mass > 0.0 else 1e-300


def _last_frame(body: Body) -> int:
    return body.birth_frame + len(body.positions) - 1


def _spread(first: int, last: int) -> list[int]:
    """Frames from the first to the last."""
    count = min(SAMPLED_FRAMES, last - first + 1)
    frames: list[int] = np.unique(np.linspace(first, last, count).round().astype(int)).tolist()
    return frames


def _boxes(bodies: list[Body], frames: list[int], *, paired: bool = False) -> _Boxes:
    """Boxes around bodies at all of the frames that show them, or at one frame each."""
    middles, halves, positions, orientations, counts = [], [], [], [], []
    sampled = np.array(frames)
    for index, body in enumerate(bodies):
        low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
        middles.append((low.astype(np.float64) + high) / 2)
        halves.append((high.astype(np.float64) - low) / 2)
        rows = (sampled[index : index + 1] if paired else sampled) - body.birth_frame
        rows = rows[(rows >= 0) & (rows < len(body.positions))]
        positions.append(body.positions[rows])
        orientations.append(body.orientations[rows])
        counts.append(len(rows))
    if not bodies:
        return _Boxes(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    matrices = _matrices(np.concatenate(orientations))
    middle, half = (np.repeat(np.array(each), counts, axis=0) for each in (middles, halves))
    centres = np.concatenate(positions) + np.einsum("nij,nj->ni", matrices, middle)
    return _Boxes(
        centres,
        np.einsum("nij,nj->ni", np.abs(matrices), half),
        np.repeat([_weight(body) for body in bodies], counts),
    )


def _parts(boxes: _Boxes) -> tuple[Float64, Float64, Float64]:
    return boxes.centres, boxes.halves, boxes.masses


def _matrices(orientations: Float64) -> Float64:
    """(n, 3, 3) rotations of unit quaternions (n, 4), x, y, z, w."""
    x, y, z, w = orientations.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _typical(boxes: _Boxes, weights: Float64) -> tuple[Float64, Float64]:
    """Corners of the box (3,) that holds the centres, without the stragglers on each side."""
    low, high = np.zeros(3), np.zeros(3)
    for axis in range(3):
        values = boxes.centres[:, axis]
        order = np.argsort(values, kind="stable")
        share = np.cumsum(weights[order]) / weights.sum()
        low[axis] = values[order[min(int(np.searchsorted(share, STRAGGLERS)), len(order) - 1)]]
        at = min(int(np.searchsorted(share, 1.0 - STRAGGLERS)), len(order) - 1)
        high[axis] = values[order[at]]
    return low, high


def _around(boxes: _Boxes, low: Float64, high: Float64) -> tuple[Float64, Float64]:
    """Corners of the box (3,) around all of the boxes whose centres lie in a box or nearby."""
    room = NEARBY * (high - low)
    inside = boxes.within(low - room, high + room)
    if not inside.any():
        return low, high
    centres, halves = boxes.centres[inside], boxes.halves[inside]
    return (centres - halves).min(axis=0), (centres + halves).max(axis=0)
