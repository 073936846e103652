"""Shading: the colour of surfaces in the light that reaches them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..recording import Float32
from .light import LAMP_COLOUR, Light, colour_of_lamp, colour_of_sky
from .stage import FLOOR_COLOUR, Stage
from .textures import concrete, wood
from .tracing import Hits, dot, unit

#: The floor fades into the haze at the horizon, which fades into the zenith.
HAZE_COLOUR = np.array([0.52, 0.57, 0.64], np.float32)
ZENITH_COLOUR = np.array([0.20, 0.27, 0.38], np.float32)
EXPOSURE = 0.58
#: Reflectance of glass face on, from both of its sides.
GLASS_REFLECTANCE = 0.045
#: Light on glass itself, of which little comes back: the lamp, and most of the sky.
ON_GLASS = np.array([[1.0, 0.62, 0.2]], np.float32)


def shade(
    stage: Stage, at: Hits, view: Float32, depth: Float32, light: Light, pixel: float
) -> Float32:
    """Light (n, 3) that comes back along rays (n, 3), from a depth (n,), in light (n, 3).

    ``pixel`` is a pixel's width at a depth of 1.
    """
    albedo = _albedo(stage, at, depth * np.float32(pixel))
    lamp, sky = colour_of_lamp(light), colour_of_sky(light)
    metallic = stage.metallic[at.triangle, None]
    facing = np.maximum(at.normals @ stage.lamp, 0.0)[:, None]
    gloss = np.maximum(dot(at.normals, unit(stage.lamp - view)), 0.0)[:, None]
    lit: Float32 = albedo * (lamp * facing + sky)
    is_plane = (at.triangle >= stage.first_plane)[:, None]
    sheen = 0.14 * gloss**48 * ((facing > 0.0) & ~is_plane & (metallic < 1.0)) * (1.0 - metallic)

    # Metal mirrors the sky instead.
    rows = np.flatnonzero(metallic[:, 0] > 0.0)
    if len(rows):
        share = metallic[rows]
        mirrored = albedo[rows] * backdrop(reflected(view[rows], at.normals[rows])) * share
        lit[rows] = lit[rows] * (1.0 - 0.6 * share) + mirrored
        sheen[rows] += 0.9 * gloss[rows] ** 140 * share * (facing[rows] > 0.0)
    lit += sheen * lamp

    # The floor has a faint grid, and dissolves into the haze.
    rows = np.flatnonzero(is_plane[:, 0])
    if len(rows):
        lit[rows] *= _grid_lines(stage, at, depth, rows, pixel)[:, None]
        haze = (1.0 - np.exp(-((depth[rows] / (5.0 * stage.distance)) ** 2)))[:, None]
        lit[rows] += haze * (HAZE_COLOUR - lit[rows])
    return lit


def _albedo(stage: Stage, at: Hits, width: Float32) -> Float32:
    """Colours (n, 3) of surfaces with what shows on them, over the width of a pixel (n,)."""
    albedo = stage.colours[at.triangle]
    body = stage.body[at.triangle]
    for look, chosen in stage.looks.items():
        rows = np.flatnonzero(chosen[body]) if chosen.any() else np.zeros(0, np.int64)
        if not len(rows):
            continue
        offsets = at.points[rows] - stage.centres[body[rows]]
        points = np.einsum("nij,nj->ni", stage.axes[body[rows]], offsets)
        if look == "wood":
            albedo[rows] *= wood(points)
        else:
            albedo[rows] *= concrete(points, stage.interior[at.triangle[rows]])
    pictures = stage.surfaces.pictures
    rows = np.flatnonzero(at.triangle < stage.first_plane)
    if len(rows) and (pictures.images or pictures.corners is not None):
        shown = stage.shown[at.triangle[rows]]
        footprint = width[rows] / stage.surfaces.edge(shown)
        factor = pictures.tint(shown, at.weights[rows], footprint)
        if factor is not None:
            albedo[rows] *= factor
    return albedo


def glass(stage: Stage, at: Hits, view: Float32) -> tuple[Float32, Float32]:
    """The share that a surface of glass reflects (n, 1), and the light that it reflects (n, 3).

    By Schlick's formula.
    """
    cosine = np.clip(-dot(at.normals, view), 0.0, 1.0)[:, None]
    reflectance = GLASS_REFLECTANCE + (1.0 - GLASS_REFLECTANCE) * (1.0 - cosine) ** 5
    mirror = reflected(view, at.normals)
    sparkle = 6.0 * np.maximum(mirror @ stage.lamp, 0.0)[:, None] ** 700 * LAMP_COLOUR
    sky = np.where(mirror[:, 1:2] > 0.0, np.float32(1.7) * backdrop(mirror), FLOOR_COLOUR)
    return reflectance, reflectance * sky + sparkle


def reflected(view: Float32, normals: Float32) -> Float32:
    """Directions (n, 3) of mirrored rays."""
    mirrored: Float32 = view - 2.0 * dot(view, normals)[:, None] * normals
    return mirrored


def _grid_lines(stage: Stage, at: Hits, depth: Float32, rows: np.ndarray, pixel: float) -> Float32:
    """Brightness (n,) of a faint grid that fades with distance, of a power of ten of metres."""
    spacing = np.float32(stage.spacing)
    places = at.points[rows][:, [0, 2]] + stage.grid_offset
    off_line = np.abs((places / spacing + 0.5) % 1.0 - 0.5) * spacing
    line = np.clip(1.5 - off_line.min(axis=1) / (1.6 * pixel * depth[rows]), 0.0, 1.0)
    faded: Float32 = 1.0 - 0.22 * line * np.exp(-((depth[rows] / (2.0 * stage.distance)) ** 2))
    return faded


def backdrop(directions: Float32) -> Float32:
    """Light (n, 3) from beyond everything."""
    height = np.clip(directions[:, 1:2] * np.float32(2.2), 0.0, 1.0)
    colour: Float32 = HAZE_COLOUR + height * (ZENITH_COLOUR - HAZE_COLOUR)
    return colour


def tone(radiance: Float32) -> Float32:
    """The film curve of Narkowicz (2015), then the sRGB encoding."""
    x = np.maximum(radiance, 0.0) * np.float32(EXPOSURE)
    film = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    return encoded(film)


def encoded(light: npt.NDArray[Any]) -> Float32:
    """sRGB of light from 0 to 1."""
    values: Float32 = np.where(
        light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, np.float32(1.0 / 2.4)) - 0.055
    )
    return values


def decoded(values: Float32) -> Float32:
    """Light from 0 to 1 of sRGB."""
    light: Float32 = np.where(
        values <= 0.04045, values / 12.92, np.power((values + 0.055) / 1.055, np.float32(2.4))
    )
    return light
