"""The meshes of bodies of a UsdPhysics stage, each in its body's frame."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .._frangible import BuildError
from .usd_bodies import Collider, StageBody, find_bodies
from .usd_frames import affine, frame_of
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_obj import write_obj
from .usd_part import moved
from .usd_stage import metres_from_stage, open_stage, time_code


def write_bodies(path: str, files: dict[str, str]) -> None:
    """Write the colliders of bodies, or colliders that are no body's, by their names, as OBJ files
    in metres, each in the rigid frame of its prim. Objects have the names below it."""
    with open_stage(path) as stage:
        time = time_code(stage, None)
        units = affine(metres_from_stage(path, stage).T, np.zeros(3))
        bodies = {body.name: body for body in find_bodies(stage, units, time, Notes())}
        for name, obj in files.items():
            body = bodies.get(name)
            if body is None or not body.colliders:
                raise BuildError(f"{path}: {name} is no body with a shape that collides")
            _write_body(path, body, obj, time)


def _write_body(path: str, body: StageBody, obj: str, time: Any) -> None:
    reader = StageReader(path, time, is_posed=False)
    into = np.linalg.inv(frame_of(body.world).matrix())
    above = str(body.prim.GetPath())
    parts = [
        replace(moved(part, collider.world @ into), name=_below(collider, above))
        for collider in body.colliders
        for part in reader.parts_of(collider.prim)
    ]
    if not any(len(part.counts) for part in parts):
        raise BuildError(f"{path}: {body.name} has no triangles")
    write_obj(obj, parts, time)


def _below(collider: Collider, above: str) -> str:
    """The names from the body's prim down to the collider."""
    return str(collider.prim.GetPath()).removeprefix(above) or "/"
