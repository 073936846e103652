"""Where pictures are taken from: one camera for a whole recording, fitted to it or from a file."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..recording import Float64, Recording, rotation_matrix
from ..stage_camera import StageCamera
from .fit import best_place
from .framing import Subject, find_subject
from .sight import Moment, find_moments

#: Vertical opening of the lens [degrees]: a short telephoto, which keeps uprights upright.
FIELD_OF_VIEW_DEGREES = 28.0
#: From the subject to the camera: in front, a little to the left (right, front), and a little above
#: or, into pits that hide at least so much of it, from high above.
VIEW_FROM = np.array([-0.62, 1.0])
HEIGHTS = (0.40, 2.0)
PIT = 0.5
#: A subject this much thinner in one horizontal direction than in the other has a front.
THIN = 0.8
#: Factor on the subject's extent in the picture.
MARGIN = 1.08
#: The first side is taken from which what happens is at least so large as from the best one.
ALIKE = 0.84
#: The choice of the camera of the stage that a scene came from.
STAGE = "stage"
#: A file about a camera that is larger than this holds something else [bytes].
LARGEST_FILE = 1 << 16


class CameraError(ValueError):
    """A camera that cannot look at anything, in one sentence."""


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera in the world frame."""

    #: (3,) [m].
    eye: Float64
    #: (3, 3) rows are right, up and forward.
    axes: Float64
    #: Half of the picture's height at distance 1.
    half_height: float
    #: (3,) middle of what it looks at [m].
    target: Float64
    #: Of a camera that moves, the one at its first frame: lamp and haze are placed by it.
    first: Camera | None = None

    def at(self, time: float) -> Camera:
        """Of a time [frames]: it stands still."""
        return self

    @staticmethod
    def look_at(
        eye: Sequence[float],
        target: Sequence[float],
        up: Sequence[float] = (0.0, 1.0, 0.0),
        fov: float = FIELD_OF_VIEW_DEGREES,
    ) -> Camera:
        """A camera at a place [m] that looks at another, with a vertical opening [degrees].

        `CameraError` if the three do not span a picture.
        """
        place, middle, above = (np.array(vector, np.float64) for vector in (eye, target, up))
        distance = float(np.linalg.norm(middle - place))
        if distance == 0.0:
            raise CameraError(f"eye: {list(eye)}, must differ from target")
        forward = (middle - place) / distance
        right = np.cross(forward, above)
        width = float(np.linalg.norm(right))
        if width <= 1e-9 * float(np.linalg.norm(above)):
            rule = "must not be 0, nor point along the way the camera looks"
            raise CameraError(f"up: {list(up)}, {rule}")
        if not 0.0 < fov < 180.0:
            raise CameraError(f"fov: {fov:g}, must be > 0 and < 180 degrees")
        axes = np.array([right / width, np.cross(right / width, forward), forward])
        return Camera(place, axes, float(np.tan(np.radians(fov / 2))), middle)

    @property
    def fov(self) -> float:
        """Vertical opening [degrees]."""
        return float(np.degrees(2.0 * np.arctan(self.half_height)))

    def rays(self, x: Float64, y: Float64, width: int, height: int) -> Float64:
        """Unit directions (n, 3) through the pixel coordinates x, y (n,), with y down."""
        scale = 2.0 * self.half_height / height
        right, up, forward = self.axes
        across = ((x - width / 2) * scale)[:, None] * right
        along = ((height / 2 - y) * scale)[:, None] * up
        directions = forward + across + along
        unit: Float64 = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        return unit


def frame_recording(recording: Recording, aspect: float) -> Camera:
    """One camera for every frame, ``aspect`` wide for its height.

    It stands where what moves or breaks is seen, and near it (docs/films.md).
    """
    subject = find_subject(recording)
    moments = find_moments(recording, subject.bodies) if subject.bodies else []
    sides = _sides(subject)
    cameras: list[Camera] = []
    for height in HEIGHTS:
        cameras += [_from_side(subject, height, *side, aspect) for side in sides]
        seen = [_seen(camera, moments, aspect) for camera in cameras]
        if max(share for share, _ in seen) >= 1.0 - PIT:
            break
    # The first of those that see about the most.
    sizes = np.array([size for _, size in seen])
    return cameras[int(np.argmax(sizes >= ALIKE * sizes.max()))]


def _from_side(
    subject: Subject, height: float, front: Float64, side: float, aspect: float
) -> Camera:
    half_height = float(np.tan(np.radians(FIELD_OF_VIEW_DEGREES / 2)))
    across = side * np.cross([0.0, 1.0, 0.0], front)
    forward = -VIEW_FROM @ np.array([across, front]) - np.array([0.0, height, 0.0])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(right, forward), forward])

    slopes = np.array([half_height * aspect, half_height]) / MARGIN
    place = subject.middle + best_place(subject, axes, slopes) @ axes
    # Lamp and haze go by the distance to what it looks at.
    depth = float((subject.middle - place) @ forward)
    return Camera(eye=place, axes=axes, half_height=half_height, target=place + depth * forward)


def _sides(subject: Subject) -> list[tuple[Float64, float]]:
    """Horizontal unit vectors towards the camera, the best first, with 1 for a little to the left.

    The best is across the subject, where it goes.
    """
    extents = subject.extents
    across_x = extents[0] < THIN * extents[2]
    front = np.array([1.0, 0.0, 0.0] if across_x else [0.0, 0.0, 1.0])
    thin = across_x or extents[2] < THIN * extents[0]
    best = -front if thin and float(subject.drift @ front) < 0.0 else front
    beside = np.cross([0.0, 1.0, 0.0], best)
    return [(way, side) for way in (best, -best, beside, -beside) for side in (1.0, -1.0)]


