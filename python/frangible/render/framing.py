"""The subject of a shot: what moves or breaks, without what comes from far away or goes astray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Body, Bool, Float64, Int64, Recording

#: A film is cut into about so many parts; the box of a body in a part holds it in all its frames.
PARTS = 32
#: This share of the bodies is seen at first, each by its size, and all others that make the picture
#: at most so many times as large: what is left comes from far away.
CORE, FAR = 2 / 3, 2.0
#: Of every body at least this share is seen in all of its life, by mass, and of the bodies, each by
#: its size, at least the same; more of them as long as their share grows by more than the picture's
#: size to the power of `COST`. What is left goes astray.
MOST, COST = 0.75, 0.75
#: Bodies are followed as long as the picture at first is at least this part of the whole one, or
#: a typical body that stays whole is at least that part. All falls are followed.
FIRST, SMALLEST = 0.4, 1 / 18
#: What stands still is seen whole if it makes the picture at most so many times as large.
BESIDE = 1.5
#: A part of a way counts by the body's size and by how far it goes there, up to that size, and
#: what rests as if it went so much of its size.
REST = 0.5


@dataclass(frozen=True, slots=True)
class Boxes:
    """Boxes along the world's axes."""

    #: (n, 3) corners [m].
    low: Float64
    high: Float64

    def __getitem__(self, rows: Int64 | Bool) -> Boxes:
        return Boxes(self.low[rows], self.high[rows])

    @property
    def centres(self) -> Float64:
        """(n, 3) [m]."""
        return (self.low + self.high) / 2

    def sizes(self) -> Float64:
        """(n,) diagonals [m]."""
        diagonals: Float64 = np.linalg.norm(self.high - self.low, axis=1)
        return diagonals

    def around(self) -> Boxes:
        """The one box around all of them."""
        return Boxes(self.low.min(axis=0)[None], self.high.max(axis=0)[None])

    def joined(self, others: Boxes) -> Boxes:
        """These and others."""
        return Boxes(np.vstack([self.low, others.low]), np.vstack([self.high, others.high]))

    def unions(self, start: Int64) -> Boxes:
        """Boxes around those from each start to the next."""
        return Boxes(np.minimum.reduceat(self.low, start), np.maximum.reduceat(self.high, start))

    def reach(self, box: Boxes) -> Float64:
        """(n,) how far they reach out of a box [m]."""
        out: Float64 = np.maximum(box.low - self.low, self.high - box.high).max(axis=1)
        return out

    def nearest_first(self, box: Boxes) -> Int64:
        """(n,) their order by how far they reach out of a box."""
        return np.argsort(self.reach(box), kind="stable")

    def grown(self, box: Boxes) -> Boxes:
        """(n,) the boxes around a box and the first of these, the first two ... all of them."""
        low, high = box.joined(self).low, box.joined(self).high
        return Boxes(np.minimum.accumulate(low)[1:], np.maximum.accumulate(high)[1:])

    def fitting(self, box: Boxes, factor: float) -> Bool:
        """(n,) which can be seen with a box if the picture grows by at most a factor."""
        order = self.nearest_first(box)
        fits = np.zeros(len(order), np.bool_)
        fits[order] = self[order].grown(box).sizes() <= factor * box.sizes()
        return fits


@dataclass(frozen=True, slots=True)
class Subject:
    """The boxes that the camera should see, world frame."""

    #: Where it is at first and what stands beside it, which the camera must see.
    first: Boxes
    #: Parts of its ways, (n,) which frames each is about, by a number, how much it counts, and
    #: whether it is of a body that never breaks nor comes from one that did.
    ways: Boxes
    times: Int64
    weights: Float64
    whole: Bool
    #: (3,) its extents at first [m].
    extents: Float64
    #: (3,) how far its parts are from where it was at first, on average [m].
    drift: Float64
    #: What moves or breaks.
    bodies: list[Body]
    #: (3,) of all boxes [m].
    middle: Float64


