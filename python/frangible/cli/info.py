"""Contents of a file: a mesh, or a cache of ours."""

from __future__ import annotations

import os

import numpy as np

from ..breaking.mesh_facts import described, read_facts
from ..errors import CacheError, one_sentence
from ..extras import missing_packages
from ..io.cache import check_is_file
from ..io.gltf_facts import describe_glb
from ..io.mesh_files import USD_ENDINGS, check_ending, readable_mesh
from ..recording import Recording


def describe_file(path: str, pose_time: float | None = None) -> dict[str, object]:
    """Facts to print, in order; `CacheError` or `BuildError` if the file is neither a mesh nor a
    cache."""
    ending = os.path.splitext(path)[1].lower()
    check_is_file(path)
    if ending == ".npz":
        return _describe_npz(path)
    if ending in USD_ENDINGS:
        if hint := missing_packages("usd"):
            raise CacheError(f"{path}: {hint}")
        from ..io.usd import describe_usd

        if (cache := describe_usd(path)) is not None:
            return cache
    if ending == ".glb":
        with one_sentence(path, "glTF file", CacheError):
            facts = describe_glb(path)
        if facts is not None:
            return facts
    check_ending(path)
    with readable_mesh(path, pose_time) as file:
        known = read_facts(file)
    return described(*known)


def _describe_npz(path: str) -> dict[str, object]:
    recording = Recording.load(path)
    masses = np.array([body.mass for body in recording.alive(recording.frames)])
    return {
        "shot": recording.shot,
        "method": recording.method,
        "frames": recording.frames,
        "fps": recording.fps,
        "bodies": (
            f"{len(recording.alive(0))} at first, {len(masses)} at last, {len(recording.bodies)} "
            "in all"
        ),
        "mass_kg": float(masses[np.isfinite(masses)].sum()),
        "triangles": sum(len(body.triangles) for body in recording.bodies),
    }
