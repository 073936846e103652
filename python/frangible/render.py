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

from .camera import Camera, frame_recording
from .ground import is_half_space, patch
from .materials import LOOKS, Look, plain, source_colours
from .normals import shaded_mesh
from .paths import by_source
from .recording import Body, Bool, Float64, Recording, rotation_matrix
from .textures import concrete, longest_first, wood

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

#: Surfaces of glass that a ray passes, one behind the other; what lies behind more is not seen.
GLASS_LAYERS = 12
#: What glass reflects face on, from both of its sides.
GLASS_REFLECTANCE = 0.045
#: How much of the lamp's light glass lets through.
GLASS_SHADOW = 0.78

# Steps of the two-dimensional golden-ratio sequence, which fills a square evenly (M. Roberts, 2018).
_R2 = np.array([0.7548776662466927, 0.5698402909980532])


def write_png(recording: Recording, path: str, frame: int) -> None:
    """Write a picture of a frame."""
    Image.fromarray(picture(recording, frame)).save(path, format="PNG")


def picture(
    recording: Recording, frame: int, width: int = WIDTH, height: int = HEIGHT, camera: Camera | None = None
) -> npt.NDArray[np.uint8]:
    """A picture of a frame, (height, width, 3), sRGB."""
    camera = camera or frame_recording(recording, width / height)
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
    #: What casts shadows, and the glass, which hardly does; `None` without any.
    solid: Any
    glass: Any | None
    #: (t, 3, 3) unit normals at the corners.
    corner_normals: Float64
    #: (t, 3) linear RGB.
    colours: Float64
    #: (t,) share of light that passes, and that is mirrored as from metal.
    clear: Float64
    metallic: Float64
    #: (t,) whether a crack made the triangle.
    interior: Bool
    #: (t,) index of the body; its look, centre (b, 3) and axes (b, 3, 3), the longest first.
    body: npt.NDArray[np.int64]
    looks: list[str | None]
    centres: Float64
    axes: Float64
    #: Index of the first triangle of half-spaces, which come last.
    first_floor: int
    #: Distance from the camera to the subject, and the scale of everything else [m].
    distance: float
    #: Unit vector towards the lamp.
    lamp: Float64


def _build_stage(recording: Recording, frame: int, camera: Camera) -> _Stage:
    palette = source_colours(by_source(recording.bodies))
    distance = float(np.linalg.norm(camera.target - camera.eye))
    alive = recording.alive(frame)
    drawn = [body for body in alive if len(body.triangles)]

    # Place and colour every living body, except what the whole scene rests on.
    corners, normals, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    shares = [np.zeros((0, 2))]
    for body in drawn:
        shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
        turned = shaded.normals @ rotation_matrix(body.pose(frame)[1]).T
        corners.append(body.vertices_world(frame)[body.triangles])
        normals.append(turned[shaded.triangles])
        look = plain(palette[body.source]) if body.look is None else LOOKS[body.look]
        outside, inside = (_tint(body, look, np.array(side.colour)) for side in (look.outside, look.inside))
        colours.append(np.where(body.interior[:, None], inside, outside))
        sides = np.array([[side.clear, side.metallic] for side in (look.outside, look.inside)])
        shares.append(sides[body.interior.astype(np.int64)])

    # A half-space is two triangles that reach beyond the haze.
    first_floor = sum(map(len, corners))
    floors = [body for body in alive if is_half_space(body)]
    for body in floors:
        position, orientation = body.pose(frame)
        rotation = rotation_matrix(orientation)
        quad = patch(body, camera.target, 2e3 * distance) @ rotation.T + position
        corners.append(quad[[[0, 1, 2], [0, 2, 3]]])
        normals.append(np.broadcast_to(rotation[:, 1], (2, 3, 3)))
        colours.append(np.broadcast_to(FLOOR_COLOUR, (2, 3)))
        shares.append(np.zeros((2, 2)))
    soup = np.concatenate(corners) - camera.target
    clear, metallic = np.concatenate(shares).T
    shown = [*drawn, *floors]
    counts = [len(body.triangles) for body in drawn] + [2] * len(floors)
    return _Stage(
        scene=_scene(soup),
        solid=_scene(soup[clear == 0.0]),
        glass=_scene(soup[clear > 0.0]) if clear.any() else None,
        corner_normals=np.concatenate(normals),
        colours=np.concatenate(colours),
        clear=clear,
        metallic=metallic,
        interior=np.concatenate([np.zeros(0, np.bool_), *(body.interior for body in drawn), np.zeros(2 * len(floors), np.bool_)]),
        body=np.repeat(np.arange(len(shown)), counts),
        looks=[body.look if len(body.triangles) else None for body in shown],
        centres=np.array([body.pose(frame)[0] for body in shown]).reshape(-1, 3),
        axes=np.array([_axes(body, frame) for body in shown]).reshape(-1, 3, 3),
        first_floor=first_floor,
        distance=distance,
        lamp=_lamp(camera),
    )