def _seen(camera: Camera, moments: list[Moment], aspect: float) -> tuple[float, float]:
    """The share of what happens that nothing still hides, and how large what nothing hides is in
    the picture, on average."""
    total = free = size = 0.0
    for moment in moments:
        hidden = moment.hidden(camera.eye)
        across, up, depth = ((moment.places - camera.eye) @ camera.axes.T).T
        within = np.maximum(np.abs(across) / aspect, np.abs(up)) <= camera.half_height * depth
        shown = within & ~hidden.any(axis=1)
        total += float(moment.weights.sum())
        free += float(moment.weights @ ~hidden[:, moment.still].any(axis=1))
        size += float((moment.weights[shown] / depth[shown]).sum())
    return (free / total, size / total) if total > 0.0 else (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class MovingCamera:
    """A camera of a stage in a picture ``aspect`` times as wide as high, which sees at least what
    its lens shows."""

    camera: StageCamera
    #: Of the recording.
    fps: float
    aspect: float
    #: (3,) middle of what the recording shows [m].
    target: Float64

    def at(self, time: float) -> Camera:
        """Of a time [frames]; before its first row and after its last one it stands still."""
        first = self._row(0.0)
        place = time / self.fps * self.camera.fps
        return self._row(min(max(place, 0.0), len(self.camera.eyes) - 1.0), first)

    def _row(self, place: float, first: Camera | None = None) -> Camera:
        low = int(place)
        high = min(low + 1, len(self.camera.eyes) - 1)
        share = place - low
        eye, turn, lens = (
            (1.0 - share) * np.array(rows[low]) + share * np.array(rows[high])
            for rows in (self.camera.eyes, self.camera.orientations, self.camera.lenses)
        )
        # Rows are close: their quaternions' mean turns as their great circle does.
        right, up, back = rotation_matrix(turn / np.linalg.norm(turn)).T
        half_height = max(float(lens[1]), float(lens[0]) / self.aspect)
        return Camera(eye, np.array([right, up, -back]), half_height, self.target, first)


def camera_for(recording: Recording, choice: str, aspect: float) -> Camera | MovingCamera:
    """The camera of ``--camera``: ``fit`` frames the recording, ``stage`` and ``stage:PATH`` are of
    the stage that it came from, and all else is a file's name."""
    if choice == "fit":
        return frame_recording(recording, aspect)
    if choice == STAGE or choice.startswith(f"{STAGE}:"):
        camera = _of_stage(recording.convention.cameras, choice)
        middle = find_subject(recording).middle
        return MovingCamera(camera, recording.fps, aspect, middle)
    return read_camera(choice)


def check_camera(choice: str, cameras: tuple[StageCamera, ...] | None = None) -> None:
    """`CameraError` if a choice of ``--camera`` is wrong whatever it looks at, or, given the
    cameras of the stage, names none of them."""
    if choice == STAGE or choice.startswith(f"{STAGE}:"):
        if cameras is not None:
            _of_stage(cameras, choice)
    elif choice != "fit":
        read_camera(choice)


def _of_stage(cameras: tuple[StageCamera, ...], choice: str) -> StageCamera:
    path = choice.removeprefix(STAGE).removeprefix(":")
    if not cameras:
        raise CameraError(
            f"--camera: {choice}, must be fit or a .json file: the scene comes from no USD stage "
            "that has a camera with a perspective"
        )
    for camera in cameras:
        if path in ("", camera.name):
            return camera
    known = ", ".join(f"{STAGE}:{camera.name}" for camera in cameras)
    raise CameraError(f"--camera: {choice}, must be one of {known}")


def read_camera(path: str) -> Camera:
    """Read a camera from JSON (docs/films.md); `CameraError` names file, field, value and rule."""
    if not os.path.isfile(path):
        raise CameraError(f"{path}: no such file; --camera takes 'fit', 'stage' or a .json file")
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read(LARGEST_FILE + 1)
        document = json.loads(text) if len(text) <= LARGEST_FILE else None
    except (OSError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise CameraError(f"{path}: is not a readable JSON file ({error})") from error
    if not isinstance(document, dict):
        raise CameraError(f"{path}: must hold one JSON object with 'eye' and 'target'")
    fields = ("eye", "target", "up", "fov")
    for name in document:
        if name not in fields:
            known = ", ".join(fields)
            raise CameraError(f"{path}: field {name!r} is unknown, must be one of {known}")
    for name in ("eye", "target"):
        if name not in document:
            raise CameraError(f"{path}: has no field {name!r}, must have 'eye' and 'target'")
    for name in ("eye", "target", "up"):
        if name in document and not _is_vector(document[name]):
            given = json.dumps(document[name])[:60]
            raise CameraError(f"{path}: {name}: {given}, must be three finite numbers")
    if "fov" in document and not _is_number(document["fov"]):
        given = json.dumps(document["fov"])[:60]
        raise CameraError(f"{path}: fov: {given}, must be a number of degrees")
    try:
        return Camera.look_at(**document)
    except CameraError as error:
        raise CameraError(f"{path}: {error}") from error


def _is_vector(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -1e30 < value < 1e30
