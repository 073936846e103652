"""Where files of pieces for other simulators go, and what is assumed of them."""

from __future__ import annotations

import os
import re

from ..errors import OutputError

#: Of water, as UsdPhysics has it for what says nothing [kg/m^3].
DEFAULT_DENSITY = 1000.0
#: What a folder of meshes of ours holds.
_OURS = re.compile(r"[^/]+\.obj")


def mesh_folder(path: str) -> str:
    """Where the meshes of a file go."""
    return f"{os.path.splitext(path)[0]}_meshes"


def check_mesh_folder(path: str) -> None:
    """`OutputError` if something else is where the meshes of a file go."""
    folder = mesh_folder(path)
    if os.path.isdir(folder):
        for name in sorted(os.listdir(folder)):
            if not _OURS.fullmatch(name):
                raise OutputError(f"{folder}: holds {name!r}, must hold meshes of pieces only")
    elif os.path.lexists(folder):
        raise OutputError(f"{folder}: is a file, must be a folder for the meshes of {path}")