def _scene(soup: Float64) -> Any:
    """Triangles (t, 3, 3), relative to the camera's target."""
    scene = EmbreeScene(robust=True)
    if len(soup):
        TriangleMesh(scene, np.ascontiguousarray(soup, np.float32))
    return scene


def _lamp(camera: Camera) -> Float64:
    """The lamp keeps its place beside the camera."""
    right = camera.axes[0]
    lamp: Float64 = LAMP @ np.array([right, [0.0, 1.0, 0.0], np.cross(right, [0.0, 1.0, 0.0])])
    return lamp


def _axes(body: Body, frame: int) -> Float64:
    axes: Float64 = longest_first(body.vertices.astype(np.float64)) @ rotation_matrix(body.pose(frame)[1]).T
    return axes


def _tint(body: Body, look: Look, colour: Float64) -> Float64:
    """Pieces differ by a touch of brightness and warmth, so that they can be told apart."""
    if body.parent is None:
        return colour
    brightness, warmth = (body.id * _R2) % 1.0
    shade = 1.0 + look.variation * (brightness - 0.53)
    tinted: Float64 = colour * shade * (1.0 + 0.3 * look.variation * (warmth - 0.5) * np.array([1.0, 0.0, -1.2]))
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
    # The stage is centred on the camera's target.
    light = np.zeros(directions.shape)
    left = np.ones(directions.shape)
    origins = np.broadcast_to(camera.eye - camera.target, directions.shape).copy()
    travelled = np.zeros(len(directions))
    going = np.arange(len(directions))
    for layer in range(GLASS_LAYERS + 1):
        hits = _hits(stage.scene, origins[going], directions[going])
        met = hits["primID"] >= 0
        light[going[~met]] += left[going[~met]] * _backdrop(directions[going[~met]])
        if not met.any():
            break
        rows = going[met]
        surface = _surface(stage, camera, {key: hits[key][met] for key in hits}, origins[rows], directions[rows])
        travelled[rows] += surface.depth
        colour = _shade(stage, camera, surface, directions[rows], travelled[rows], offsets[rows], sample)

        # Glass adds what it reflects and lets the rest through, tinted.
        clear = stage.clear[surface.triangle, None] * (layer < GLASS_LAYERS)
        reflectance, gleam = _glass(stage, surface, directions[rows])
        own = np.where(clear > 0.0, 0.5 * (1.0 - clear) * colour + gleam, colour)
        light[rows] += left[rows] * own
        tint = stage.colours[surface.triangle] ** (1.0 - clear)
        left[rows] *= np.where(clear > 0.0, clear**0.5 * (1.0 - reflectance) * tint, 0.0)
        going = rows[clear[:, 0] > 0.0]
        if not len(going):
            break
        origins[rows] = surface.points + 1e-5 * stage.distance * directions[rows]
    return light


@dataclass(frozen=True, slots=True)
class _Surface:
    """Where rays met the stage."""

    triangle: npt.NDArray[np.int64]
    #: (n,) from the ray's origin [m].
    depth: Float64
    #: (n, 3) relative to the camera's target [m].
    points: Float64
    #: (n, 3) unit, on the eye's side: smooth, and of the triangle itself.
    normals: Float64
    flat: Float64


