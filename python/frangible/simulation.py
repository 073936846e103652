"""From a shot or a scene to a recording."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ._frangible import BuildError, World
from .recording import ProgressCallback, Recording, check_frames
from .scene_lines import convention_of
from .scene_skins import scene_skins
from .scene_file import Scene
from .scenes import find_scene, readable_scene


def run(
    scene: str | os.PathLike[str] | dict[str, Any] | Scene,
    *,
    mesh: str | os.PathLike[str] | None = None,
    frames: int | None = None,
    fps: float | None = None,
    method: str | None = None,
    threads: int = 0,
    seed: int | None = None,
    progress: ProgressCallback | None = None,
    inside: str | None = None,
    wishes: Mapping[str, Any] | None = None,
) -> Recording:
    """Build a scene, step it ``frames`` times at ``fps`` steps per second, and keep everything it
    shows.

    ``scene`` is the name of a shot, the path of a scene file (it ends in .json, .toml or .py, or
    has a folder), a `Scene`, or a scene as a dictionary. ``mesh`` is a file for shots that break
    one; without ``frames`` a shot takes as long as it is meant to, and a scene of one's own three
    seconds; what stands for `None` in ``fps``, ``method`` and ``seed`` of a shot, `shot_defaults`
    says; 0 ``threads`` means one for every processor. ``inside`` names the material of what cracks
    lay bare in meshes, as in `break_mesh`. For a single mesh file as the scene, ``wishes`` are
    fields of `mesh_scene.Wishes`: material, pattern, ball, ground and so on. `BuildError` if the
    scene cannot be built, `ValueError` without a frame to step.
    """
    # Before anything is built, which can take a while.
    if frames is not None:
        check_frames(frames)
    mesh = None if mesh is None else os.fspath(mesh)
    found, own_frames, name = find_scene(
        scene, mesh=mesh, fps=fps, method=method, seed=seed, wishes=wishes
    )
    with readable_scene(found) as readable:
        world = World.build(readable, threads)
        check_bodies(world)
        skins = scene_skins(found, readable, inside)
    rate = float(found.get("frames_per_second", 1.0 / world.dt))
    recording = Recording.record(
        world, frames or own_frames, shot=name, fps=rate, progress=progress, skins=skins
    )
    return replace(recording, convention=convention_of(found))


def check_bodies(world: World) -> None:
    """Raise `BuildError` if there is nothing to simulate."""
    if len(world.ids) == 0:
        raise BuildError("bodies: [], must have one at least")
