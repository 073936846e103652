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
from .page_books import add_breaks, add_energy, gravity_of
from .page_meshes import COLOUR_STEPS, COORDINATE_STEPS, NORMAL_STEPS, Appearance
from .page_streams import Blob, Ints, bits, rounded

#: Version of the streams and of the header, which `web/src/reel.ts` reads.
FORMAT = 3
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
    """Hand out the compressed blob of a whole recording, piece by piece, with the camera of the
    first view. ``folder`` has room for it."""
    Reel(camera).chunk(recording, 0, out, is_last=True, folder=folder)


class Reel:
    """A recording in chunks, each a blob: what is known of a body goes into the first that shows
    it.

    Chunks share a frame: the first of one is the last of that before.
    """

    def __init__(self, camera: Camera) -> None:
        # The first view turns around what lies in the middle of the picture.
        distance = float((camera.target - camera.eye) @ camera.axes[2])
        self._eye, self._fov = camera.eye, camera.fov
        self._target = camera.eye + distance * camera.axes[2]
        self._step = distance / POSITION_STEPS
        self._rows: dict[int, int] = {}
        self._pulls: list[Float64] = []
        self._appearance = Appearance()
        self._breaks = 0

    def chunk(
        self,
        recording: Recording,
        first: int,
        out: Callable[[bytes], object],
        *,
        is_last: bool,
        folder: str | None = None,
    ) -> None:
        """Hand out, piece by piece, frames ``first`` to the last of a recording that holds no
        others, but for reports of frame ``first``; ``is_last`` if no more will come. ``folder``
        has room for it."""
        bodies = recording.bodies
        new = [body for body in bodies if body.id not in self._rows]
        for body in new:
            self._rows[body.id] = len(self._rows)
        blob = Blob(folder)
        self._add_new(blob, new)
        appearance = self._appearance.add(blob, new)
        self._add_paths(blob, recording)
        add_energy(blob, recording.reports)
        self._breaks = add_breaks(blob, recording.reports, self._rows, new, self._breaks)
        blob.write(
            {
                "format": FORMAT,
                "shot": recording.shot,
                "fps": recording.fps,
                "first": first,
                "frames": recording.frames,
                "isLast": is_last,
                "camera": {
                    "eye": self._eye.tolist(),
                    "target": self._target.tolist(),
                    "fieldOfView": self._fov,
                },
                "gravity": gravity_of(recording),
                "names": [body.name for body in new],
                **appearance,
                "steps": {
                    "position": self._step,
                    "orientation": 1.0 / ORIENTATION_STEPS,
                    "normal": 1.0 / NORMAL_STEPS,
                    "coordinate": 1.0 / COORDINATE_STEPS,
                    "colour": 1.0 / COLOUR_STEPS,
                    "tint": 1.0 / TINT_STEPS,
                },
            },
            out,
        )

    def _add_new(self, blob: Blob, bodies: list[Body]) -> None:
        """What does not change of bodies that no chunk before showed."""
        # A piece of a piece that no frame showed counts as its source's.
        parents = [
            -1
            if body.parent is None
            else self._rows.get(body.parent, self._rows.get(body.source, -1))
            for body in bodies
        ]
        # Ids have 64 bits: a number, and how often it was given before.
        ids = np.array([body.id for body in bodies], np.uint64).view(np.int32).reshape(-1, 2)
        blob.add("id", ids)
        blob.add("parent", np.array(parents, np.int64))
        blob.add("floor", np.array([is_half_space(body) for body in bodies], np.int64))
        blob.add("mass", bits(np.array([body.mass for body in bodies])))
        pulls = _pulls(bodies, parents, self._pulls)
        self._pulls.extend(pulls)
        blob.add("pull", rounded(pulls, self._step))
        tints = [tint(body, look_of(body)) for body in bodies]
        blob.add("tint", rounded(np.array(tints).reshape(-1, 3), 1.0 / TINT_STEPS))
        grain = [
            _quaternion(longest_first(body.vertices.astype(np.float64)))
            if body.look == "wood"
            else (0, 0, 0, 1)
            for body in bodies
        ]
        blob.add("grain", rounded(np.array(grain).reshape(-1, 4), 1.0 / ORIENTATION_STEPS))

    def _add_paths(self, blob: Blob, recording: Recording) -> None:
        """The life of each body within the chunk, and where it is."""
        bodies = recording.bodies
        past = recording.frames + 1
        deaths = [past if body.death_frame is None else body.death_frame for body in bodies]
        blob.add("row", np.array([self._rows[body.id] for body in bodies], np.int64))
        blob.add("birth", np.array([body.birth_frame for body in bodies], np.int64))
        blob.add("end", np.array(deaths, np.int64))
        blob.add("lead", np.array([body.before is not None for body in bodies], np.int64))
        blob.add("yields", _yields(bodies))
        _add_poses(blob, bodies, self._step)


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


def _pulls(bodies: list[Body], parents: list[int], known: list[Float64]) -> Float64:
    """(b, 3) by how much each body moves when pieces are pulled apart to twice their distance,
    world frame [m].

    Away from the centre of all that broke off with it, so that the lowest of them keeps its height.
    ``parents`` are rows, of which those of the bodies follow the ones that are ``known``.
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
        own = known[parent] if parent < len(known) else pulls[parent - len(known)]
        pulls[family] = centres - middle + own
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