def _surface(stage: _Stage, camera: Camera, hits: dict[str, npt.NDArray[Any]], origins: Float64, view: Float64) -> _Surface:
    triangle, depth = hits["primID"].astype(np.int64), hits["tfar"].astype(np.float64)
    u, v = hits["u"][:, None].astype(np.float64), hits["v"][:, None].astype(np.float64)
    n0, n1, n2 = stage.corner_normals[triangle].swapaxes(0, 1)
    normals = _unit((1.0 - u - v) * n0 + u * n1 + v * n2)
    flat = _unit(hits["Ng"].astype(np.float64))
    flat *= np.where(np.sum(flat * view, axis=1, keepdims=True) > 0.0, -1.0, 1.0)
    normals *= np.where(np.sum(flat * normals, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    return _Surface(triangle, depth, origins + depth[:, None] * view, normals, flat)


def _shade(
    stage: _Stage, camera: Camera, at: _Surface, view: Float64, depth: Float64, offsets: Float64, sample: int
) -> Float64:
    """Light (n, 3) that a surface sends back, seen from a depth (n,)."""
    # Light from the lamp and from the sky, and a faint sheen.
    lifted = at.points + 2e-5 * stage.distance * at.flat
    lamp = _lamp_light(stage, lifted, offsets[:, :2], sample)
    sky = _sky_light(stage, lifted, at.normals, offsets[:, 2:], sample)
    albedo = _albedo(stage, camera, at)
    on_floor = at.triangle >= stage.first_floor
    albedo = np.where(on_floor[:, None], albedo * _grid_lines(stage, at.points + camera.target, depth)[:, None], albedo)
    metallic = stage.metallic[at.triangle, None]
    gloss = np.maximum(np.sum(at.normals * _unit(stage.lamp - view), axis=1, keepdims=True), 0.0)
    sheen = 0.14 * gloss**48 * (1.0 - metallic) + 0.9 * gloss**140 * metallic
    facing = np.maximum(at.normals @ stage.lamp, 0.0)[:, None]
    mirrored = albedo * _backdrop(_reflected(view, at.normals)) * metallic
    lit = albedo * (lamp * facing + sky) * (1.0 - 0.6 * metallic) + mirrored
    lit = lit + np.where(on_floor[:, None], 0.0, sheen) * lamp * (facing > 0.0)

    # The floor dissolves into the haze.
    haze = np.where(on_floor, 1.0 - np.exp(-((depth / (5.0 * stage.distance)) ** 2)), 0.0)[:, None]
    shaded: Float64 = lit * (1.0 - haze) + HAZE_COLOUR * haze
    return shaded


def _albedo(stage: _Stage, camera: Camera, at: _Surface) -> Float64:
    """Colours (n, 3) of surfaces, with what their look shows on them."""
    albedo: Float64 = stage.colours[at.triangle]
    body = stage.body[at.triangle]
    for look in ("wood", "concrete"):
        rows = np.flatnonzero(np.array([one == look for one in stage.looks], np.bool_)[body])
        if not len(rows):
            continue
        offsets = at.points[rows] + camera.target - stage.centres[body[rows]]
        points = np.einsum("nij,nj->ni", stage.axes[body[rows]], offsets)
        albedo[rows] *= wood(points) if look == "wood" else concrete(points, stage.interior[at.triangle[rows]])
    return albedo


def _glass(stage: _Stage, at: _Surface, view: Float64) -> tuple[Float64, Float64]:
    """What share a surface of glass reflects (n, 1), and the light that it does reflect (n, 3), by Schlick's formula."""
    cosine = np.clip(-np.sum(at.normals * view, axis=1, keepdims=True), 0.0, 1.0)
    reflectance: Float64 = GLASS_REFLECTANCE + (1.0 - GLASS_REFLECTANCE) * (1.0 - cosine) ** 5
    mirror = _reflected(view, at.normals)
    sparkle = 6.0 * np.maximum(mirror @ stage.lamp, 0.0)[:, None] ** 700 * LAMP_COLOUR
    sky = np.where(mirror[:, 1:2] > 0.0, 1.7 * _backdrop(mirror), FLOOR_COLOUR)
    return reflectance, reflectance * sky + sparkle


def _reflected(view: Float64, normals: Float64) -> Float64:
    mirrored: Float64 = view - 2.0 * np.sum(view * normals, axis=1, keepdims=True) * normals
    return mirrored


def _lamp_light(stage: _Stage, points: Float64, offsets: Float64, sample: int) -> Float64:
    """Light of the lamp (n, 3) that gets past everything in between, before the cosine."""
    across, along = _tangents(stage.lamp[None])
    visible = np.zeros(len(points))
    for ray in range(LAMP_RAYS):
        x = (offsets + (sample * LAMP_RAYS + ray) * _R2) % 1.0
        radius, angle = LAMP_RADIUS * np.sqrt(x[:, :1]), 2.0 * np.pi * x[:, 1:]
        towards = _unit(stage.lamp + radius * (np.cos(angle) * across + np.sin(angle) * along))
        visible += _openness(stage, points, towards)
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
        free = _openness(stage, points, towards)[:, None] * (0.35 + 0.65 * np.clip(towards[:, 1:2] + 0.4, 0.0, 1.0))
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


def _openness(stage: _Stage, points: Float64, towards: Float64) -> Float64:
    """What share of the light (n,) from a direction arrives."""
    share = _is_open(stage.solid, points, towards).astype(np.float64)
    if stage.glass is not None:
        share *= np.where(_is_open(stage.glass, points, towards), 1.0, GLASS_SHADOW)
    return share


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
