"""Visibility of the bodies that move or break: an estimate with boxes around bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..materials import LOOKS
from ..recording import Body, Bool, Float64, Recording
from .framing import body_corners, rotation_matrices

#: Frames that are looked at, spread over a film.
MOMENTS = 10
#: What never moves counts so much of what does: where nothing moves, all the same.
STILL = 0.05
#: Bodies whose middles are looked for in a frame, and the largest ones, which may hide them.
SEEN, HIDING = 50, 40


@dataclass(frozen=True, slots=True)
class Moment:
    """A frame: what is there to be seen, and what can hide it, world frame."""

    #: (p, 3) middles of bodies [m].
    places: Float64
    #: (p,) how much each counts: by its body's size [m], and what never moves less.
    weights: Float64
    #: (o, 3) middles of boxes around large bodies, (o, 3) half their widths [m], and
    #: (o, 3, 3) their axes as columns.
    middles: Float64
    halves: Float64
    axes: Float64
    #: (o,) which of them stand still.
    still: Bool

    def hidden(self, eye: Float64) -> Bool:
        """(p, o) which places which box hides from an eye (3,); none hides what is in it."""
        begin = np.einsum("oji,oj->oi", self.axes, eye - self.middles)
        end = np.einsum("oji,poj->poi", self.axes, self.places[:, None] - self.middles)
        way = end - begin
        way = np.where(np.abs(way) < 1e-300, 1e-300, way)
        # (p, o, 3) where the line of sight crosses the planes of a box's sides.
        first, second = (-self.halves - begin) / way, (self.halves - begin) / way
        enter = np.minimum(first, second).max(axis=2)
        leave = np.maximum(first, second).min(axis=2)
        is_hidden: Bool = (enter <= leave) & (leave > 0.0) & (leave < 1.0)
        return is_hidden


def find_moments(recording: Recording, acting: list[Body]) -> list[Moment]:
    """Moments of a recording, in which some bodies are what happens."""
    solid = [body for body in recording.bodies if len(body.vertices)]
    corners = body_corners(solid)
    sizes = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    is_acting = np.isin([body.id for body in solid], [body.id for body in acting])
    is_still = np.array([not body.moves for body in solid], np.bool_)
    is_clear = np.array([_is_clear(body) for body in solid], np.bool_)
    gone = np.linalg.norm([np.ptp(body.positions, axis=0) for body in solid], axis=1)
    weights = np.maximum(np.minimum(gone, sizes), STILL * sizes)
    begin = min(body.birth_frame for body in solid)
    frames = np.unique(np.linspace(begin, recording.frames, MOMENTS).round().astype(int)).tolist()
    moments = []
    for frame in frames:
        living = np.flatnonzero([body.alive(frame) for body in solid])
        poses = [solid[i].pose(frame) for i in living]
        if not poses:
            continue
        positions = np.array([position for position, _ in poses])
        axes = rotation_matrices(np.array([orientation for _, orientation in poses]))
        middles = positions + np.einsum("nij,nj->ni", axes, corners[living].mean(axis=1))
        there = np.flatnonzero(is_acting[living])
        there = there[:: max(1, -(-len(there) // SEEN))]
        large = np.argsort(-sizes[living], kind="stable")
        large = large[~is_clear[living][large]][:HIDING]
        halves = np.ptp(corners[living], axis=1) / 2
        moments.append(
            Moment(
                middles[there], weights[living][there],
                middles[large], halves[large], axes[large], is_still[living][large],
            )
        )  # fmt: skip
    return moments


def _is_clear(body: Body) -> bool:
    return body.look is not None and LOOKS[body.look].outside.clear > 0.0
