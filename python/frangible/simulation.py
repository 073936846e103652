"""From the name of a shot to a recording."""

from __future__ import annotations

import os
from contextlib import nullcontext

from ._frangible import World, shot_frames, shot_scene
from .recording import ProgressCallback, Recording, check_frames
from .usd_mesh import readable_mesh


def run(
    shot: str,
    *,
    mesh: str | os.PathLike[str] | None = None,
    frames: int | None = None,
    fps: float | None = None,
    method: str | None = None,
    threads: int = 0,
    seed: int | None = None,
    progress: ProgressCallback | None = None,
) -> Recording:
    """Build a shot, step it ``frames`` times at ``fps`` steps per second, and keep everything it shows.

    ``mesh`` is a file for shots that break one; without ``frames`` the shot takes as long as it is meant to; what
    stands for `None` in ``fps``, ``method`` and ``seed``, `shot_defaults` says; 0 ``threads`` means one for every
    processor. `BuildError` if the scene cannot be built, `ValueError` without a frame to step.
    """
    # Before anything is built, which can take a while.
    if frames is None:
        frames = shot_frames(shot, fps)
    check_frames(frames)
    # The scene names the mesh's file: `build` reads it once more.
    with nullcontext() if mesh is None else readable_mesh(mesh) as path:
        scene = shot_scene(shot, mesh=path, fps=fps, method=method, seed=seed)
        world = World.build(scene, threads)
    return Recording.record(world, frames, shot=shot, fps=fps, progress=progress)
