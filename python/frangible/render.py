"""Pictures: one frame, ray-traced on the processor, without a display or a graphics driver."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from PIL import Image

from .camera import Camera, frame_bodies
from .ground import is_half_space, patch
from .materials import INSIDE, source_colours
from .normals import shaded_mesh
from .paths import by_source
from .recording import Body, Float64, Recording, rotation_matrix

WIDTH, HEIGHT = 1280, 720
#: Samples of a pixel in each direction.
SUBPIXELS = 2
#: Rays to the sky and to the lamp from each sample: 32 and 20 for each pixel.
SKY_RAYS, LAMP_RAYS = 8, 5
#: Rows of pixels that one task traces.
BAND = 24

#: Towards the lamp, over the right shoulder of the camera (right, up, back).
LAMP = np.array([0.70, 1.15, 0.65]) / np.linalg.norm([0.70, 1.15, 0.65])
#: The lamp's radius over its distance: shadows soften with the distance from what casts them.
LAMP_RADIUS = 0.06
LAMP_COLOUR = np.array([2.55, 2.25, 1.85])
SKY_COLOUR = np.array([0.56, 0.68, 0.88])
#: What comes back from a surface that blocks the sky.
BOUNCE_COLOUR = np.array([0.16, 0.145, 0.13])
FLOOR_COLOUR = np.array([0.25, 0.26, 0.28])
#: The floor fades into the haze at the horizon, which fades into the zenith.
HAZE_COLOUR = np.array([0.52, 0.57, 0.64])
ZENITH_COLOUR = np.array([0.20, 0.27, 0.38])
EXPOSURE = 0.58

# Steps of the two-dimensional golden-ratio sequence, which fills a square evenly (M. Roberts, 2018).
_R2 = np.array([0.7548776662466927, 0.5698402909980532])


def write_png(recording: Recording, path: str, frame: int) -> None:
    """Write a picture of a frame."""
    Image.fromarray(picture(recording, frame)).save(path, format="PNG")


def picture(recording: Recording, frame: int, width: int = WIDTH, height: int = HEIGHT) -> npt.NDArray[np.uint8]:
    """A picture of a frame, (height, width, 3), sRGB."""
    camera = frame_bodies(recording.bodies, frame, width / height)
    stage = _build_stage(recording, frame, camera)

    # Bands of rows are independent of each other and of the number of threads.
    def trace(top: int) -> npt.NDArray[np.uint8]:
        return _trace_band(stage, camera, top, min(top + BAND, height), width, height)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.concatenate(list(pool.map(trace, range(0, height, BAND))))


@dataclass(frozen=True, slots=True)
class _Stage:
    """All triangles of a frame in the world frame, and how they look."""

    scene: Any
    #: (t, 3, 3) unit normals at the corners.
    corner_normals: Float64
    #: (t, 3) linear RGB.
    colours: Float64
    #: Index of the first triangle of half-spaces, which come last.
    first_floor: int
    #: Distance from the camera to the subject, and the scale of everything else [m].
    distance: float
    #: Unit vector towards the lamp.
    lamp: Float64


def _build_stage(recording: Recording, frame: int, camera: Camera) -> _Stage:
    families = by_source(recording.bodies)
    palette = source_colours(families)
    distance = float(np.linalg.norm(camera.target - camera.eye))

    # Place and colour every living body, except what the whole scene rests on.
    corners, normals, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    floors = []
    for body in recording.alive(frame):
        if is_half_space(body):
            floors.append(body)
        if not len(body.triangles):
            continue
        shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
        turned = shaded.normals @ rotation_matrix(body.pose(frame)[1]).T
        corners.append(body.vertices_world(frame)[body.triangles])
        normals.append(turned[shaded.triangles])
        outside, inside = _tint(body, np.array(palette[body.source])), _tint(body, np.array(INSIDE))
        colours.append(np.where(body.interior[:, None], inside, outside))

    # A half-space is two triangles that reach beyond the haze.
    first_floor = sum(map(len, corners))
    for body in floors:
        position, orientation = body.pose(frame)
        rotation = rotation_matrix(orientation)
        quad = patch(body, camera.target, 2e3 * distance) @ rotation.T + position
        corners.append(quad[[[0, 1, 2], [0, 2, 3]]])
        normals.append(np.broadcast_to(rotation[:, 1], (2, 3, 3)))
        colours.append(np.broadcast_to(FLOOR_COLOUR, (2, 3)))
    scene = EmbreeScene(robust=True)
    soup = np.concatenate(corners)
    if len(soup):
        TriangleMesh(scene, np.ascontiguousarray(soup - camera.target, np.float32))
    # The lamp keeps its place beside the camera.
    right = camera.axes[0]
    back = np.cross(right, [0.0, 1.0, 0.0])
    lamp = LAMP @ np.array([right, [0.0, 1.0, 0.0], back])
    return _Stage(scene, np.concatenate(normals), np.concatenate(colours), first_floor, distance, lamp)


def _tint(body: Body, colour: Float64) -> Float64:
    """Pieces differ by a touch of brightness and warmth, so that they can be told apart."""
    if body.parent is None:
        return colour
    brightness, warmth = (body.id * _R2) % 1.0
    tinted: Float64 = colour * (0.82 + 0.34 * brightness) * (1.0 + (warmth - 0.5) * np.array([0.10, 0.0, -0.12]))
    return tinted


def _trace_band(stage: _Stage, camera: Camera, top: int, bottom: int, width: int, height: int) -> npt.NDArray[np.uint8]:
    # Every pixel shifts the sample pattern by an offset of its own.
    y, x = (axis.ravel().astype(np.float64) for axis in np.mgrid[top:bottom, 0:width])
    offsets = np.random.default_rng(top).random((len(x), 4))

    # The mean over the samples of a pixel, taken after the tone curve, so that bright edges stay smooth.
    total = np.zeros((len(x), 3))
    for sample in range(SUBPIXELS**2):
        column, row = sample % SUBPIXELS, sample // SUBPIXELS
        directions = camera.rays(x + (column + 0.5) / SUBPIXELS, y + (row + 0.5) / SUBPIXELS, width, height)
        total += _tone(_radiance(stage, camera, directions, offsets, sample))
    encoded = np.round(255.0 * total / SUBPIXELS**2).astype(np.uint8)
    return encoded.reshape(bottom - top, width, 3)


def _radiance(stage: _Stage, camera: Camera, directions: Float64, offsets: Float64, sample: int) -> Float64:
    """Light (n, 3) that arrives at the eye from directions (n, 3)."""
    # What the rays hit; the stage is centred on the camera's target.
    colour = _backdrop(directions)
    eye = camera.eye - camera.target
    hits = _hits(stage.scene, np.broadcast_to(eye, directions.shape), directions)
    hit = np.flatnonzero(hits["primID"] >= 0)
    if not len(hit):
        return colour
    triangle, depth = hits["primID"][hit], hits["tfar"][hit].astype(np.float64)
    u, v = hits["u"][hit, None].astype(np.float64), hits["v"][hit, None].astype(np.float64)
    view = directions[hit]
    points = eye + depth[:, None] * view

    # Shading normals, and the side of the surface that the eye is on.
    n0, n1, n2 = stage.corner_normals[triangle].swapaxes(0, 1)
    normals = _unit((1.0 - u - v) * n0 + u * n1 + v * n2)
    flat = _unit(hits["Ng"][hit].astype(np.float64))
    flat *= np.where(np.sum(flat * view, axis=1, keepdims=True) > 0.0, -1.0, 1.0)
    normals *= np.where(np.sum(flat * normals, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    lifted = points + 2e-5 * stage.distance * flat

    # Light from the lamp and from the sky, and a faint sheen.
    lamp = _lamp_light(stage, lifted, offsets[hit, :2], sample)
    sky = _sky_light(stage, lifted, normals, offsets[hit, 2:], sample)
    albedo = stage.colours[triangle]
    on_floor = triangle >= stage.first_floor
    albedo = np.where(on_floor[:, None], albedo * _grid_lines(stage, points + camera.target, depth)[:, None], albedo)
    sheen = 0.14 * np.maximum(np.sum(normals * _unit(stage.lamp - view), axis=1, keepdims=True), 0.0) ** 48
    facing = np.maximum(normals @ stage.lamp, 0.0)[:, None]
    lit = albedo * (lamp * facing + sky) + np.where(on_floor[:, None], 0.0, sheen) * lamp * (facing > 0.0)

    # The floor dissolves into the haze.
    haze = np.where(on_floor, 1.0 - np.exp(-((depth / (5.0 * stage.distance)) ** 2)), 0.0)[:, None]
    colour[hit] = lit * (1.0 - haze) + HAZE_COLOUR * haze
    return colour


def _lamp_light(stage: _Stage, points: Float64, offsets: Float64, sample: int) -> Float64:
    """Light of the lamp (n, 3) that gets past everything in between, before the cosine."""
    across, along = _tangents(stage.lamp[None])
    visible = np.zeros(len(points))
    for ray in range(LAMP_RAYS):
        x = (offsets + (sample * LAMP_RAYS + ray) * _R2) % 1.0
        radius, angle = LAMP_RADIUS * np.sqrt(x[:, :1]), 2.0 * np.pi * x[:, 1:]
        towards = _unit(stage.lamp + radius * (np.cos(angle) * across + np.sin(angle) * along))
        visible += _is_open(stage.scene, points, towards)
    light: Float64 = (visible / LAMP_RAYS)[:, None] * LAMP_COLOUR
    return light


def _sky_light(stage: _Stage, points: Float64, normals: Float64, offsets: Float64, sample: int) -> Float64:
    """Light of the sky (n, 3), over the half sphere weighted by the cosine."""
    across, along = _tangents(normals)
    light = np.zeros((len(points), 3))
    for ray in range(SKY_RAYS):
        x = (offsets + (sample * SKY_RAYS + ray) * _R2) % 1.0
        radius, angle = np.sqrt(x[:, :1]), 2.0 * np.pi * x[:, 1:]
        towards = np.sqrt(1.0 - x[:, :1]) * normals + radius * (np.cos(angle) * across + np.sin(angle) * along)
        free = _is_open(stage.scene, points, towards)[:, None] * (0.35 + 0.65 * np.clip(towards[:, 1:2] + 0.4, 0.0, 1.0))
        light += free * SKY_COLOUR + (1.0 - free) * BOUNCE_COLOUR
    return light / SKY_RAYS


def _grid_lines(stage: _Stage, points: Float64, depth: Float64) -> Float64:
    """Brightness (n,) of a faint grid that fades with distance; its squares are a power of ten of metres wide."""
    spacing = 10.0 ** max(np.ceil(np.log10(stage.distance / 30.0)), -6.0)
    pixel = depth * 1.1e-3
    off_line = np.abs((points[:, [0, 2]] / spacing + 0.5) % 1.0 - 0.5) * spacing
    line = np.clip(1.5 - off_line.min(axis=1) / pixel, 0.0, 1.0)
    faded: Float64 = 1.0 - 0.22 * line * np.exp(-((depth / (2.0 * stage.distance)) ** 2))
    return faded


def _backdrop(directions: Float64) -> Float64:
    height = np.clip(directions[:, 1:2] * 2.2, 0.0, 1.0)
    return HAZE_COLOUR * (1.0 - height) + ZENITH_COLOUR * height


def _tone(radiance: Float64) -> Float64:
    """The film curve of Narkowicz (2015), then the sRGB encoding."""
    x = radiance * EXPOSURE
    film = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    return np.where(film <= 0.0031308, 12.92 * film, 1.055 * film ** (1.0 / 2.4) - 0.055)


def _hits(scene: Any, origins: Float64, directions: Float64) -> dict[str, npt.NDArray[Any]]:
    hits: dict[str, npt.NDArray[Any]] = scene.run(
        np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32), output=1
    )
    return hits


def _is_open(scene: Any, origins: Float64, directions: Float64) -> npt.NDArray[np.bool_]:
    blocked = scene.run(
        np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32), query="OCCLUDED"
    )
    return np.asarray(blocked) < 0


def _tangents(normals: Float64) -> tuple[Float64, Float64]:
    """Two unit vectors (n, 3) each, across every normal and each other (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    across = np.column_stack([1.0 + sign * x * x * a, sign * b, -sign * x])
    return across, np.column_stack([b, sign + y * y * a, -y])


def _unit(vectors: Float64) -> Float64:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Float64 = vectors / np.where(length > 0.0, length, 1.0)
    return unit
