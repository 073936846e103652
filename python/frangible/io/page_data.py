"""The data of a page: a recording in a few megabytes, as streams of small whole numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from ..recording import Body, Float64, Recording, without_sign_flips
from ..render.camera import Camera
from ..render.ground import is_half_space
from ..render.palette import look_of, tint
from ..render.textures import longest_first
from .page_meshes import COLOUR_STEPS, COORDINATE_STEPS, NORMAL_STEPS, add_meshes
from .page_streams import Blob, Ints, rounded

#: Version of the streams and of the header, which `web/src/recording.ts` describes.
FORMAT = 2
#: Positions of bodies are multiples of the camera's distance over this.
POSITION_STEPS = 2**17
#: Parts of a quaternion are multiples of one over this, factors of colours too.
ORIENTATION_STEPS = 2**14 - 1
TINT_STEPS = 2**10


def encode(
    recording: Recording,
    camera: Camera,
    out: Callable[[bytes], object],
    folder: str | None = None,
) -> None:
    """Hand out the compressed blob, piece by piece, with the camera of the first view. ``folder``
    has room for it."""
    # The first view turns around what lies in the middle of the picture.
    distance = float((camera.target - camera.eye) @ camera.axes[2])
    target = camera.eye + distance * camera.axes[2]
    step = distance / POSITION_STEPS
    blob = Blob(folder)
    _add_bodies(blob, recording, step)
    appearance = add_meshes(blob, recording.bodies)
    _add_poses(blob, recording.bodies, step)
    blob.write(
        {
            "format": FORMAT,
            "shot": recording.shot,
            "fps": recording.fps,
            "frames": recording.frames,
            "camera": {
                "eye": camera.eye.tolist(),
                "target": target.tolist(),
                "fieldOfView": camera.fov,
            },
            **appearance,
            "steps": {
                "position": step,
                "orientation": 1.0 / ORIENTATION_STEPS,
                "normal": 1.0 / NORMAL_STEPS,
                "coordinate": 1.0 / COORDINATE_STEPS,
                "colour": 1.0 / COLOUR_STEPS,
                "tint": 1.0 / TINT_STEPS,
            },
        },
        out,
    )


def _add_bodies(blob: Blob, recording: Recording, step: float) -> None:
    bodies = recording.bodies
    blob.add("birth", np.array([body.birth_frame for body in bodies], np.int64))
    past = recording.frames + 1
    blob.add(
        "end",
        np.array(
            [past if body.death_frame is None else body.death_frame for body in bodies], np.int64
        ),
    )
    rows = {body.id: row for row, body in enumerate(bodies)}
    # A piece of a piece that no frame showed counts as its source's.
    parents = [
        -1 if body.parent is None else rows.get(body.parent, rows.get(body.source, -1))
        for body in bodies
    ]
    blob.add("parent", np.array(parents, np.int64))
    blob.add("lead", np.array([body.before is not None for body in bodies], np.int64))
    blob.add("yields", _yields(bodies))
    blob.add("floor", np.array([is_half_space(body) for body in bodies], np.int64))
    blob.add("pull", rounded(_pulls(bodies, parents), step))
    tints = [tint(body, look_of(body)) for body in bodies]
    blob.add("tint", rounded(np.array(tints).reshape(-1, 3), 1.0 / TINT_STEPS))
    grain = [
        _quaternion(longest_first(body.vertices.astype(np.float64)))
        if body.look == "wood"
        else (0, 0, 0, 1)
        for body in bodies
    ]
    blob.add("grain", rounded(np.array(grain).reshape(-1, 4), 1.0 / ORIENTATION_STEPS))


def _yields(bodies: list[Body]) -> npt.NDArray[np.int64]:
    """(b,) 1 where fragments are seen in a body's place on the way to the frame of its death."""
    shown = {body.id for body in bodies}
    breaks = {(body.birth_frame, body.parent) for body in bodies if body.before is not None}
    # No frame shows the parent of a fragment that broke twice on the way.
    breaks |= {
        (body.birth_frame, -1 - body.source)
        for body in bodies
        if body.before is not None and body.parent not in shown
    }
    yields = [
        (body.death_frame, body.id) in breaks or (body.death_frame, -1 - body.source) in breaks
        for body in bodies
    ]
    return np.array(yields, np.int64)


def _pulls(bodies: list[Body], parents: list[int]) -> Float64:
    """(b, 3) by how much each body moves when pieces are pulled apart to twice their distance,
    world frame [m].

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
        middle = np.average(
            centres, axis=0, weights=weights if np.all(np.isfinite(weights)) else None
        )
        middle[1] = centres[:, 1].min()
        pulls[family] = centres - middle + pulls[parent]
    return pulls


def _add_poses(blob: Blob, bodies: list[Body], step: float) -> None:
    """Positions and orientations of each body's life, without what follows once it moves no more.

    Those of a fragment begin where it was a frame before its birth.
    """
    counts = []
    for body in bodies:
        poses = np.hstack([_places(body, step), _turns(body)])
        moves = np.flatnonzero(np.any(np.diff(poses, axis=0) != 0, axis=1))
        counts.append(int(moves[-1]) + 2 if len(moves) else 1)
    blob.add("poses", np.array(counts, np.int64))

    def places() -> Iterator[Ints]:
        return (_places(body, step)[:count] for body, count in zip(bodies, counts, strict=True))

    def turns() -> Iterator[Ints]:
        return (_turns(body)[:count] for body, count in zip(bodies, counts, strict=True))

    blob.add_blocks("positions", 3, places, order=2)
    blob.add_blocks("orientations", 4, turns, order=2)


def _places(body: Body, step: float) -> Ints:
    places = body.positions
    if body.before is not None:
        places = np.vstack([body.before[:3], places])
    return rounded(places, step)


def _turns(body: Body) -> Ints:
    turns = body.orientations
    if body.before is not None:
        turns = without_sign_flips(np.vstack([body.before[3:], turns])[::-1])[::-1]
    return rounded(turns, 1.0 / ORIENTATION_STEPS)


def _quaternion(rows: Float64) -> Float64:
    """The rotation (3, 3) whose rows are given, as a unit quaternion x, y, z, w; mirrored axes are
    turned back."""
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
