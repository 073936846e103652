"""Rotations of many transforms at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..recording import Float64


class Turns(NamedTuple):
    """The rotations that are nearest to some linear maps."""

    #: (n, 3, 3), of columns.
    matrices: Float64
    #: (n, 4) unit, x, y, z, w.
    quaternions: Float64


def quaternions_of(linear: Float64) -> Turns:
    """Of (n, 3, 3), of columns; a reflection turns all axes."""
    signs = np.where(np.linalg.det(linear) < 0.0, -1.0, 1.0)
    left, _, right = np.linalg.svd(linear * signs[:, None, None])
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[:, None]
    m: Float64 = left @ right
    # Four ways to the quaternion: the one that divides by the largest part (Shepperd 1978).
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    parts = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2], trace], axis=1)
    largest = np.argmax(parts, axis=1)
    found = np.zeros((len(m), 4))
    for axis in range(3):
        i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
        rows = largest == axis
        found[rows, i] = 1.0 - trace[rows] + 2.0 * m[rows, i, i]
        found[rows, j] = m[rows, j, i] + m[rows, i, j]
        found[rows, k] = m[rows, k, i] + m[rows, i, k]
        found[rows, 3] = m[rows, k, j] - m[rows, j, k]
    rows = largest == 3
    skew = np.stack([m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]], 1)
    found[rows, :3], found[rows, 3] = skew[rows], 1.0 + trace[rows]
    return Turns(m, found / np.linalg.norm(found, axis=1, keepdims=True))


def matrices_of(quaternions: Float64) -> Float64:
    """(n, 3, 3), of columns, of quaternions (n, 4) x, y, z, w of any length."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    x, y, z, w = (quaternions / np.where(lengths > 0.0, lengths, 1.0)).T
    rows: Float64 = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    return rows
