"""Recordings in files of any format that we write, for the player."""

from __future__ import annotations

import os

from ..extras import missing_packages
from ..recording import Recording
from .mesh_files import USD_ENDINGS


def read_recording(path: str) -> Recording | None:
    """The recording in a file or in the folder of a run; `None` if the path names a shot, a scene
    or a mesh that stands still. `CacheError` if it is damaged."""
    ending = os.path.splitext(path)[1].lower()
    if ending == ".npz" or os.path.isdir(path):
        return Recording.load(path)
    if ending in (".glb", ".gltf"):
        from .gltf_recording import read_gltf_recording

        return read_gltf_recording(path)
    if ending in USD_ENDINGS and not missing_packages("usd"):
        from .usd_recording import read_usd_recording

        return read_usd_recording(path)
    return None
