"""How near a camera goes: the picture that shows the most of a subject for its size."""

from __future__ import annotations

import numpy as np

from ..recording import Bool, Float64
from .framing import Boxes, Subject

#: What a picture shows of the subject counts by its size in the picture to this power.
COST = 0.6
#: With bodies that stay whole no more of what counts may be lost at any time; fragments may fly
#: off.
LOST = 0.25
#: Sizes of pictures and, of each, places in each direction that are tried; parts of ways that are
#: looked at, about.
SIZES, PLACES, PARTS = 12, 9, 2000


def best_place(subject: Subject, axes: Float64, slopes: Float64) -> Float64:
    """Where the eye is (3,), from the subject's middle along axes (3, 3), right, up and forward.

    Slopes (2,) are half the picture's width and height at a depth of 1. All of ``subject.first``
    is seen, and of its ways as much as pays.
    """
    stride = max(1, -(-len(subject.weights) // PARTS))
    weights, times = subject.weights[::stride], subject.times[::stride]
    is_whole, each_time = subject.whole[::stride], np.bincount(times, weights)
    # A place is seen if it is below the planes of the picture's four margins.
    first = _heights(subject.first, subject.middle, axes, slopes).max(axis=0)
    parts = np.maximum(_heights(subject.ways, subject.middle, axes, slopes)[::stride], first)
    if not len(parts):
        return _eye(first, slopes)
    middles = (subject.ways.centres[::stride] - subject.middle) @ axes[2]
    least, most = _distance(first, slopes), _distance(parts.max(axis=0), slopes)

    best, worth = first, 0.0
    for distance in np.linspace(most, least, SIZES):
        is_seen = np.ones(len(weights), np.bool_)
        for axis in (0, 1):
            is_seen = _most_seen(
                parts[:, :, axis], first[:, axis], 2.0 * slopes[axis] * distance, weights, is_seen
            )
        lost = np.bincount(times, np.where(is_whole & ~is_seen, weights, 0.0))
        if np.any(lost > LOST * each_time) or not is_seen.any():
            continue
        # As near as what is seen allows.
        planes = parts[is_seen].max(axis=0)
        depths = middles[is_seen] + _distance(planes, slopes)
        gain = float(weights[is_seen] @ depths**-COST)
        if gain > worth * (1.0 + 1e-9):
            best, worth = planes, gain
    return _eye(best, slopes)


def _heights(boxes: Boxes, middle: Float64, axes: Float64, slopes: Float64) -> Float64:
    """(n, 2, 2) how far boxes reach along the normals of the margins on the right and above, then
    of those on the left and below."""
    centres, halves = boxes.centres - middle, (boxes.high - boxes.low) / 2
    ahead = slopes[:, None] * axes[2]
    normals = np.concatenate([axes[:2] - ahead, -axes[:2] - ahead])
    heights: Float64 = centres @ normals.T + halves @ np.abs(normals).T
    return heights.reshape(-1, 2, 2)


def _most_seen(
    parts: Float64, first: Float64, width: float, weights: Float64, is_seen: Bool
) -> Bool:
    """Which of the parts (n, 2) a picture of a width sees where it sees the most of them."""
    low = max(first[0], width - float(parts[:, 1].max()))
    high = min(float(parts[:, 0].max()), width - first[1])
    tries = np.linspace(low, high, PLACES)[:, None]
    slack = 1e-9 * width
    sees = is_seen & (parts[:, 0] <= tries + slack) & (parts[:, 1] <= width - tries + slack)
    best: Bool = sees[int(np.argmax(np.where(sees, weights, 0.0).sum(axis=1)))]
    return best


def _distance(planes: Float64, slopes: Float64) -> float:
    """How far the eye is behind the subject's middle for planes (2, 2)."""
    return float((planes.sum(axis=0) / (2.0 * slopes)).max())


def _eye(planes: Float64, slopes: Float64) -> Float64:
    """(3,) where opposite margins are equal."""
    across = (planes[0] - planes[1]) / 2
    return np.array([across[0], across[1], -_distance(planes, slopes)])
