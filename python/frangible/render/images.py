"""Images and colours of a mesh's file, as a picture shows them."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from ..recording import Body, Float32

#: Edge of the largest image that is looked up; larger ones are halved until they fit [pixels].
LARGEST = 4096


@dataclass(frozen=True, slots=True)
class Pictures:
    """Material of each triangle of some bodies, from their files."""

    #: Each image, and all of its halvings: (h, w, 3) linear RGB.
    images: list[list[Float32]]
    #: (t,) index of the triangle's image, -1 for none.
    image: npt.NDArray[np.int32]
    #: (t, 3, 2) texture coordinates at the corners, v up.
    coordinates: Float32
    #: (t, 3) colour of the triangle's material, NaN where the body's look decides.
    base: Float32
    #: (t, 2) share of light that passes, and that is mirrored as from metal.
    shares: Float32
    #: (t, 3, 3) colours at the corners; `None` if no body has any.
    corners: Float32 | None

    @staticmethod
    def of(bodies: list[Body]) -> Pictures:
        """The pictures of bodies with skins; an image that cannot be read shows white."""
        count = sum(len(body.triangles) for body in bodies)
        image = np.full(count, -1, np.int32)
        coordinates = np.zeros((count, 3, 2), np.float32)
        base = np.full((count, 3), np.nan, np.float32)
        shares = np.zeros((count, 2), np.float32)
        corners = None
        images: list[list[Float32]] = []
        known: dict[bytes, int] = {}
        stop = 0
        for body in bodies:
            start, stop = stop, stop + len(body.triangles)
            skin = body.skin
            if skin is None:
                continue
            rows = slice(start, stop)
            coordinates[rows] = body.coordinates
            for index, material in enumerate(skin.materials):
                own = start + np.flatnonzero(skin.material == index)
                base[own] = material.colour
                shares[own] = material.clear, material.metallic
                if material.image is not None and len(own):
                    if material.image.data not in known:
                        known[material.image.data] = len(images)
                        images.append(_levels(material.image.data))
                    image[own] = known[material.image.data]
            if skin.colours is not None:
                corners = np.ones((count, 3, 3), np.float32) if corners is None else corners
                corners[rows] = skin.colours[:, :, :3]
        return Pictures(images, image, coordinates, base, shares, corners)

    def colour(self, colours: Float32, shares: Float32) -> None:
        """Put the materials' colours (t, 3) and shares (t, 2) in place of the looks'."""
        own = ~np.isnan(self.base[:, 0])
        colours[own] = self.base[own]
        shares[own] = self.shares[own]

    def tint(
        self, triangle: npt.NDArray[np.int32], weights: Float32, footprint: Float32
    ) -> Float32 | None:
        """The factors of colours (n, 3) at places of triangles; `None` without any.

        ``footprint`` (n,) is a pixel's width over the mean edge of the triangle.
        """
        if not self.images and self.corners is None:
            return None
        factor = np.ones((len(triangle), 3), np.float32)
        second, third = weights[:, 0, None], weights[:, 1, None]
        if self.corners is not None:
            at = self.corners[triangle]
            factor *= at[:, 0] * (1 - second - third) + at[:, 1] * second + at[:, 2] * third
        for index, levels in enumerate(self.images):
            rows = np.flatnonzero(self.image[triangle] == index)
            if len(rows):
                at = self.coordinates[triangle[rows]]
                two, three = second[rows], third[rows]
                place = at[:, 0] * (1 - two - three) + at[:, 1] * two + at[:, 2] * three
                edges = np.abs(at - np.roll(at, 1, axis=1)).max(axis=(1, 2))
                factor[rows] *= _look_up(levels, place, edges * footprint[rows])
        return factor


def _levels(data: bytes) -> list[Float32]:
    try:
        with Pillow.open(io.BytesIO(data)) as opened:
            opened.thumbnail((LARGEST, LARGEST))
            encoded = np.asarray(opened.convert("RGB"), np.float32) / 255.0
    except (OSError, ValueError, SyntaxError, Pillow.DecompressionBombError):
        return [np.ones((1, 1, 3), np.float32)]
    low = encoded <= 0.04045
    level = np.where(low, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)
    levels = [level]
    while min(level.shape[:2]) > 1:
        even = level[: level.shape[0] // 2 * 2, : level.shape[1] // 2 * 2]
        rows = even[::2] + even[1::2]
        level = ((rows[:, ::2] + rows[:, 1::2]) / 4).astype(np.float32)
        levels.append(level)
    return levels


def _look_up(levels: list[Float32], place: Float32, width: Float32) -> Float32:
    """Colours (n, 3) of a repeated image at places (n, 2), over about a width (n,) of it."""
    size = max(levels[0].shape[:2])
    level = np.clip(np.log2(np.maximum(width * size, 1.0)), 0, len(levels) - 1).astype(np.int64)
    colours = np.ones((len(place), 3), np.float32)
    for index in np.unique(level).tolist():
        rows = level == index
        colours[rows] = _bilinear(levels[index], place[rows])
    return colours


def _bilinear(image: Float32, place: Float32) -> Float32:
    height, width = image.shape[:2]
    x = place[:, 0] * width - 0.5
    y = (1.0 - place[:, 1]) * height - 0.5
    left, top = np.floor(x), np.floor(y)
    right_part, low_part = (x - left)[:, None], (y - top)[:, None]
    x0, y0 = left.astype(np.int64) % width, top.astype(np.int64) % height
    x1, y1 = (x0 + 1) % width, (y0 + 1) % height
    upper = image[y0, x0] * (1 - right_part) + image[y0, x1] * right_part
    lower = image[y1, x0] * (1 - right_part) + image[y1, x1] * right_part
    mixed: Float32 = upper * (1 - low_part) + lower * low_part
    return mixed
