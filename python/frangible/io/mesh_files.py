"""Mesh files of every format, handed to the core as one that it reads."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from .._frangible import BuildError
from ..extras import missing_packages
from .gltf_mesh import ENDINGS as GLTF_ENDINGS
from .gltf_mesh import make_plain
from .reading import FileNote, file_fault

#: A body of a stage: the file, then the prim's path in brackets.
_PRIM = re.compile(r"(.*\.usd[acz]?)<(/[^<>]*)>$", re.IGNORECASE | re.DOTALL)

Matrix = npt.NDArray[np.float64]

#: Endings of USD files.
USD_ENDINGS = (".usd", ".usda", ".usdc", ".usdz")

#: Endings of mesh files.
ENDINGS = (".obj", ".ply", ".stl", *GLTF_ENDINGS, *USD_ENDINGS)


def check_ending(path: str | os.PathLike[str]) -> None:
    """`BuildError` unless the file's ending is that of a mesh file."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in ENDINGS:
        rule = f"must end in one of {', '.join(ENDINGS)}"
        raise BuildError(f"{os.fspath(path)}: ends in {ending!r}, {rule}")


@contextmanager
def readable_mesh(path: str | os.PathLike[str], pose_time: float | None = None) -> Iterator[str]:
    """The path itself, or for a USD or glTF file that of a plain mesh file that the core reads,
    while the context lasts.

    USD is read whole, with lengths in metres and y up; of glTF what is packed is unpacked. What
    moves is where it is at the beginning or, if that is given, ``pose_time`` [s] after it. Of a
    body of a stage, as `stage_and_prim` splits it, only that is read, in its own frame.
    `BuildError` if there is no mesh, or a package for it is missing; `FileNote` warnings name what
    is left out.
    """
    path = os.fspath(path)
    ending = mesh_ending(path)
    own, prim = stage_and_prim(path)
    if prim is not None:
        with readable_bodies(own, [prim]) as files:
            yield files[prim]
        return
    if ending not in (*USD_ENDINGS, *GLTF_ENDINGS) or file_fault(path):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(
            folder, f"{os.path.basename(path)}{'.obj' if ending in USD_ENDINGS else '.glb'}"
        )
        if ending in USD_ENDINGS:
            _stage_to_obj(path, name, pose_time)
        elif not make_plain(path, name, pose_time):
            name = path
        # The report of a break stands beside its pieces, in their place.
        report = os.path.splitext(path)[0] + ".json"
        if name != path and os.path.isfile(report):
            shutil.copyfile(report, os.path.splitext(name)[0] + ".json")
        try:
            yield name
        except BuildError as error:
            raise BuildError(str(error).replace(name, path)) from None


def mesh_frame(path: str) -> Matrix:
    """The matrix (3, 3) from the unit and axes of a USD file to metres, y up."""
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    from .usd_stage import metres_from_stage, open_stage

    if fault := file_fault(path):
        raise BuildError(f"{path}: {fault}")
    with open_stage(path) as stage:
        return metres_from_stage(path, stage)


def mesh_strength(path: str) -> dict[str, list[Any]]:
    """Strength points and triangles of a USD file's meshes, as `readable_mesh` reads them, for
    `Breaking` and `Bonds`; nothing of what has none. `FileNote` warnings name what is left out."""
    from .usd_strength import strength_of_stage

    found, notes = strength_of_stage(path)
    for note in notes:
        warnings.warn(f"{path}: {note}", FileNote, stacklevel=2)
    return found


def stage_and_prim(path: str) -> tuple[str, str | None]:
    """A USD file and the prim of a body in it, of a path as in ``stage.usda</World/wall>``; any
    other path as it is, and no prim."""
    found = _PRIM.match(path)
    return (path, None) if found is None else (found[1], found[2])


def mesh_ending(path: str) -> str:
    """The ending of a mesh file, in lower case."""
    return os.path.splitext(stage_and_prim(path)[0])[1].lower()


@contextmanager
def readable_bodies(path: str, prims: Iterable[str]) -> Iterator[dict[str, str]]:
    """For bodies of a stage, by the paths of their prims, plain mesh files that the core reads,
    while the context lasts; a `BuildError` of it names the stage and the prim instead."""
    if fault := file_fault(path):
        raise BuildError(f"{path}: {fault}")
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    from .usd_body_mesh import write_bodies

    with tempfile.TemporaryDirectory() as folder:
        files = {
            prim: os.path.join(folder, f"{number}.obj")
            for number, prim in enumerate(dict.fromkeys(prims))
        }
        write_bodies(path, files)
        try:
            yield files
        except BuildError as error:
            said = str(error)
            for prim, name in files.items():
                said = said.replace(name, f"{path}<{prim}>")
            raise BuildError(said) from None


def _stage_to_obj(path: str, obj: str, pose_time: float | None) -> None:
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    from .usd_mesh import write_stage

    write_stage(path, obj, pose_time)
