"""What a page plays: a recording in a few megabytes, as streams of small whole numbers.

The blob is a header (length as little-endian uint32, then UTF-8 JSON), then the streams, zlib around all. A stream
holds whole numbers (rows, columns), column after column: differences of neighbours, taken ``order`` times, folded to
unsigned (0, -1, 1, -2, ...), the lowest byte of all rows first, then the next. `web/src/streams.ts` reads it.
"""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from .camera import FIELD_OF_VIEW_DEGREES, Camera
from .ground import is_half_space
from .materials import Material, Palette, look_of, tint
from .normals import ShadedMesh, shaded_mesh
from .paths import by_source
from .recording import Body, Float64, Recording
from .textures import longest_first

FORMAT = 1
#: Positions of bodies are multiples of what the camera sees, over this.
POSITION_STEPS = 2**17
#: Parts of a quaternion are multiples of one over this.
ORIENTATION_STEPS = 2**14 - 1
#: Corners lie on a lattice of so many steps along the longest side of their mesh.
CORNER_STEPS = 2**16 - 1
#: Normals lie on a lattice of so many steps on each side of the octahedron's square.
NORMAL_STEPS = 2**10 - 1
TINT_STEPS = 2**10

Ints = npt.NDArray[np.int64]


def encode(recording: Recording, camera: Camera) -> bytes:
    """The compressed blob; poses are those that the recording has, and pieces may be pulled apart."""
    distance = float(np.linalg.norm(camera.target - camera.eye))
    blob = _Blob()
    step = distance / POSITION_STEPS
    _add_bodies(blob, recording, step)
    materials = _add_meshes(blob, recording.bodies)
    _add_poses(blob, recording.bodies, step)
    return blob.to_bytes(
        {
            "format": FORMAT,
            "shot": recording.shot,
            "method": recording.method,
            "fps": recording.fps,
            "frames": recording.frames,
            "camera": {
                "eye": camera.eye.tolist(),
                "target": camera.target.tolist(),
                "fieldOfView": FIELD_OF_VIEW_DEGREES,
            },
            "materials": materials,
            "steps": {
                "position": step,
                "orientation": 1.0 / ORIENTATION_STEPS,
                "normal": 1.0 / NORMAL_STEPS,
                "tint": 1.0 / TINT_STEPS,
            },
        }
    )


class _Blob:
    """The streams, as they grow."""

    def __init__(self) -> None:
        self.streams: dict[str, dict[str, int]] = {}
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, name: str, values: npt.NDArray[Any], order: int = 1) -> None:
        """Whole numbers (rows,) or (rows, columns) that int32 holds."""
        columns = values.reshape(len(values), -1).T.astype(np.int64)
        # Differences may need a bit more than the numbers; they wrap around, and so do the reader's sums.
        for _ in range(order):
            columns = np.diff(columns, prepend=0, axis=1)
        wrapped = columns.astype(np.uint32).view(np.int32)
        folded = ((wrapped << 1) ^ (wrapped >> 31)).view(np.uint32).ravel()
        width = (int(folded.max(initial=0)).bit_length() + 7) // 8
        planes = np.ascontiguousarray(folded.astype("<u4").view(np.uint8).reshape(-1, 4).T[:width])
        self.streams[name] = {
            "offset": self.size,
            "rows": columns.shape[1],
            "columns": columns.shape[0],
            "bytes": width,
            "order": order,
        }
        self.parts.append(planes.tobytes())
        self.size += planes.size

    def to_bytes(self, header: dict[str, Any]) -> bytes:
        text = json.dumps({**header, "streams": self.streams}, separators=(",", ":")).encode()
        return zlib.compress(b"".join([len(text).to_bytes(4, "little"), text, *self.parts]), 9)


