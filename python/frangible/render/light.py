"""How much light of the lamp and of the sky reaches what a picture shows.

Neighbouring pixels ask different rays, sixteen of them in turn, and share what they learn with
those that show the same surface (interleaved sampling: A. Keller and W. Heidrich, 2001).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..recording import Bool, Float32
from .palette import GOLDEN_STEPS
from .stage import Int32, Stage
from .tracing import openness, unit

#: The lamp's radius over its distance: shadows soften with the distance from what casts them.
LAMP_RADIUS = 0.06
LAMP_COLOUR = np.array([2.55, 2.25, 1.85], np.float32)
SKY_COLOUR = np.array([0.56, 0.68, 0.88], np.float32)
#: Light back from a surface that blocks the sky.
BOUNCE_COLOUR = np.array([0.16, 0.145, 0.13], np.float32)
#: How much of the lamp's light glass lets through.
GLASS_SHADOW = 0.78
#: Rays to the sky and to the lamp from each pixel, and from one that shares with few others.
SKY_RAYS, LAMP_RAYS = 2, 2
MORE_SKY_RAYS, MORE_LAMP_RAYS = 12, 8
#: Pixels in a row that ask different rays.
TILE = 4
#: Pixels share light if their normals differ by less (cosine), and if they lie in one plane up to
#: so many pixels' widths.
SAME_NORMAL, SAME_PLANE = 0.92, 1.5
#: A pixel that shares with fewer asks more rays itself, of 16 at most.
FEW = 5.0

#: Light (n, 3): share of the lamp that is seen, light of the open sky, share of the sky that is
#: blocked.
Light = Float32


def gather_light(
    stage: Stage,
    points: Float32,
    normals: Float32,
    slots: npt.NDArray[np.int64],
    sky: int,
    lamp: int,
) -> Light:
    """Light at points (n, 3), of so many rays; points with different slots (n,) ask different
    ones."""
    light = np.zeros((len(points), 3), np.float32)
    if not len(points):
        return light
    count = int(slots.max()) + 1
    across, along = _tangents(normals)

    # The lamp is a disc, far away.
    disc_x, disc_y = _tangents(stage.lamp[None])
    for ray in range(lamp):
        radius, cosine, sine = _disc(np.arange(count) * lamp + ray)
        aim = stage.lamp + LAMP_RADIUS * radius[:, None] * (
            cosine[:, None] * disc_x + sine[:, None] * disc_y
        )
        light[:, 0] += openness(stage, points, unit(aim.astype(np.float32))[slots], GLASS_SHADOW)

    # The sky, weighted by the cosine.
    for ray in range(sky):
        radius, cosine, sine = _disc(np.arange(count) * sky + ray)
        up = np.sqrt(np.maximum(1.0 - radius**2, 0.0)).astype(np.float32)
        towards = up[slots, None] * normals
        towards += (radius * cosine).astype(np.float32)[slots, None] * across
        towards += (radius * sine).astype(np.float32)[slots, None] * along
        free = openness(stage, points, towards, GLASS_SHADOW)
        light[:, 1] += free * (0.35 + 0.65 * np.clip(towards[:, 1] + 0.4, 0.0, 1.0))
        light[:, 2] += 1.0 - free
    light[:, 0] /= lamp
    light[:, 1:] /= sky
    return light


def share_light(
    light: Light, key: Int32, points: Float32, normals: Float32, width: Float32
) -> tuple[Light, Bool]:
    """Light (h, w, 3) averaged over neighbours that show the same, and which pixels (h, w) have
    few.

    ``key`` (h, w) tells surfaces apart, -1 for none; ``width`` (h, w) is that of a pixel there [m].
    """
    total = np.concatenate([light, np.ones((*light.shape[:2], 1), np.float32)], axis=2)
    for axis in (1, 0):
        total = _share_along(axis, total, key, points, normals, width)
    weight = total[:, :, 3:]
    shared: Light = total[:, :, :3] / np.maximum(weight, 1e-6)
    return shared, (weight[:, :, 0] < FEW) & (key >= 0)


def _share_along(
    axis: int, total: Float32, key: Int32, points: Float32, normals: Float32, width: Float32
) -> Float32:
    shared = total.copy()
    for step in (1, 2):
        near = [slice(None)] * 2
        far = [slice(None)] * 2
        near[axis], far[axis] = slice(None, -step), slice(step, None)
        here, there = tuple(near), tuple(far)
        same = (key[here] == key[there]) & (key[here] >= 0)
        same &= np.einsum("ijk,ijk->ij", normals[here], normals[there]) > SAME_NORMAL
        apart = np.einsum("ijk,ijk->ij", points[there] - points[here], normals[here])
        same &= np.abs(apart) < SAME_PLANE * width[here]
        # Of five pixels in a row each of the four rays counts once.
        weight = same.astype(np.float32)[:, :, None] * np.float32(1.0 if step == 1 else 0.5)
        shared[here] += weight * total[there]
        shared[there] += weight * total[here]
    return shared


def colour_of_lamp(light: Light) -> Float32:
    """Light (n, 3) of the lamp, before the cosine."""
    coloured: Float32 = light[:, :1] * LAMP_COLOUR
    return coloured


def colour_of_sky(light: Light) -> Float32:
    """Light (n, 3) of the sky and of what blocks it."""
    coloured: Float32 = light[:, 1:2] * SKY_COLOUR + light[:, 2:] * BOUNCE_COLOUR
    return coloured


def _disc(index: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.float64], ...]:
    """Points of a disc, evenly spread: radius, cosine and sine of the angle, (n,) each."""
    x = ((index[:, None] + 0.5) * GOLDEN_STEPS) % 1.0
    angle = 2.0 * np.pi * x[:, 1]
    return np.sqrt(x[:, 0]), np.cos(angle), np.sin(angle)


def _tangents(normals: Float32) -> tuple[Float32, Float32]:
    """Two unit vectors (n, 3) each, across every normal and each other (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0.0, np.float32(1.0), np.float32(-1.0))
    a = -1.0 / (sign + z)
    b = x * y * a
    across = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return across, np.stack([b, sign + y * y * a, -y], axis=1)
