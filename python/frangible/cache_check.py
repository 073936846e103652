"""Arrays of a ``.npz`` file that somebody may have damaged: read within bounds, and compared with the table in `cache`."""

from __future__ import annotations

import math
import os
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .reading import MOST_BYTES

Array = npt.NDArray[Any]
Arrays = dict[str, Array]

#: For each key its kind (of `numpy.dtype.kind`) and shape: b bodies, and v, t, p, c, n, i rows of
#: parts.
_TABLE: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "shot": ("U", ()),
    "method": ("U", ()),
    "fps": ("f", ()),
    "frames": ("iu", ()),
    "ids": ("iu", ("b",)),
    "names": ("U", ("b",)),
    "parents": ("iu", ("b",)),
    "sources": ("iu", ("b",)),
    "birth_frames": ("iu", ("b",)),
    "death_frames": ("iu", ("b",)),
    "masses": ("f", ("b",)),
    "looks": ("U", ("b",)),
    "vertices": ("f", ("v", 3)),
    "triangles": ("iu", ("t", 3)),
    "interior": ("b", ("t",)),
    "coordinates": ("f", ("t", 3, 2)),
    "positions": ("f", ("p", 3)),
    "orientations": ("f", ("p", 4)),
    "reports": ("U", ()),
}
#: Keys of format 4.
_SKINS: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "paths": ("U", ("b",)),
    "materials": ("U", ()),
    "image_data": ("iu", ("i",)),
    "material": ("iu", ("t",)),
    "colours": ("f", ("c", 3, 4)),
    "normals": ("f", ("n", 3, 3)),
}
#: Keys that not every cache has.
_MORE: dict[str, tuple[str, tuple[str | int, ...]]] = {"before": ("f", ("b", 7))}
#: The rows that each array of offsets shares out among the bodies.
_OFFSETS = {"vertex_offsets": "v", "triangle_offsets": "t", "pose_offsets": "p"}
_SKIN_OFFSETS = {"colour_offsets": "c", "normal_offsets": "n"}
#: Arrays that every cache has.
KEYS = ("format", *_TABLE, *_OFFSETS)
#: How far the length of a quaternion may be off 1.
_ROUNDING = 1e-6


def read_arrays(path: str) -> Arrays:
    """All arrays of a file; `ValueError` for what has objects, or more bytes than it says or than 2 GiB."""
    arrays: Arrays = {}
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        size = sum(member.file_size for member in members)
        if size > MOST_BYTES:
            raise ValueError(f"it unpacks to {size} bytes, must be at most {MOST_BYTES}")
        for member in members:
            key, ending = os.path.splitext(member.filename)
            if ending != ".npy" or key in arrays:
                raise ValueError(f"it holds {member.filename!r}")
            with archive.open(member) as file:
                arrays[key] = _array(key, file, member.file_size)
    return arrays


def _array(key: str, file: Any, size: int) -> Array:
    version = np.lib.format.read_magic(file)
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
    if read is None:
        raise ValueError(f"{key} has the unknown version {version}")
    shape, is_fortran, dtype = read(file)
    # Nothing is made room for before it is known to be there.
    length = math.prod(shape) * dtype.itemsize
    if dtype.hasobject or dtype.itemsize == 0 or min(shape, default=0) < 0 or length != size - file.tell():
        raise ValueError(f"{key} has not the {length} bytes of {shape} {dtype}")
    data = np.frombuffer(bytearray(file.read(length)), dtype)
    return data.reshape(shape, order="F" if is_fortran else "C")


def check_arrays(arrays: Arrays) -> None:
    """`ValueError` where the arrays break a rule of the table."""
    has_skins = "paths" in arrays
    rows = {"b": len(arrays["ids"]) if arrays["ids"].ndim == 1 else 0}
    more = {key: rule for key, rule in _MORE.items() if key in arrays}
    for key, (kind, shape) in (_TABLE | (_SKINS if has_skins else {}) | more).items():
        _check_shape(key, arrays[key], kind, shape, rows)
    offsets = _OFFSETS | (_SKIN_OFFSETS if has_skins else {})
    counts = {name: _check_offsets(key, arrays[key], rows["b"], rows[name]) for key, name in offsets.items()}
    _check_numbers(arrays)
    _check_lives(arrays, counts["p"])

    # Triangles have vertices of their own body.
    triangles, own = arrays["triangles"], np.repeat(counts["v"], counts["t"])
    if np.any((triangles < 0) | (triangles >= own[:, None])):
        raise ValueError("triangles: a vertex that its body does not have")
    if has_skins:
        for name, key in (("c", "colours"), ("n", "normals")):
            if np.any((counts[name] != 0) & (counts[name] != counts["t"])):
                raise ValueError(f"{key}: not as many rows as triangles, or none, for each body")