def _add_bodies(blob: _Blob, recording: Recording, step: float) -> None:
    bodies = recording.bodies
    blob.add("birth", np.array([body.birth_frame for body in bodies], np.int64))
    past = recording.frames + 1
    blob.add("end", np.array([past if body.death_frame is None else body.death_frame for body in bodies], np.int64))
    rows = {body.id: row for row, body in enumerate(bodies)}
    # A piece of a piece that no frame showed counts as its source's.
    parents = [-1 if body.parent is None else rows.get(body.parent, rows.get(body.source, -1)) for body in bodies]
    blob.add("parent", np.array(parents, np.int64))
    blob.add("floor", np.array([is_half_space(body) for body in bodies], np.int64))
    blob.add("pull", _rounded(_pulls(bodies, parents), step))
    tints = [tint(body, look_of(body)) for body in bodies]
    blob.add("tint", _rounded(np.array(tints).reshape(-1, 3), 1.0 / TINT_STEPS))
    grain = [_quaternion(longest_first(body.vertices)) if body.look == "wood" else (0, 0, 0, 1) for body in bodies]
    blob.add("grain", _rounded(np.array(grain).reshape(-1, 4), 1.0 / ORIENTATION_STEPS))


def _pulls(bodies: list[Body], parents: list[int]) -> Float64:
    """(b, 3) by how much each body moves when pieces are pulled apart to twice their distance, world frame [m].

    Away from the centre of all that broke off with it, so that the lowest of them keeps its height.
    """
    pulls = np.zeros((len(bodies), 3))
    siblings: dict[tuple[int, int], list[int]] = {}
    for row, (body, parent) in enumerate(zip(bodies, parents, strict=True)):
        if parent >= 0:
            siblings.setdefault((body.birth_frame, parent), []).append(row)
    for (_, parent), family in siblings.items():
        centres = np.array([bodies[row].positions[0] for row in family])
        weights = np.array([bodies[row].mass for row in family])
        middle = np.average(centres, axis=0, weights=weights if np.all(np.isfinite(weights)) else None)
        middle[1] = centres[:, 1].min()
        pulls[family] = centres - middle + pulls[parent]
    return pulls


def _add_meshes(blob: _Blob, bodies: list[Body]) -> list[dict[str, Any]]:
    """Each distinct surface once; the materials that the bodies' sides refer to."""
    materials: list[dict[str, Any]] = []

    def make(name: str, material: Material) -> int:
        materials.append(_material(name, material))
        return len(materials) - 1

    palette = Palette(by_source(bodies), make)
    slots = [palette.sides(body) for body in bodies]
    blob.add("slots", np.array([len(of_body) for of_body in slots], np.int64))
    blob.add("materials", np.array([material for of_body in slots for material in of_body], np.int64))

    # Equal surfaces are one.
    meshes: dict[bytes, int] = {}
    mesh_of_body, shaded = [], []
    for body in bodies:
        key = b"".join(array.tobytes() for array in (body.vertices, body.triangles, body.interior))
        if key not in meshes:
            meshes[key] = len(meshes)
            shaded.append((body, shaded_mesh(body.vertices, body.triangles, body.interior)))
        mesh_of_body.append(meshes[key])
    blob.add("mesh", np.array(mesh_of_body, np.int64))

    lows, scales, corners = [], [], []
    for body, _ in shaded:
        low, extent = _box(body)
        lows.append(low)
        scales.append(extent / CORNER_STEPS)
        corners.append(_rounded(body.vertices - low, max(extent, 1e-30) / CORNER_STEPS))
    blob.add("mesh_low", _bits(np.array(lows).reshape(-1, 3)))
    blob.add("mesh_scale", _bits(np.array(scales)))
    blob.add("mesh_corners", np.array([len(body.vertices) for body, _ in shaded], np.int64))
    blob.add("mesh_vertices", np.array([len(mesh.vertex) for _, mesh in shaded], np.int64))
    blob.add("mesh_triangles", np.array([len(mesh.triangles) for _, mesh in shaded], np.int64))
    blob.add("corners", _stacked(corners, 3))
    blob.add("vertices", _stacked([mesh.vertex for _, mesh in shaded], 1))
    blob.add("normals", _stacked([_octahedral(mesh.normals) for _, mesh in shaded], 2))
    blob.add("triangles", _stacked([mesh.triangles.ravel() for _, mesh in shaded], 1))
    blob.add("vertex_slots", _stacked([_slots(mesh, body) for body, mesh in shaded], 1))
    return materials


