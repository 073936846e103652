"""The mesh of one body of a UsdPhysics stage, in the body's frame."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .._frangible import BuildError
from .usd_bodies import Collider, find_bodies
from .usd_frames import affine, frame_of
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_obj import write_obj
from .usd_part import moved
from .usd_stage import metres_from_stage, open_stage, time_code


def write_body(path: str, prim: str, obj: str) -> None:
    """Write the colliders of a body, or a collider that is no body's, as OBJ in metres, in the
    rigid frame of its prim. Objects have the names below it."""
    with open_stage(path) as stage:
        time = time_code(stage, None)
        units = affine(metres_from_stage(path, stage).T, np.zeros(3))
        body = next(
            (one for one in find_bodies(stage, units, time, Notes()) if one.name == prim), None
        )
        if body is None or not body.colliders:
            raise BuildError(f"{path}: {prim} is no body with a shape that collides")
        reader = StageReader(path, time, is_posed=False)
        into = np.linalg.inv(frame_of(body.world).matrix())
        parts = [
            replace(moved(part, collider.world @ into), name=_below(collider, prim))
            for collider in body.colliders
            for part in reader.parts_of(collider.prim)
        ]
        if not any(len(part.counts) for part in parts):
            raise BuildError(f"{path}: {prim} has no triangles")
        write_obj(obj, parts, reader.time)


def _below(collider: Collider, prim: Any) -> str:
    """The names from the body's prim down to the collider."""
    return str(collider.prim.GetPath()).removeprefix(prim) or "/"
