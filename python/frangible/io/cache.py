"""The ``.npz`` cache: a recording as plain NumPy arrays.

===================== ================== ===========================================================
key                   shape and type     meaning
===================== ================== ===========================================================
``format``            () int64           version of this table, 6; 5 had no ``volumes``, 4 no
                                         ``before``, 3 no skins
``shot``              () str             name of the shot
``method``            () str             which step advanced a frame
``fps``               () float64         frames per second
``frames``            () int64           last frame; frame 0 is the state before the first step
``ids``               (b,) uint64        body ids, ascending
``names``             (b,) str           names
``parents``           (b,) int64         id of the body it broke off from, -1 for bodies of the
                                         scene
``sources``           (b,) uint64        id of the body of the scene that it once was a part of
``birth_frames``      (b,) int64         first frame that shows the body
``death_frames``      (b,) int64         first frame that no longer shows it, -1 if it outlives the
                                         recording
``masses``            (b,) float64       [kg], infinite for static and kinematic bodies
``looks``             (b,) str           what they are drawn as, empty if nobody said
``vertices``          (v, 3) float32     body frame [m]; those of body i are rows
                                         ``vertex_offsets[i:i+2]``
``triangles``         (t, 3) uint32      indices within the body; rows ``triangle_offsets[i:i+2]``
``interior``          (t,) bool          whether a crack made the triangle
``coordinates``       (t, 3, 2) float32  texture coordinates of its corners [m]
``positions``         (p, 3) float64     centre of mass, world frame [m]; rows
                                         ``pose_offsets[i:i+2]``
``orientations``      (p, 4) float64     ``world_from_body``, quaternions x, y, z, w; the same rows
``paths``             (b,) str           skins begin here: names of the nodes above it in its mesh's
                                         file, as a JSON list
``materials``         () str             of all skins, as JSON: the fields of `Material`, images as
                                         numbers
``image_data``        (n,) uint8         the images' files; those of image i are
                                         ``image_offsets[i:i+2]``
``material``          (t,) int32         index of each triangle's material, -1 for what the look
                                         decides
``colours``           (c, 3, 4) float32  of the triangles' corners; rows ``colour_offsets[i:i+2]``,
                                         none without any
``normals``           (n, 3, 3) float32  unit, of the triangles' corners; rows
                                         ``normal_offsets[i:i+2]``, none without any
``before``            (b, 7) float64     a frame before its birth, as a part of its parent; NaN for
                                         none
``volumes``           (b,) float64       [m^3], 0 for bodies without a volume, NaN for none
``*_offsets``         (b + 1,) int64     first row of each body, then the number of rows
``reports``           () str             the report of every step, as JSON
``convention``        () str             axes, unit and first time of USD, as JSON; none in older
                                         caches
===================== ================== ===========================================================
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from typing import Any
from zipfile import is_zipfile

import numpy as np
import numpy.typing as npt

from ..convention import Convention
from ..errors import CacheError, one_sentence
from ..kept_frames import read_folder
from ..recording import Body, Recording
from ..report import StepReport
from .cache_check import check_arrays, check_family, read_arrays
from .npz import Parts, Text, write_arrays
from .reading import file_fault
from .skin_cache import no_constant, offsets, read_skins, rows, skin_arrays

FORMAT = 6


def write_npz(recording: Recording, path: str) -> None:
    """Write a recording as the arrays above."""
    bodies = recording.bodies
    arrays: dict[str, npt.NDArray[Any] | Parts | Text] = {
        "format": np.array(FORMAT),
        "shot": np.array(recording.shot),
        "method": np.array(recording.method),
        "fps": np.array(recording.fps, np.float64),
        "frames": np.array(recording.frames),
        "ids": np.array([body.id for body in bodies], np.uint64),
        "names": np.array([body.name for body in bodies], np.str_),
        "parents": np.array(
            [-1 if body.parent is None else body.parent for body in bodies], np.int64
        ),
        "sources": np.array([body.source for body in bodies], np.uint64),
        "birth_frames": np.array([body.birth_frame for body in bodies], np.int64),
        "death_frames": np.array(
            [-1 if body.death_frame is None else body.death_frame for body in bodies], np.int64
        ),
        "masses": np.array([body.mass for body in bodies], np.float64),
        "looks": np.array([body.look or "" for body in bodies], np.str_),
        "vertices": Parts([body.vertices for body in bodies], (3,), np.float32),
        "vertex_offsets": offsets([body.vertices for body in bodies]),
        "triangles": Parts([body.triangles for body in bodies], (3,), np.uint32),
        "triangle_offsets": offsets([body.triangles for body in bodies]),
        "interior": Parts([body.interior for body in bodies], (), np.bool_),
        "coordinates": Parts([body.coordinates for body in bodies], (3, 2), np.float32),
        "positions": Parts([body.positions for body in bodies], (3,), np.float64),
        "orientations": Parts([body.orientations for body in bodies], (4,), np.float64),
        "pose_offsets": offsets([body.positions for body in bodies]),
        "reports": Text(lambda: _json_pieces(recording.reports)),
        "convention": np.array(recording.convention.to_json()),
        **skin_arrays(bodies),
        "before": rows([_before(body)[None] for body in bodies], (0, 7), np.float64),
        "volumes": np.array(
            [np.nan if body.volume is None else body.volume for body in bodies], np.float64
        ),
    }
    write_arrays(path, arrays)


def _json_pieces(reports: Sequence[StepReport]) -> Iterator[str]:
    """A list of them as JSON."""
    yield "["
    for number, report in enumerate(reports):
        yield f"{', ' if number else ''}{json.dumps(report)}"
    yield "]"


def read_npz(path: str) -> Recording:
    """Read a recording back, or what a run left that was stopped; `CacheError` if the file is not
    one of ours, or damaged."""
    if os.path.isdir(path):
        with one_sentence(path, "folder of a run", CacheError):
            return read_folder(path)
    check_is_file(path)
    if not is_zipfile(path):
        named = f"{os.path.splitext(os.path.basename(path))[0]}.npz"
        hint = f", must be the cache of a run, which --out {named} writes"
        raise CacheError(f"{path}: is not a .npz file{hint}")
    with one_sentence(path, ".npz cache", CacheError):
        arrays = read_arrays(path)
        check_arrays(arrays)
        return _recording(arrays)


def check_is_file(path: str) -> None:
    """`CacheError` if there is nothing to read."""
    if fault := file_fault(path):
        raise CacheError(f"{path}: {fault}")


def _before(body: Body) -> npt.NDArray[np.float64]:
    return np.full(7, np.nan) if body.before is None else body.before


def _recording(arrays: dict[str, npt.NDArray[Any]]) -> Recording:
    vertices, triangles, poses = (
        arrays[key].tolist() for key in ("vertex_offsets", "triangle_offsets", "pose_offsets")
    )
    reports = _reports(str(arrays["reports"]), int(arrays["frames"]))
    check_family(arrays, reports)
    bodies = []
    skins = read_skins(arrays)
    none = np.zeros(len(arrays["ids"]), np.bool_)
    has_before = ~np.isnan(arrays["before"][:, 0]) if "before" in arrays else none
    volumes = arrays.get("volumes", np.full(len(arrays["ids"]), np.nan))
    has_volume = ~np.isnan(volumes)
    for i, body_id in enumerate(arrays["ids"].tolist()):
        vertex_rows, triangle_rows, pose_rows = (
            slice(*firsts[i : i + 2]) for firsts in (vertices, triangles, poses)
        )
        parent, death = int(arrays["parents"][i]), int(arrays["death_frames"][i])
        bodies.append(
            Body(
                id=body_id,
                name=str(arrays["names"][i]),
                parent=None if parent < 0 else parent,
                source=int(arrays["sources"][i]),
                birth_frame=int(arrays["birth_frames"][i]),
                death_frame=None if death < 0 else death,
                mass=float(arrays["masses"][i]),
                look=str(arrays["looks"][i]) or None,
                vertices=arrays["vertices"][vertex_rows],
                triangles=arrays["triangles"][triangle_rows],
                interior=arrays["interior"][triangle_rows],
                coordinates=arrays["coordinates"][triangle_rows],
                positions=arrays["positions"][pose_rows],
                orientations=arrays["orientations"][pose_rows],
                skin=skins[i],
                before=arrays["before"][i] if has_before[i] else None,
                volume=float(volumes[i]) if has_volume[i] else None,
            )
        )
    return Recording(
        shot=str(arrays["shot"]),
        method=str(arrays["method"]),
        fps=float(arrays["fps"]),
        frames=int(arrays["frames"]),
        bodies=bodies,
        reports=reports,
        convention=_convention(arrays),
    )


def _convention(arrays: dict[str, npt.NDArray[Any]]) -> Convention:
    if "convention" not in arrays:
        return Convention()
    return Convention.from_json(str(arrays["convention"]))


def _reports(text: str, frames: int) -> list[StepReport]:
    reports = json.loads(text, parse_constant=no_constant)
    if (
        not isinstance(reports, list)
        or not all(isinstance(report, dict) for report in reports)
        or len(reports) not in (0, frames)
    ):
        raise ValueError(f"reports: must be a list with an object for each of {frames} frames")
    return reports
