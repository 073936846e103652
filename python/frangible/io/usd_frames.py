"""Rigid frames in transforms of USD, which multiply rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Float64

#: Rows of a matrix that meet at a right angle to this part of their lengths are not sheared.
SQUARE = 1e-5


@dataclass(frozen=True, slots=True)
class Frame:
    """A rotation and a place: a point is ``point_local @ rotation + origin`` outside."""

    rotation: Float64
    #: [m]
    origin: Float64

    def matrix(self) -> Float64:
        """(4, 4), rows."""
        return affine(self.rotation, self.origin)

    def quaternion(self) -> list[float]:
        """x, y, z, w of the rotation."""
        return quaternion(self.rotation)


def tidy(value: float) -> float:
    """A number without the last digits, which are rounding of singles and of products with them."""
    short = float(f"{value:.6g}")
    return short if abs(short - value) <= 6e-8 * abs(value) else float(f"{value:.12g}")


def tidy_list(values: Float64) -> list[float]:
    """All of an array (n,)."""
    return [tidy(number) + 0.0 for number in values.tolist()]


def affine(linear: Float64, origin: Float64) -> Float64:
    """(4, 4) of a linear part and a translation."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = linear, origin
    return matrix


def frame_of(matrix: Float64) -> Frame:
    """The rigid frame that is nearest to a transform: its scale is left out, and a reflection turns
    all axes."""
    linear = matrix[:3, :3]
    if np.linalg.det(linear) < 0.0:
        linear = -linear
    left, _, right = np.linalg.svd(linear)
    rotation: Float64 = left @ right
    if np.linalg.det(rotation) < 0.0:
        left[:, -1] *= -1.0
        rotation = left @ right
    # The usual rotations come out without rounding.
    near = np.round(rotation)
    if np.abs(rotation - near).max() < 1e-12:
        rotation = near + 0.0
    return Frame(rotation, matrix[3, :3].copy())


def scales(matrix: Float64) -> Float64 | None:
    """(3,) lengths of the axes; `None` if the transform shears."""
    linear = matrix[:3, :3]
    lengths: Float64 = np.linalg.norm(linear, axis=1)
    if np.any(lengths == 0.0):
        return None
    cosines = (linear / lengths[:, None]) @ (linear / lengths[:, None]).T
    return lengths if np.abs(cosines - np.eye(3)).max() < SQUARE else None


def quaternion(rotation: Float64) -> list[float]:
    """x, y, z, w of a rotation matrix that multiplies rows."""
    m = rotation.T
    trace = float(m[0, 0] + m[1, 1] + m[2, 2])
    found = np.zeros(4)
    largest = int(np.argmax([m[0, 0], m[1, 1], m[2, 2], trace]))
    if largest == 3:
        found[:] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + trace
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        found[i] = 1.0 - trace + 2.0 * m[i, i]
        found[j] = m[j, i] + m[i, j]
        found[k] = m[k, i] + m[i, k]
        found[3] = m[k, j] - m[j, k]
    found /= np.linalg.norm(found)
    if found[3] < 0.0:
        found = -found
    return [float(number) + 0.0 for number in found]


def rotation_of(orientation: list[float]) -> Float64:
    """The rotation, for rows, of a quaternion x, y, z, w of any length."""
    x, y, z, w = np.array(orientation, np.float64) / np.linalg.norm(orientation)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