def _material(name: str, material: Material) -> dict[str, Any]:
    look = name.rpartition("_")[0]
    return {
        "name": name,
        "colour": list(material.colour),
        "metallic": material.metallic,
        "clear": material.clear,
        "grain": look if look in ("wood", "concrete") else "",
        "inside": name.endswith("_inside"),
    }


def _slots(mesh: ShadedMesh, body: Body) -> Ints:
    """(s,) which of the body's materials a vertex has; no vertex has two."""
    slots = np.zeros(len(mesh.vertex), np.int64)
    slots[mesh.triangles[body.interior]] = 1
    return slots


def _add_poses(blob: _Blob, bodies: list[Body], step: float) -> None:
    """Positions and orientations of each body's life, without what follows once it moves no more."""
    counts, positions, orientations = [], [], []
    for body in bodies:
        place = _rounded(body.positions, step)
        turn = _rounded(body.orientations, 1.0 / ORIENTATION_STEPS)
        moves = np.flatnonzero(np.any(np.diff(np.hstack([place, turn]), axis=0) != 0, axis=1))
        count = int(moves[-1]) + 2 if len(moves) else 1
        counts.append(count)
        positions.append(place[:count])
        orientations.append(turn[:count])
    blob.add("poses", np.array(counts, np.int64))
    blob.add("positions", _stacked(positions, 3), order=2)
    blob.add("orientations", _stacked(orientations, 4), order=2)


def _rounded(values: npt.NDArray[Any], step: float) -> Ints:
    rounded: Ints = np.clip(np.rint(values / step), -(2**31), 2**31 - 1).astype(np.int64)
    return rounded


def _stacked(parts: list[npt.NDArray[Any]], columns: int) -> Ints:
    return np.concatenate([np.zeros((0, columns)), *(part.reshape(-1, columns) for part in parts)]).astype(np.int64)


def _bits(values: npt.NDArray[Any]) -> Ints:
    """Single-precision numbers as the whole numbers with the same bits."""
    return values.astype(np.float32).view(np.int32).astype(np.int64)


def _box(body: Body) -> tuple[Float64, float]:
    """Lowest corner (3,) and longest side of a body's bounding box, body frame [m]."""
    if not len(body.vertices):
        return np.zeros(3), 0.0
    low = body.vertices.min(axis=0).astype(np.float64)
    return low, float(np.max(body.vertices.max(axis=0) - low))


def _octahedral(normals: npt.NDArray[Any]) -> Ints:
    """Unit normals (n, 3) as points (n, 2) of the unfolded octahedron (Cigolle et al. 2014)."""
    n = normals.astype(np.float64)
    n = n / np.maximum(np.abs(n).sum(axis=1, keepdims=True), 1e-30)
    folded = (1.0 - np.abs(n[:, 1::-1])) * np.where(n[:, :2] >= 0.0, 1.0, -1.0)
    return _rounded(np.where(n[:, 2:] >= 0.0, n[:, :2], folded), 1.0 / NORMAL_STEPS)


def _quaternion(rows: Float64) -> Float64:
    """The rotation (3, 3) whose rows are given, as a unit quaternion x, y, z, w; mirrored axes are turned back."""
    m = rows.copy()
    if np.linalg.det(m) < 0.0:
        m[2] = -m[2]
    # The eigenvector of the largest eigenvalue of Bar-Itzhack's matrix (2000).
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    quaternion: Float64 = np.linalg.eigh(k)[1][:, -1]
    return quaternion