def _check_shape(key: str, array: Array, kind: str, shape: tuple[str | int, ...], rows: dict[str, int]) -> None:
    fits = array.dtype.kind in kind and array.ndim == len(shape)
    # The first array with some rows says how many there are.
    fits = fits and all(
        size == (rows.setdefault(wanted, size) if isinstance(wanted, str) else wanted)
        for size, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join(str(rows.get(size, size) if isinstance(size, str) else size) for size in shape)
        raise ValueError(f"{key}: {array.shape} of {array.dtype}, must be ({wanted}) of another type or shape")


def _check_offsets(key: str, array: Array, bodies: int, last: int) -> npt.NDArray[np.int64]:
    """How many rows each body has."""
    if array.dtype.kind not in "iu" or array.shape != (bodies + 1,):
        raise ValueError(f"{key}: {array.shape} of {array.dtype}, must be ({bodies + 1},) whole numbers")
    if array[0] != 0 or array[-1] != last or np.any(array[1:] < array[:-1]):
        raise ValueError(f"{key}: must ascend from 0 to {last}")
    counts: npt.NDArray[np.int64] = np.subtract(array[1:], array[:-1], dtype=np.int64, casting="unsafe")
    return counts


def _check_numbers(arrays: Arrays) -> None:
    rules: dict[str, tuple[Callable[[Array], Any], str]] = {
        "fps": (lambda fps: np.isfinite(fps) & (fps > 0.0), "a number > 0"),
        "frames": (lambda frames: (frames >= 0) & (frames < 2**31), "at least 0"),
        "ids": (lambda ids: ids >= 0, "at least 0"),
        "masses": (lambda masses: masses >= 0.0, "at least 0"),
        "vertices": (np.isfinite, "finite"),
        "coordinates": (np.isfinite, "finite"),
        "positions": (np.isfinite, "finite"),
        "orientations": (np.isfinite, "finite"),
        "colours": (np.isfinite, "finite"),
        "normals": (np.isfinite, "finite"),
    }
    for key, (holds, rule) in rules.items():
        if key in arrays and not np.all(good := holds(arrays[key])):
            value = arrays[key][~good].ravel()[0] if arrays[key].ndim else arrays[key]
            raise ValueError(f"{key}: {value}, must be {rule}")
    lengths = np.linalg.norm(arrays["orientations"], axis=1)
    if np.any(bad := np.abs(lengths - 1.0) > _ROUNDING):
        raise ValueError(f"orientations: one of length {lengths[bad][0]:g}, must be 1")
    if "before" in arrays:
        _check_before(arrays["before"])
    if len(np.unique(arrays["ids"])) != len(arrays["ids"]):
        raise ValueError("ids: one comes twice")


def _check_before(before: Array) -> None:
    """Each row is whole and finite, or all NaN."""
    known = before[~np.isnan(before).all(axis=1)]
    if np.any(bad := ~np.isfinite(known)):
        raise ValueError(f"before: {known[bad][0]}, must be finite, or all of its row NaN")
    lengths = np.linalg.norm(known[:, 3:], axis=1)
    if np.any(bad := np.abs(lengths - 1.0) > _ROUNDING):
        raise ValueError(f"before: a quaternion of length {lengths[bad][0]:g}, must be 1")


def _check_lives(arrays: Arrays, poses: npt.NDArray[np.int64]) -> None:
    """Each body is there for a frame or more, and has a pose for each of them."""
    last = int(arrays["frames"])
    births, deaths = arrays["birth_frames"].astype(np.int64), arrays["death_frames"].astype(np.int64)
    ends = np.where(deaths == -1, last + 1, deaths)
    if np.any(bad := (births < 0) | (births > last)):
        raise ValueError(f"birth_frames: {births[bad][0]}, must be 0 to {last}")
    if np.any(bad := (ends <= births) | (ends > last + 1)):
        raise ValueError(f"death_frames: {deaths[bad][0]}, must be -1 or after the birth, and at most {last}")
    if np.any(poses != ends - births):
        raise ValueError("pose_offsets: must have a row for each frame of a life")