@dataclass(frozen=True, slots=True)
class _Ways:
    """Ways of bodies, in parts."""

    #: (n,) one for each body and part.
    boxes: Boxes
    #: (n,) index of the body, in order, and the part's first frame.
    body: Int64
    frame: Int64
    #: (n,) how much each counts [m].
    weights: Float64

    def __getitem__(self, rows: Int64 | Bool) -> _Ways:
        return _Ways(self.boxes[rows], self.body[rows], self.frame[rows], self.weights[rows])

    def lives(self) -> Boxes:
        """(b,) one box for each body, around all of its parts."""
        return self.boxes.unions(np.flatnonzero(np.diff(self.body, prepend=-1)))


def find_subject(recording: Recording) -> Subject:
    """The subject of the recording; a box on the floor if nothing has a surface."""
    solid = [body for body in recording.bodies if len(body.vertices)]
    broken = {body.source for body in solid if body.parent is not None}
    acting = [body for body in solid if np.isfinite(body.mass) or body.source in broken]
    bodies = acting or [body for body in solid if body.moves] or solid
    if not bodies:
        floor = Boxes(np.array([[-1.0, 0.0, -1.0]]), np.ones((1, 3)))
        one, middle = np.ones(1), floor.centres[0]
        return Subject(
            floor, floor, one.astype(int), one, one > 0, np.ones(3), np.zeros(3), [], middle
        )

    begin = min(body.birth_frame for body in bodies)
    early = [body for body in bodies if body.birth_frame == begin]
    places = _places(early)
    is_there = _close(places, _sizes(body_corners(early)))
    visitors = {body.id for body, there in zip(early, is_there, strict=True) if not there}
    bodies = [body for body in bodies if body.id not in visitors]
    places = places[is_there]
    first = places.around()

    corners = body_corners(bodies)
    sizes = _sizes(corners)
    ways = _ways(bodies, corners, recording.frames)
    is_main = _main(ways.lives(), bodies, sizes, first)
    is_whole = np.array([body.source not in broken for body in bodies])
    largest = float(first.sizes()[0]) / FIRST
    if np.any(is_main & is_whole):
        largest = max(largest, float(np.median(sizes[is_main & is_whole])) / SMALLEST)
    is_early = np.array([body.birth_frame == begin for body in bodies])
    at_first = places[is_main[is_early]]
    at_first = at_first if len(at_first.low) else first
    main = ways[is_main[ways.body]]
    followed = main[_followed(main, first, largest)]

    still = [body for body in solid if body.alive(begin) and not body.moves]
    others = _places([body for body in still if body.source not in broken])
    boxes = at_first.joined(followed.boxes)
    seen = at_first.joined(others[others.fitting(boxes.around(), BESIDE)])
    drift = (boxes.centres - first.centres).mean(axis=0)
    extents = (first.high - first.low)[0]
    times = followed.frame // _stride(recording.frames)
    is_whole = is_whole[followed.body]
    middle = seen.joined(followed.boxes).around().centres[0]
    return Subject(
        seen, followed.boxes, times, followed.weights, is_whole, extents, drift, bodies, middle
    )


def _close(places: Boxes, sizes: Float64) -> Bool:
    """(n,) which bodies are close to most of them."""
    middle = _median(places.centres, sizes)[None]
    order = places.nearest_first(Boxes(middle, middle))
    share = np.cumsum(sizes[order]) / sizes.sum()
    core = order[: int(np.argmax(share >= CORE)) + 1]
    return places.fitting(places[core].around(), FAR)


def _main(lives: Boxes, bodies: list[Body], sizes: Float64, first: Boxes) -> Bool:
    """(b,) which bodies do not go astray."""
    # The nearest fragments of each body and those that stay where it was, and their box.
    family = np.unique([body.source for body in bodies], return_inverse=True)[1]
    masses = np.array([_mass(body) for body in bodies])
    reach = lives.reach(first)
    order = np.lexsort((reach, family))
    start = np.flatnonzero(np.diff(family[order], prepend=-1))
    nearer = np.cumsum(masses[order]) - masses[order]
    nearer -= nearer[start][family[order]]
    is_near = nearer < MOST * np.add.reduceat(masses[order], start)[family[order]]
    most = order[is_near | (reach[order] <= 0.0)]
    boxes = lives[most].unions(np.flatnonzero(np.diff(family[most], prepend=-1)))

    near = boxes.nearest_first(first)
    weights = np.add.reduceat(sizes[order], start)[near]
    share = np.cumsum(weights) / weights.sum()
    worth = np.where(share >= MOST, share / boxes[near].grown(first).sizes() ** COST, 0.0)
    chosen = near[: int(np.argmax(worth)) + 1]
    is_main = np.zeros(len(bodies), np.bool_)
    is_main[most[np.isin(family[most], chosen)]] = True
    return is_main


