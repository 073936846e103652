"""Surface detail of pictures besides colour: the grain of wood, the gravel in
concrete."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..recording import Bool, Float32, Float64

#: Width of a year's growth [m].
RING = 0.011
#: Sizes of the gravel and of the sand in concrete [m].
GRAVEL, SAND = 0.022, 0.005


def longest_first(vertices: Float64) -> Float64:
    """Axes (3, 3), rows, of points (v, 3): along their longest extent, then across it."""
    if len(vertices) < 2:
        return np.eye(3)
    axes: Float64 = np.linalg.svd(
        vertices - vertices.mean(axis=0), full_matrices=len(vertices) < 3
    )[2]
    return axes


def wood(points: Float64) -> Float64:
    """Tint (n, 3) of softwood at points (n, 3) whose first axis is the grain [m]: late wood is
    darker and redder."""
    # The rings around a pith that lies beside the piece wander a little along the grain, and no
    # ring is as wide as the next.
    wander = 0.5 * _noise(points * [1.3, 9.0, 9.0]) + 0.12 * _noise(points * [6.0, 60.0, 60.0])
    radius = np.hypot(points[:, 1] + 0.09, points[:, 2] + 0.05) / RING + 2.0 * wander
    late = (radius % 1.0) ** 3
    fibre = 0.06 * (_noise(points * [25.0, 900.0, 900.0]) - 0.5)
    tint: Float64 = (1.0 + fibre)[:, None] - late[:, None] * np.array([0.34, 0.44, 0.50])
    return tint


def concrete(points: Float64, interior: Bool) -> Float64:
    """Tint (n, 3) of concrete at points (n, 3) [m]; what cracks lay bare (n,) shows its gravel."""
    sand = 0.16 * (_noise(points / SAND) - 0.5) + 0.14 * (_noise(points / 0.15) - 0.5)
    gravel = np.clip((_noise(points / GRAVEL) - 0.56) * 9.0, 0.0, 1.0)
    shade = _noise(points / (2.5 * GRAVEL) + 17.0)
    stones = gravel[:, None] * (np.array([-0.34, -0.32, -0.28]) + 0.45 * shade[:, None])
    tint: Float64 = (1.0 + sand)[:, None] + np.where(interior[:, None], stones, 0.0)
    return tint


def _noise(points: Float64) -> Float64:
    """Smooth values (n,) from 0 to 1 that change over a distance of about 1 (value noise)."""
    cell = np.floor(points)
    part = (points - cell).astype(np.float32)
    part = part * part * (3.0 - 2.0 * part)
    lattice = cell.astype(np.int64).astype(np.uint64)
    # The part of each axis in the key of its lower and of its upper corners.
    keys = [
        (lattice[:, axis] * prime, (lattice[:, axis] + _ONE) * prime)
        for axis, prime in enumerate(_PRIMES)
    ]
    x, y, z = part.T
    lower, upper = (
        _mixed(
            _mixed(_hashed(keys[0][0] ^ key ^ deep), _hashed(keys[0][1] ^ key ^ deep), x),
            _mixed(_hashed(keys[0][0] ^ far ^ deep), _hashed(keys[0][1] ^ far ^ deep), x),
            y,
        )
        for key, far, deep in ((*keys[1], keys[2][0]), (*keys[1], keys[2][1]))
    )
    return _mixed(lower, upper, z).astype(np.float64)


_ONE = np.uint64(1)
_PRIMES = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)


def _mixed(first: Float32, second: Float32, part: Float32) -> Float32:
    mixed: Float32 = first + part * (second - first)
    return mixed


def _hashed(key: npt.NDArray[np.uint64]) -> Float32:
    """A number (n,) from 0 to 1 for each key of a lattice point (n,)."""
    key = (key ^ key >> np.uint64(29)) * np.uint64(0xBF58476D1CE4E5B9)
    values: Float32 = (key >> np.uint64(40)).astype(np.float32)
    values *= np.float32(2.0**-24)
    return values
