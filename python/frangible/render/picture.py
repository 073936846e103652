"""Pictures: one frame, ray-traced on the processor, without a display or a graphics driver."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from ..recording import Float32, Recording
from .camera import Camera, MovingCamera, frame_recording
from .light import (
    LAMP_RAYS,
    MORE_LAMP_RAYS,
    MORE_SKY_RAYS,
    SAME_NORMAL,
    SAME_PLANE,
    SKY_RAYS,
    TILE,
    gather_light,
    share_light,
)
from .shading import ON_GLASS, backdrop, decoded, encoded, glass, shade, tone
from .shutter import CLOSED, Shutter, moves_between
from .stage import Int32, Stage, Surfaces, build_stage, gather_surfaces
from .tracing import Hits, dot, trace, where_lit

WIDTH, HEIGHT = 1280, 720
#: Rows of pixels that one task works on.
BAND = 24
#: Surfaces of glass that a ray passes, one behind the other; what lies behind more is not seen.
GLASS_LAYERS = 12
#: Pixels whose colours differ by more are an edge, which is sampled again, at these places.
CONTRAST = 0.05
PLACES = ((0.125, 0.625), (0.375, 0.125), (0.625, 0.875), (0.875, 0.375))
#: Samples on edges that are worked on at once.
CHUNK = 30_000

#: Which of 16 rays each pixel of a tile asks: neighbours ask what is far apart.
TILES = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])

#: Places within a pixel step down by so much of it from sample to sample.
GOLDEN = (5.0**0.5 - 1.0) / 2.0

#: Called with how much of a picture is done, and of how much.
PictureProgress = Callable[[int, int], None]


def write_png(
    recording: Recording,
    path: str,
    frame: int,
    camera: Camera | MovingCamera | None = None,
    size: tuple[int, int] = (WIDTH, HEIGHT),
    progress: PictureProgress | None = None,
    shutter: Shutter = CLOSED,
) -> None:
    """Write a picture of a frame."""
    image = picture(recording, frame, *size, camera, progress=progress, shutter=shutter)
    Image.fromarray(image).save(path, format="PNG")


def picture(
    recording: Recording,
    frame: int,
    width: int = WIDTH,
    height: int = HEIGHT,
    camera: Camera | MovingCamera | None = None,
    surfaces: Surfaces | None = None,
    progress: PictureProgress | None = None,
    threads: int | None = None,
    shutter: Shutter = CLOSED,
) -> npt.NDArray[np.uint8]:
    """A picture of a frame, (height, width, 3), sRGB, drawn by threads, as many as processors.

    Of many frames, the camera and the surfaces are best made once.
    """
    camera = camera or frame_recording(recording, width / height)
    surfaces = surfaces or gather_surfaces(recording, frame)
    times = shutter.times(frame)
    if len(times) > 1 and _is_still(surfaces, camera, frame, times[-1]):
        times = [float(frame)]
    steps = 0
    # Bands of rows are independent of each other and of the number of threads.
    whole = (3 if len(times) == 1 else 2 * len(times)) * len(_bands(height))

    def tick(count: int) -> None:
        nonlocal steps
        steps += count
        if progress is not None:
            progress(min(steps, whole), whole)

    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        if len(times) == 1:
            stage = build_stage(recording, surfaces, frame, camera.at(frame))
            canvas = _Canvas.of(stage, camera.at(frame), width, height)
            _draw(canvas, pool, tick)
            _smooth_edges(canvas, pool, tick)
            return _pixels(canvas.colours, width, height)

        # Each time has its own place within the pixels, so edges are smooth, too.
        light = np.zeros((width * height, 3), np.float64)
        for index, time in enumerate(times):
            stage = build_stage(recording, surfaces, frame, camera.at(time), time)
            canvas = _Canvas.of(stage, camera.at(time), width, height, index, len(times))
            _draw(canvas, pool, tick)
            light += decoded(canvas.colours)
        return _pixels(encoded(light / len(times)), width, height)


def _is_still(
    surfaces: Surfaces, camera: Camera | MovingCamera, frame: int, earliest: float
) -> bool:
    """True if nothing moves between a time and a frame."""
    then, now = camera.at(earliest), camera.at(frame)
    if np.any(then.eye != now.eye) or np.any(then.axes != now.axes):
        return False
    living = (body for body in surfaces.bodies if body.alive(frame))
    return not any(moves_between(body, earliest, frame) for body in living)


def _bands(height: int) -> list[tuple[int, int]]:
    return [(top, min(top + BAND, height)) for top in range(0, height, BAND)]


def _draw(canvas: _Canvas, pool: ThreadPoolExecutor, tick: Callable[[int], None]) -> None:
    for part in (_see, _light_up):
        for _ in pool.map(lambda band, part=part: part(canvas, *band), _bands(canvas.height)):
            tick(1)


def _smooth_edges(canvas: _Canvas, pool: ThreadPoolExecutor, tick: Callable[[int], None]) -> None:
    edges = _edges(canvas)
    bands = len(_bands(canvas.height))
    chunks = np.array_split(edges, max(1, -(-len(edges) * len(PLACES) // CHUNK)))
    for index, _ in enumerate(pool.map(lambda chunk: _smooth(canvas, chunk), chunks)):
        tick(bands * (index + 1) // len(chunks) - bands * index // len(chunks))


def _pixels(colours: npt.NDArray[Any], width: int, height: int) -> npt.NDArray[np.uint8]:
    return np.round(255.0 * colours).astype(np.uint8).reshape(height, width, 3)


@dataclass(frozen=True, slots=True)
class _Canvas:
    """The picture, filled step by step; arrays are (h w, ...)."""

    stage: Stage
    camera: Camera
    width: int
    height: int
    #: A pixel's width at a depth of 1.
    pixel: float
    #: Light of glass on the way and of the backdrop, and the share of light that arrives from
    #: behind.
    front: Float32
    left: Float32
    #: The surface behind all glass: which, -1 for none, and where.
    key: Int32
    triangle: Int32
    points: Float32
    normals: Float32
    weights: Float32
    depth: Float32
    #: The light on it, as few rays say, and as neighbours say together.
    light: Float32
    shared: Float32
    #: sRGB, from 0 to 1.
    colours: Float32
    #: Where within a pixel rays pass, from 0 to 1, and how far the tile of rays is shifted.
    place: tuple[float, float]
    shift: int

    @staticmethod
    def of(
        stage: Stage, camera: Camera, width: int, height: int, sample: int = 0, samples: int = 1
    ) -> _Canvas:
        """A picture, or one of several samples of it."""

        def blank(*shape: int) -> Float32:
            return np.zeros((width * height, *shape), np.float32)

        whole = np.full(width * height, -1, np.int32)
        pixel = 2.0 * camera.half_height / height
        # Evenly across, and down by the golden ratio.
        place = ((sample + 0.5) / samples, (0.5 + sample * GOLDEN) % 1.0)
        return _Canvas(
            stage, camera, width, height, pixel, blank(3), blank(3), whole, whole.copy(),
            blank(3), blank(3), blank(2), blank(), blank(3), blank(3), blank(3),
            place, 7 * sample,
        )  # fmt: skip

    def rays(self, pixels: Int32, across: float, down: float) -> tuple[Float32, Float32]:
        """Origins and directions (n, 3) through places within pixels (n,), from 0 to 1."""
        x = (pixels % self.width).astype(np.float64) + across
        y = (pixels // self.width).astype(np.float64) + down
        directions = self.camera.rays(x, y, self.width, self.height).astype(np.float32)
        origin = (self.camera.eye - self.camera.target).astype(np.float32)
        return np.tile(origin, (len(directions), 1)), directions


@dataclass(frozen=True, slots=True)
class _Seen:
    """The surfaces that rays (n,) meet, through glass; arrays as in `_Canvas`, of the surface
    behind for hits."""

    front: Float32
    left: Float32
    #: Where rays end on a surface, with `rows` of these rays.
    behind: Hits
    #: (n,) from the eye.
    depth: Float32

    def keys(self, stage: Stage) -> Int32:
        triangle = self.behind.triangle
        keys: Int32 = stage.body[triangle] * 2 + stage.interior[triangle]
        return keys


def _follow(stage: Stage, origins: Float32, directions: Float32) -> _Seen:
    """Follow rays through glass until they end."""
    front = np.zeros(directions.shape, np.float32)
    left = np.ones(directions.shape, np.float32)
    depth = np.zeros(len(directions), np.float32)
    going = np.arange(len(directions), dtype=np.int32)
    ends: list[Hits] = []
    for layer in range(GLASS_LAYERS + 1):
        hits = trace(stage, origins, directions[going])
        is_met = np.zeros(len(going), np.bool_)
        is_met[hits.rows] = True
        free = going[~is_met]
        front[free] += left[free] * backdrop(directions[free])
        rows = going[hits.rows]
        depth[rows] += hits.depth
        clear = stage.clear[hits.triangle]
        is_end = (clear == 0.0) | (layer == GLASS_LAYERS)
        ends.append(_chosen(hits, is_end, rows))
        if is_end.all():
            break

        # Glass adds what it reflects and lets the rest through, tinted.
        past = _chosen(hits, ~is_end, rows)
        rows, share = past.rows, clear[~is_end, None]
        view = directions[rows]
        reflectance, gleam = glass(stage, past, view)
        lit = np.broadcast_to(ON_GLASS, past.points.shape)
        own = shade(stage, past, view, depth[rows], lit, 1e-3)
        front[rows] += left[rows] * (0.5 * (1.0 - share) * own + gleam)
        colour = stage.colours[past.triangle] ** (1.0 - share)
        left[rows] *= np.sqrt(share) * (1.0 - reflectance) * colour
        going = rows
        origins = past.points + np.float32(1e-5 * stage.distance) * view
    return _Seen(front, left, _joined(ends), depth)


def _chosen(hits: Hits, keep: npt.NDArray[np.bool_], rows: Int32) -> Hits:
    return Hits(
        rows[keep], hits.triangle[keep], hits.depth[keep], hits.points[keep],
        hits.normals[keep], hits.flat[keep], hits.weights[keep],
    )  # fmt: skip


def _joined(parts: list[Hits]) -> Hits:
    if len(parts) == 1:
        return parts[0]
    names = Hits.__slots__
    return Hits(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _see(canvas: _Canvas, top: int, bottom: int) -> None:
    """Find what the middles of a band's pixels show, and some of the light there."""
    stage, width = canvas.stage, canvas.width
    begin = top * width
    pixels = np.arange(begin, bottom * width, dtype=np.int32)
    seen = _follow(stage, *canvas.rays(pixels, *canvas.place))
    behind = seen.behind
    band = slice(begin, bottom * width)
    canvas.front[band], canvas.left[band], canvas.depth[band] = seen.front, seen.left, seen.depth
    at = begin + behind.rows
    points = where_lit(stage, behind)
    canvas.key[at], canvas.triangle[at] = seen.keys(stage), behind.triangle
    canvas.points[at], canvas.normals[at], canvas.weights[at] = (
        points,
        behind.normals,
        behind.weights,
    )
    slots = (TILES[at // width % TILE, at % width % TILE] + canvas.shift) % 16
    canvas.light[at] = gather_light(stage, points, behind.normals, slots, SKY_RAYS, LAMP_RAYS)


def _light_up(canvas: _Canvas, top: int, bottom: int) -> None:
    """Share the light among a band's pixels, and colour them."""
    width = canvas.width
    above, below = max(0, top - 2), min(canvas.height, bottom + 2)
    shape = (below - above, width)
    rows = slice(above * width, below * width)
    light, few = share_light(
        canvas.light[rows].reshape(*shape, 3),
        canvas.key[rows].reshape(shape),
        canvas.points[rows].reshape(*shape, 3),
        canvas.normals[rows].reshape(*shape, 3),
        canvas.depth[rows].reshape(shape) * np.float32(canvas.pixel),
    )
    inner = slice((top - above) * width, (bottom - above) * width)
    light, few = light.reshape(-1, 3)[inner], few.reshape(-1)[inner]
    shown = canvas.key[top * width : bottom * width] >= 0
    at = (top * width + np.flatnonzero(shown)).astype(np.int32)
    alone = (top * width + np.flatnonzero(few)).astype(np.int32)
    light[alone - top * width] = _ask_more(
        canvas, alone, canvas.points[alone], canvas.normals[alone]
    )
    radiance = canvas.front[top * width : bottom * width].copy()
    hits = Hits(
        at, canvas.triangle[at], canvas.depth[at], canvas.points[at],
        canvas.normals[at], canvas.normals[at], canvas.weights[at],
    )  # fmt: skip
    directions = canvas.rays(at, *canvas.place)[1]
    own = shade(canvas.stage, hits, directions, hits.depth, light[at - top * width], canvas.pixel)
    radiance[at - top * width] += canvas.left[at] * own
    canvas.colours[top * width : bottom * width] = tone(radiance)
    canvas.shared[top * width : bottom * width] = light


def _ask_more(canvas: _Canvas, pixels: Int32, points: Float32, normals: Float32) -> Float32:
    slots = (pixels.astype(np.int64) * 0x9E3779B1 >> 7) % 16
    return gather_light(canvas.stage, points, normals, slots, MORE_SKY_RAYS, MORE_LAMP_RAYS)


def _edges(canvas: _Canvas) -> Int32:
    """Indices of the pixels whose neighbours differ from them."""
    colours = canvas.colours.reshape(canvas.height, canvas.width, 3)
    differs = np.zeros((canvas.height, canvas.width), np.bool_)
    across = np.abs(np.diff(colours, axis=1)).max(axis=2) > CONTRAST
    down = np.abs(np.diff(colours, axis=0)).max(axis=2) > CONTRAST
    differs[:, 1:] |= across
    differs[:, :-1] |= across
    differs[1:] |= down
    differs[:-1] |= down
    return np.flatnonzero(differs).astype(np.int32)


def _smooth(canvas: _Canvas, pixels: Int32) -> None:
    """Sample pixels at more places, where light is known already if a neighbour shows the same."""
    total = canvas.colours[pixels].copy()
    for across, down in PLACES:
        origins, directions = canvas.rays(pixels, across, down)
        seen = _follow(canvas.stage, origins, directions)
        behind, radiance = seen.behind, seen.front
        at = behind.rows
        points, depth = where_lit(canvas.stage, behind), seen.depth[at]
        light = _known_light(
            canvas, pixels[at], seen.keys(canvas.stage), points, behind.normals, depth
        )
        own = shade(canvas.stage, behind, directions[at], depth, light, canvas.pixel)
        radiance[at] += seen.left[at] * own
        total += tone(radiance)
    canvas.colours[pixels] = total / (1 + len(PLACES))


def _known_light(
    canvas: _Canvas, pixels: Int32, keys: Int32, points: Float32, normals: Float32, depth: Float32
) -> Float32:
    """Light of the nearest pixel that shows the same surface, or of rays if none does."""
    light = np.zeros(points.shape, np.float32)
    missing = np.arange(len(pixels))
    steps = [(0, 0), (0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1)]
    for down, across in steps:
        x = np.clip(pixels[missing] % canvas.width + across, 0, canvas.width - 1)
        y = np.clip(pixels[missing] // canvas.width + down, 0, canvas.height - 1)
        there = y * canvas.width + x
        same = canvas.key[there] == keys[missing]
        same &= dot(canvas.normals[there], normals[missing]) > SAME_NORMAL
        apart = dot(canvas.points[there] - points[missing], normals[missing])
        same &= np.abs(apart) < SAME_PLANE * canvas.pixel * depth[missing]
        light[missing[same]] = canvas.shared[there[same]]
        missing = missing[~same]
        if not len(missing):
            return light
    light[missing] = _ask_more(canvas, pixels[missing], points[missing], normals[missing])
    return light