def _mass(body: Body) -> float:
    """[kg], of what is held in place for a density of one."""
    held = not np.isfinite(body.mass)
    return float(np.prod(np.ptp(body.vertices, axis=0))) if held else body.mass


def _followed(ways: _Ways, first: Boxes, largest: float) -> Int64:
    """The parts before the picture gets larger than so much [m], but for falls."""
    order = np.argsort(ways.frame, kind="stable")
    pictures = ways.boxes[order].grown(first)
    pictures.low[:, 1] = first.low[0, 1]
    return order[pictures.sizes() <= largest]


def _sizes(corners: Float64) -> Float64:
    """(b,) diagonals of boxes with such corners (b, 2, 3) [m]."""
    sizes: Float64 = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    return sizes


def _median(places: Float64, weights: Float64) -> Float64:
    """(3,) weighted median of places (n, 3), axis by axis."""
    order = np.argsort(places, axis=0, kind="stable")
    share = np.cumsum(weights[order], axis=0)
    row = np.argmax(share >= share[-1] / 2, axis=0)
    return np.take_along_axis(places, order, axis=0)[row, range(3)]


def _places(bodies: list[Body]) -> Boxes:
    """(b,) where bodies are in their first frames."""
    if not bodies:
        return Boxes(np.zeros((0, 3)), np.zeros((0, 3)))
    around = _around(body_corners(bodies), np.array([body.orientations[0] for body in bodies]))
    positions = np.array([body.positions[0] for body in bodies])
    return Boxes(positions + around.low, positions + around.high)


def _ways(bodies: list[Body], corners: Float64, frames: int) -> _Ways:
    """The ways of bodies with such corners (b, 2, 3) through a film of so many frames."""
    stride = _stride(frames)
    counts = np.array([len(body.positions) for body in bodies])
    parts = -(-counts // stride)
    row = np.repeat(np.arange(len(bodies)), parts)
    start = stride * (np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts))
    begins = np.cumsum(counts) - counts
    first = begins[row] + start
    last = np.minimum(first + stride, begins[row] + counts[row]) - 1
    positions = np.concatenate([body.positions for body in bodies])
    orientations = np.concatenate([body.orientations for body in bodies])
    # How a body turns within a part is known from both ends.
    of_parts = corners[row]
    ends = _around(of_parts, orientations[first]), _around(of_parts, orientations[last])
    boxes = Boxes(
        np.minimum.reduceat(positions, first) + np.minimum(ends[0].low, ends[1].low),
        np.maximum.reduceat(positions, first) + np.maximum(ends[0].high, ends[1].high),
    )
    births = np.array([body.birth_frame for body in bodies])
    sizes = _sizes(of_parts)
    gone = np.linalg.norm(positions[last] - positions[first], axis=1)
    weights = np.maximum(np.minimum(gone, sizes), REST * sizes)
    return _Ways(boxes, row, births[row] + start, weights)


def _stride(frames: int) -> int:
    """Frames in a part of a way."""
    return max(1, -(-frames // PARTS))


def body_corners(bodies: list[Body]) -> Float64:
    """(b, 2, 3) corners of the bodies' boxes, body frame [m]."""
    both = [(body.vertices.min(axis=0), body.vertices.max(axis=0)) for body in bodies]
    return np.array(both, np.float64)


def _around(corners: Float64, orientations: Float64) -> Boxes:
    """(n,) boxes around bodies with such corners (n, 2, 3), from their positions."""
    matrices = rotation_matrices(orientations)
    centres = np.einsum("nij,nj->ni", matrices, corners.mean(axis=1))
    halves = np.einsum("nij,nj->ni", np.abs(matrices), np.ptp(corners, axis=1) / 2)
    return Boxes(centres - halves, centres + halves)


def rotation_matrices(orientations: Float64) -> Float64:
    """(n, 3, 3) rotations of unit quaternions (n, 4), x, y, z, w."""
    x, y, z, w = orientations.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
