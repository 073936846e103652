"""Where a picture is taken from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .recording import Body, Float64

#: Vertical opening of the lens [degrees]: a short telephoto, which keeps uprights upright.
FIELD_OF_VIEW_DEGREES = 28.0
#: From the subject to the camera: in front, and a little to the left and above (right, up, front).
VIEW_FROM = np.array([-0.62, 0.40, 1.0])
#: A subject this much thinner in one horizontal direction than in the other has a front.
THIN = 0.8
#: What the subject's extent in the picture is multiplied by.
MARGIN = 1.15


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

    def rays(self, x: Float64, y: Float64, width: int, height: int) -> Float64:
        """Unit directions (n, 3) through the pixel coordinates x, y (n,), with y down."""
        scale = 2.0 * self.half_height / height
        right, up, forward = self.axes
        directions = forward + ((x - width / 2) * scale)[:, None] * right + ((height / 2 - y) * scale)[:, None] * up
        unit: Float64 = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        return unit


def frame_bodies(bodies: list[Body], frame: int, aspect: float) -> Camera:
    """A camera that sees what matters at a frame: all that moves, except stragglers far from the rest."""
    points = _subject(bodies, frame)
    half_height = float(np.tan(np.radians(FIELD_OF_VIEW_DEGREES / 2)))
    front = _front(bodies, frame)
    forward = -VIEW_FROM @ np.array([np.cross([0.0, 1.0, 0.0], front), [0.0, 1.0, 0.0], front])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(right, forward), forward])

    # Slide sideways until opposite margins are equal, then back until everything is inside them.
    local = points @ axes.T
    eye = np.zeros(3)
    retreats = []
    for axis, slope in ((0, half_height * aspect / MARGIN), (1, half_height / MARGIN)):
        high = np.max(local[:, axis] - slope * local[:, 2])
        low = np.min(local[:, axis] + slope * local[:, 2])
        eye[axis] = (high + low) / 2
        retreats.append((low - high) / (2 * slope))
    eye[2] = min(retreats)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    return Camera(eye=eye @ axes, axes=axes, half_height=half_height, target=target)


def _front(bodies: list[Body], frame: int) -> Float64:
    """The horizontal unit vector towards the camera's side: across the largest body, where the action is."""
    first = [body for body in bodies if body.alive(0) and np.isfinite(body.mass) and len(body.vertices)]
    if not first:
        return np.array([0.0, 0.0, 1.0])
    largest = max(first, key=lambda body: body.mass)
    extents = np.ptp(largest.vertices_world(0), axis=0)
    across_x = extents[0] < THIN * extents[2]
    front = np.array([1.0, 0.0, 0.0] if across_x else [0.0, 0.0, 1.0])

    # Where the action is: on which side of where the largest body was at first are the things that move?
    aside = [body.pose(frame)[0] - largest.positions[0] for body in bodies if body.moves and body.alive(frame)]
    forth = float(np.sum(aside, axis=0) @ front) if aside else 0.0
    thin = across_x or extents[2] < THIN * extents[0]
    return -front if thin and forth < 0.0 else front


def _subject(bodies: list[Body], frame: int) -> Float64:
    """Points (n, 3) that the picture must show, world frame [m]."""
    alive = [body for body in bodies if body.alive(frame) and len(body.vertices)]
    movable = [body for body in alive if body.moves] or alive
    if not movable:
        return np.array([[-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]])

    # The heaviest nine tenths lie close together; a straggler lies much farther out. Whatever has no mass of its own,
    # like a ball on rails, weighs nothing here.
    centres = np.array([body.pose(frame)[0] for body in movable])
    masses = np.array([body.mass if np.isfinite(body.mass) else 0.0 for body in movable])
    weights = masses if masses.any() else np.ones(len(movable))
    distances = np.linalg.norm(centres - np.average(centres, axis=0, weights=weights), axis=1)
    order = np.argsort(distances, kind="stable")
    covered = np.cumsum(weights[order])
    typical = distances[order[int(np.searchsorted(covered, 0.9 * covered[-1]))]]
    reach = [float(np.linalg.norm(np.ptp(body.vertices, axis=0))) / 2 for body in movable]
    near = distances <= 1.6 * typical + np.max(reach)
    return np.concatenate([body.vertices_world(frame) for body, keep in zip(movable, near, strict=True) if keep])
