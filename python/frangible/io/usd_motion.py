"""Motion of bodies in USD: transforms, life and velocities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from ..recording import Body, Float64, product, rotation_matrix, without_sign_flips
from .keyframes import telling_samples

#: How long a body takes to appear and to vanish [frames].
STEP = 1.0 / 64.0


@dataclass(frozen=True, slots=True)
class Timing:
    """When the frames of a recording are."""

    #: The time code of frame 0.
    first: float = 0.0
    #: Time codes, and frames, in a second.
    fps: float = 1.0
    #: So much later bodies appear and vanish [frames].
    late: float = 0.0


def write_motion(mesh: Any, body: Body, timing: Timing) -> None:
    """Samples while a body lives, one before and one after, and none that interpolation gives
    anyway.

    So a shutter that is open across its birth or its death sees it move.
    """
    begin, positions, orientations = _with_ends(body)
    times = timing.first + begin + np.arange(len(positions))
    translate = mesh.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
    places = [Gf.Vec3d(*position) for position in positions.tolist()]
    _set_samples(translate.GetAttr(), times, places, telling_samples(positions))
    orient = mesh.AddOrientOp(UsdGeom.XformOp.PrecisionFloat)
    turns = [Gf.Quatf(w, x, y, z) for x, y, z, w in orientations.tolist()]
    _set_samples(orient.GetAttr(), times, turns, telling_samples(orientations))


def _with_ends(body: Body) -> tuple[int, Float64, Float64]:
    """The first frame, positions and orientations, with the pose before a piece's birth, and a body
    that breaks goes on as it went for a frame."""
    begin = body.birth_frame
    positions, orientations = body.positions, body.orientations
    if body.before is not None and begin > 0:
        begin -= 1
        positions = np.concatenate([body.before[None, :3], positions])
        orientations = np.concatenate([body.before[None, 3:], orientations])
    moves = len(positions) > 1 and bool(
        np.any(positions[-1] != positions[-2]) or np.any(orientations[-1] != orientations[-2])
    )
    if body.death_frame is not None and moves:
        positions = np.concatenate([positions, 2.0 * positions[-1:] - positions[-2:-1]])
        turn = _between(orientations[-2], orientations[-1])
        orientations = np.concatenate([orientations, product(turn, orientations[-1])[None]])
    return begin, positions, without_sign_flips(orientations)


def _between(start: Float64, end: Float64) -> Float64:
    """The rotation that turns one orientation into another."""
    return product(end, start * [-1.0, -1.0, -1.0, 1.0])


def _set_samples(attribute: Any, times: Any, values: Any, rows: Any) -> None:
    if len(rows) == 1:
        attribute.Set(values[0])
        return
    # Thousands of paths are long: write to the layer itself, without a notice for every sample.
    layer, path = attribute.GetStage().GetEditTarget().GetLayer(), attribute.GetPath()
    with Sdf.ChangeBlock():
        for row in rows.tolist():
            layer.SetTimeSample(path, float(times[row]), values[row])


def write_life(mesh: Any, body: Body, timing: Timing) -> None:
    """Show a body while it lives; not everything that reads USD heeds a visibility that changes."""
    if body.birth_frame == 0 and body.death_frame is None:
        return
    visibility = mesh.CreateVisibilityAttr()
    scale = mesh.AddScaleOp(UsdGeom.XformOp.PrecisionFloat)
    nothing, whole = Gf.Vec3f(0.0), Gf.Vec3f(1.0)
    # What is there at first is not late.
    birth = timing.first + body.birth_frame + (timing.late if body.parent is not None else 0.0)
    if birth > timing.first:
        visibility.Set(UsdGeom.Tokens.invisible, timing.first)
        # Scales between two samples are interpolated: each change is a steep one.
        scale.Set(nothing, birth - STEP)
    visibility.Set(UsdGeom.Tokens.inherited, birth)
    scale.Set(whole, birth)
    if body.death_frame is not None:
        death = timing.first + body.death_frame + timing.late
        visibility.Set(UsdGeom.Tokens.invisible, death)
        scale.Set(whole, death - STEP)
        scale.Set(nothing, death)


def write_velocities(mesh: Any, body: Body, timing: Timing) -> None:
    """Linear and angular velocity on the way to each frame, by the names, in the space and in the
    units of UsdPhysics: of the prim's parent, per second, degrees.

    The API schema is not applied: programs that simulate would take the cache for a scene.
    """
    if not body.moves:
        return
    linear, angular = velocities(body, timing.fps)
    times = timing.first + body.birth_frame + np.arange(len(linear))
    for name, values in (("velocity", linear), ("angularVelocity", np.degrees(angular))):
        attribute = mesh.GetPrim().CreateAttribute(
            f"physics:{name}", Sdf.ValueTypeNames.Vector3f, True
        )
        rows = telling_samples(values)
        _set_samples(attribute, times, [Gf.Vec3f(*row) for row in values.tolist()], rows)


def velocities(body: Body, fps: float) -> tuple[Float64, Float64]:
    """(k, 3) each, world frame [m/s, rad/s]: means over the frame that leads to each one. The first
    is that of the next where nothing is known before."""
    positions, turns = body.positions, body.orientations
    if body.before is not None:
        positions = np.concatenate([body.before[None, :3], positions])
        turns = np.concatenate([body.before[None, 3:], turns])
    if len(positions) == 1:
        return np.zeros((1, 3)), np.zeros((1, 3))
    linear = np.diff(positions, axis=0) * fps
    x, y, z, w = (turns[:-1] * [-1.0, -1.0, -1.0, 1.0]).T
    a, b, c, d = turns[1:].T
    # Hamilton's product of each later orientation with the inverse of the earlier one.
    both = np.stack(
        [
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ],
        axis=1,
    )
    both *= np.where(both[:, 3:] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(both[:, :3], axis=1)
    angle = 2.0 * np.arctan2(sine, both[:, 3])
    # An angle over its sine is 2 where there is hardly a turn.
    rate = np.where(sine > 1e-9, angle / np.maximum(sine, 1e-30), 2.0)
    angular = both[:, :3] * rate[:, None] * fps
    if body.before is None:
        linear, angular = (np.concatenate([rows[:1], rows]) for rows in (linear, angular))
    return linear, angular


def extent_of_all(bodies: list[Body]) -> Any:
    """Two corners around all bodies in all frames, with room for any turn of those that turn."""
    lows, highs = [], []
    for body in bodies:
        if not len(body.vertices):
            continue
        if np.any(body.orientations != body.orientations[0]):
            reach = np.full(3, np.linalg.norm(body.vertices, axis=1).max())
            low, high = -reach, reach
        else:
            turned = body.vertices @ rotation_matrix(body.orientations[0]).T
            low, high = turned.min(axis=0), turned.max(axis=0)
        lows.append(body.positions.min(axis=0) + low)
        highs.append(body.positions.max(axis=0) + high)
    if not lows:
        return Vt.Vec3fArray([Gf.Vec3f(0.0), Gf.Vec3f(0.0)])
    least, most = np.min(lows, axis=0).tolist(), np.max(highs, axis=0).tolist()
    return Vt.Vec3fArray([Gf.Vec3f(*least), Gf.Vec3f(*most)])
