"""The scene of a picture: the surfaces of a recording, and where they are at a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from ..materials import LOOKS
from ..names import by_source
from ..recording import Body, Bool, Float32, Float64, Recording, rotation_matrix
from .camera import Camera
from .ground import is_half_space
from .images import Pictures
from .normals import smooth_normals
from .palette import plain, source_colours, tint
from .shutter import pose_between
from .textures import longest_first

Int32 = npt.NDArray[np.int32]

#: Towards the lamp, over the right shoulder of the camera (right, up, back).
LAMP = np.array([0.70, 1.15, 0.65]) / np.linalg.norm([0.70, 1.15, 0.65])
FLOOR_COLOUR = np.array([0.25, 0.26, 0.28], np.float32)
#: How far from a surface rays begin, over the distance of the camera, and over how far the surface
#: reaches: single precision places what is hit no better.
LIFT_OF_DISTANCE, LIFT_OF_REACH = 2e-5, 4e-6
#: Normals of about so many triangles are made at once.
BATCH = 60_000


@dataclass(frozen=True, slots=True)
class Surfaces:
    """Of all bodies of a recording that some frames show: what does not change between frames."""

    bodies: list[Body]
    #: (b + 1,) first triangle of each body, then their number.
    first: npt.NDArray[np.int64]
    #: (t, 3, 3) corners, and unit normals at them, body frame.
    corners: Float32
    normals: Float32
    #: (t, 3) linear RGB.
    colours: Float32
    #: (t, 2) share of light that passes, and that is mirrored as from metal.
    shares: Float32
    #: (t,) whether a crack made the triangle.
    interior: Bool
    #: (b, 3, 3) axes of each body, body frame, the longest first; none for looks without a grain.
    axes: Float64
    #: Images on them.
    pictures: Pictures

    def edge(self, triangle: Int32) -> Float32:
        """(n,) longest edges of triangles [m]."""
        corners = self.corners[triangle]
        sides = corners - np.roll(corners, 1, axis=1)
        edges: Float32 = np.sqrt(np.einsum("nij,nij->ni", sides, sides).max(axis=1))
        return np.maximum(edges, 1e-30)


def gather_surfaces(recording: Recording, frame: int | None = None) -> Surfaces:
    """The surfaces that a frame shows, or any frame."""
    palette = source_colours(by_source(recording.bodies))
    alive = recording.bodies if frame is None else recording.alive(frame)
    bodies = [body for body in alive if len(body.triangles)]
    corners, colours, shares = (
        [np.zeros((0, *shape), np.float32)] for shape in ((3, 3), (3,), (2,))
    )
    for body in bodies:
        look = plain(palette[body.source]) if body.look is None else LOOKS[body.look]
        sides = (look.outside, look.inside)
        inside = body.interior.astype(np.int64)
        corners.append(body.vertices[body.triangles].astype(np.float32))
        shade = np.array([tint(body, look) * np.array(side.colour) for side in sides], np.float32)
        colours.append(shade[inside])
        shares.append(np.array([[side.clear, side.metallic] for side in sides], np.float32)[inside])
    grained = ("wood", "concrete")
    axes = [
        longest_first(body.vertices.astype(np.float64)) if body.look in grained else np.eye(3)
        for body in bodies
    ]
    interior = [np.zeros(0, np.bool_), *(body.interior for body in bodies)]
    surfaces = Surfaces(
        bodies=bodies,
        first=np.cumsum([0, *(len(body.triangles) for body in bodies)]),
        corners=np.concatenate(corners),
        normals=_normals(bodies),
        colours=np.concatenate(colours),
        shares=np.concatenate(shares),
        interior=np.concatenate(interior),
        axes=np.array(axes).reshape(-1, 3, 3),
        pictures=Pictures.of(bodies),
    )
    surfaces.pictures.colour(surfaces.colours, surfaces.shares)
    return surfaces


def _normals(bodies: list[Body]) -> Float32:
    """(t, 3, 3) normals at the corners of all triangles, body frame; many small bodies at once."""
    made = [np.zeros((0, 3, 3), np.float32)]
    batch: list[Body] = []
    for index, body in enumerate(bodies):
        batch.append(body)
        if sum(len(one.triangles) for one in batch) < BATCH and index + 1 < len(bodies):
            continue
        starts = np.cumsum([0, *(len(one.vertices) for one in batch)])[:-1]
        triangles = np.concatenate(
            [one.triangles + np.uint32(start) for one, start in zip(batch, starts, strict=True)]
        )
        vertices = np.concatenate([one.vertices for one in batch])
        interior = np.concatenate([one.interior for one in batch])
        smooth = smooth_normals(vertices, triangles, interior).reshape(-1, 3, 3).astype(np.float32)
        made.append(smooth)
        batch = []
    normals = np.concatenate(made)
    first = 0
    for body in bodies:
        rows = slice(first, first + len(body.triangles))
        first = rows.stop
        if body.skin is not None and body.skin.normals is not None:
            own = body.skin.normals
            normals[rows] = np.where(np.any(own != 0.0, axis=2, keepdims=True), own, normals[rows])
    return normals


@dataclass(frozen=True, slots=True)
class Plane:
    """The surface of a half-space."""

    #: (3,) unit.
    normal: Float32
    #: Of its points along the normal, relative to the camera's target [m].
    height: np.float32


@dataclass(frozen=True, slots=True)
class Stage:
    """All triangles of a frame in the world frame, relative to the camera's target, then the
    planes."""

    surfaces: Surfaces
    #: Ray tracers of everything, of what casts shadows, and of glass, which hardly does.
    scene: Any
    solid: Any
    glass: Any | None
    planes: list[Plane]
    #: (s,) the triangle of `surfaces` that each one shown is.
    shown: Int32
    #: (s + planes, 3, 3) unit normals at the corners.
    normals: Float32
    #: (s + planes, ...) as in `surfaces`.
    colours: Float32
    clear: Float32
    metallic: Float32
    interior: Bool
    #: (s + planes,) index of the body; planes come last.
    body: Int32
    #: (s + planes,) how far from it rays begin [m].
    lift: Float32
    #: (b, 3) and (b, 3, 3), centres relative to the target [m] and axes of the bodies.
    centres: Float64
    axes: Float64
    #: Distance from the camera to its target, the scale of everything else [m].
    distance: float
    #: (3,) unit vector towards the lamp.
    lamp: Float32
    #: (b,) of each look that has a texture, which bodies have it.
    looks: dict[str, Bool]
    #: Width of the floor's squares, and where they begin from the target (2,) [m].
    spacing: float
    grid_offset: Float32

    @property
    def first_plane(self) -> int:
        """Index of the first plane among the triangles."""
        return len(self.shown)


def build_stage(
    recording: Recording,
    surfaces: Surfaces,
    frame: int,
    camera: Camera,
    time: float | None = None,
) -> Stage:
    """Where everything is that a frame shows: then, or at another time up to a frame before
    [frames]."""
    lit_by = camera.first or camera
    distance = float(np.linalg.norm(lit_by.target - lit_by.eye))
    spacing = float(10.0 ** max(np.ceil(np.log10(distance / 30.0)), -6.0))
    living = [i for i, body in enumerate(surfaces.bodies) if body.alive(frame)]
    first = surfaces.first
    counts = np.array([first[i + 1] - first[i] for i in living], np.int64)
    shown = np.concatenate(
        [np.zeros(0, np.int64), *(np.arange(first[i], first[i + 1]) for i in living)]
    )
    bodies = [surfaces.bodies[i] for i in living]
    centres, rotations = _places(bodies, frame if time is None else time, camera)

    # Place every triangle.
    body = np.repeat(np.arange(len(bodies)), counts)
    turns = rotations.astype(np.float32).swapaxes(1, 2)[body]
    soup = np.matmul(surfaces.corners[shown], turns) + centres.astype(np.float32)[body][:, None]
    normals = np.matmul(surfaces.normals[shown], turns)
    reach = np.abs(soup).max(axis=(1, 2)) if len(soup) else np.zeros(0, np.float32)
    lift = np.concatenate([reach * LIFT_OF_REACH, np.zeros(0)]) + LIFT_OF_DISTANCE * distance

    planes, ups = _planes(recording, frame, camera)
    more = len(planes)
    shares = surfaces.shares[shown]
    clear = np.concatenate([shares[:, 0], np.zeros(more, np.float32)])
    is_clear = shares[:, 0] > 0.0
    scene = _scene(soup)
    return Stage(
        surfaces=surfaces,
        scene=scene,
        solid=_scene(soup[~is_clear]) if is_clear.any() else scene,
        glass=_scene(soup[is_clear]) if is_clear.any() else None,
        planes=planes,
        shown=shown.astype(np.int32),
        normals=np.concatenate([normals, np.repeat(ups[:, None], 3, axis=1)]).astype(np.float32),
        colours=np.concatenate([surfaces.colours[shown], np.tile(FLOOR_COLOUR, (more, 1))]),
        clear=clear,
        metallic=np.concatenate([shares[:, 1], np.zeros(more, np.float32)]),
        interior=np.concatenate([surfaces.interior[shown], np.zeros(more, np.bool_)]),
        body=np.concatenate([body, len(bodies) + np.arange(more)]).astype(np.int32),
        lift=np.concatenate([lift, np.full(more, LIFT_OF_DISTANCE * distance)]).astype(np.float32),
        centres=np.concatenate([centres, np.zeros((more, 3))]),
        axes=np.concatenate(
            [surfaces.axes[living] @ rotations.swapaxes(1, 2), np.tile(np.eye(3), (more, 1, 1))]
        ),
        distance=distance,
        lamp=lamp_direction(lit_by),
        looks=_grains(bodies, more),
        spacing=spacing,
        grid_offset=np.mod(camera.target[[0, 2]], spacing).astype(np.float32),
    )


def _places(bodies: list[Body], time: float, camera: Camera) -> tuple[Float64, Float64]:
    """(b, 3) centres relative to the camera's target [m] and (b, 3, 3) rotations at a time
    [frames]."""
    poses = [pose_between(body, time) for body in bodies]
    centres = np.array([position for position, _ in poses]).reshape(-1, 3) - camera.target
    rotations = np.array([rotation_matrix(turn) for _, turn in poses]).reshape(-1, 3, 3)
    return centres, rotations


def _planes(recording: Recording, frame: int, camera: Camera) -> tuple[list[Plane], Float64]:
    """Half-spaces as planes without an edge, and (p, 3) their normals in double precision."""
    planes, ups = [], []
    for half_space in (one for one in recording.alive(frame) if is_half_space(one)):
        position, orientation = half_space.pose(frame)
        up = rotation_matrix(orientation)[:, 1]
        ups.append(up)
        planes.append(Plane(up.astype(np.float32), np.float32((position - camera.target) @ up)))
    return planes, np.array(ups, np.float64).reshape(-1, 3)


def _grains(bodies: list[Body], planes: int) -> dict[str, Bool]:
    """(b + planes,) of each look that has a texture, which bodies have it."""
    return {
        look: np.array([one.look == look for one in bodies] + [False] * planes, np.bool_)
        for look in ("wood", "concrete")
    }


def _scene(soup: Float32) -> Any:
    """Triangles (t, 3, 3), relative to the camera's target."""
    scene = EmbreeScene(robust=True)
    if len(soup):
        TriangleMesh(scene, np.ascontiguousarray(soup, np.float32))
    return scene


def lamp_direction(camera: Camera) -> Float32:
    """(3,) unit, towards the lamp, which keeps its place beside the camera."""
    right = np.cross(camera.axes[2], [0.0, 1.0, 0.0])
    length = np.linalg.norm(right)
    right = right / length if length > 1e-6 else camera.axes[0]
    towards: Float64 = LAMP @ np.array([right, [0.0, 1.0, 0.0], np.cross(right, [0.0, 1.0, 0.0])])
    return (towards / np.linalg.norm(towards)).astype(np.float32)
