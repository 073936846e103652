"""Arrays of a ``.npz`` file that somebody may have damaged: read within bounds, and compared with
the table in `cache`."""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..materials import LOOKS
from ..words import shortened
from .reading import MOST_BYTES

Array = npt.NDArray[Any]
Arrays = dict[str, Array]

#: No body is farther away [m], and no texture coordinate is larger.
FARTHEST = 1e12
#: No vertex is farther from its body's centre [m]: sides are at most 1e6 m long.
_LARGEST = 1e7
#: The last frame that a cache can have.
_LAST_FRAME = 2**31 - 1
#: How far the length of a quaternion may be off 1, and that of a normal in single precision.
_ROUNDING = 1e-6
_NORMAL_ROUNDING = 1e-3


@dataclass(frozen=True, slots=True)
class _Rule:
    """Requirements of one array."""

    #: Of `numpy.dtype.kind`.
    kind: str
    #: With letters for what other arrays share: b bodies, and v, t, p, c, n, i rows of parts.
    shape: tuple[str | int, ...]
    #: Where its entries are good, and what they must be.
    holds: Callable[[Array], Any]
    says: str


def _whole(shape: tuple[str | int, ...], least: int, most: int) -> _Rule:
    says = f"at least {least}" if most >= 2**63 - 1 else f"from {least} to {most}"
    return _Rule("iu", shape, lambda array: (array >= least) & (array <= most), says)


def _real(shape: tuple[str | int, ...], least: float, most: float) -> _Rule:
    says = f"from {least:g} to {most:g}"
    return _Rule("f", shape, lambda array: (array >= least) & (array <= most), says)


def _text(shape: tuple[str | int, ...], says: str, fits: Callable[[str], bool]) -> _Rule:
    def holds(array: Array) -> Any:
        texts = array.ravel().tolist()
        good = [_is_unicode(text) and fits(text) for text in texts]
        return np.array(good, np.bool_).reshape(array.shape)

    return _Rule("U", shape, holds, says)


def _is_unicode(text: str) -> bool:
    try:
        return "\0" not in text and bool(text.encode() or True)
    except UnicodeEncodeError:
        return False


def _is_path(text: str) -> bool:
    """True if this is a JSON list of names, or empty."""
    try:
        names = json.loads(text) if text else []
    except (ValueError, RecursionError):
        return False
    are_names = (isinstance(name, str) and _is_unicode(name) for name in names)
    return isinstance(names, list) and all(are_names)


def _any(_: str) -> bool:
    return True


_ID = _whole(("b",), 0, 2**63 - 1)
_OFFSET = _whole(("b + 1",), 0, 2**62)
_LENGTHS = (-FARTHEST, FARTHEST)

#: The rule of each array of every cache.
_TABLE: dict[str, _Rule] = {
    "format": _whole((), 3, 6),
    "shot": _text((), "text", _any),
    "method": _text((), "text", _any),
    "fps": _real((), 1e-3, 1e6),
    "frames": _whole((), 0, _LAST_FRAME),
    "ids": _ID,
    "names": _text(("b",), "text", _any),
    "parents": _whole(("b",), -1, 2**63 - 1),
    "sources": _ID,
    "birth_frames": _whole(("b",), 0, _LAST_FRAME),
    "death_frames": _whole(("b",), -1, _LAST_FRAME),
    "masses": _Rule(
        "f",
        ("b",),
        lambda masses: ((masses >= 1e-30) & (masses <= 1e30)) | (masses == math.inf),
        "from 1e-30 to 1e+30, or infinite",
    ),
    "looks": _text(
        ("b",), f"empty or one of {', '.join(LOOKS)}", lambda look: not look or look in LOOKS
    ),
    "vertices": _real(("v", 3), -_LARGEST, _LARGEST),
    "vertex_offsets": _OFFSET,
    "triangles": _whole(("t", 3), 0, 2**32 - 1),
    "triangle_offsets": _OFFSET,
    "interior": _Rule("b", ("t",), np.ones_like, "true or false"),
    "coordinates": _real(("t", 3, 2), *_LENGTHS),
    "positions": _real(("p", 3), *_LENGTHS),
    "orientations": _real(("p", 4), -1.0 - _ROUNDING, 1.0 + _ROUNDING),
    "pose_offsets": _OFFSET,
    "reports": _text((), "text", _any),
}
#: Since format 4.
_SKINS: dict[str, _Rule] = {
    "paths": _text(("b",), "a list of names in JSON, or empty", _is_path),
    "materials": _text((), "text", _any),
    "image_data": _whole(("i",), 0, 255),
    "image_offsets": _whole(("images + 1",), 0, 2**62),
    "material": _whole(("t",), -1, 2**31 - 1),
    # Blended between corners, in single precision.
    "colours": _real(("c", 3, 4), -_NORMAL_ROUNDING, 1e6),
    "colour_offsets": _OFFSET,
    "normals": _real(("n", 3, 3), -1.0 - _NORMAL_ROUNDING, 1.0 + _NORMAL_ROUNDING),
    "normal_offsets": _OFFSET,
}
#: Since format 5; some caches of format 4 have it.
_BEFORE: dict[str, _Rule] = {
    "before": _Rule(
        "f",
        ("b", 7),
        lambda before: np.isnan(before) | (np.abs(before) <= FARTHEST),
        f"at most {FARTHEST:g}, or NaN",
    ),
}
#: Since format 6.
_VOLUMES: dict[str, _Rule] = {
    "volumes": _Rule(
        "f",
        ("b",),
        # The longest sides are 1e6 m.
        lambda volumes: np.isnan(volumes) | ((volumes >= 0.0) & (volumes <= 2e18)),
        "from 0 to 2e+18, or NaN",
    ),
}
#: The rule of each array that is read.
_ALL = {**_TABLE, **_SKINS, **_BEFORE, **_VOLUMES, "convention": _text((), "text", _any)}

#: Bytes that are unpacked at a time.
_CHUNK = 2**20

#: The rows that each array of offsets shares out among the bodies, or among images.
_SHARED = {
    "vertex_offsets": "v",
    "triangle_offsets": "t",
    "pose_offsets": "p",
    "colour_offsets": "c",
    "normal_offsets": "n",
    "image_offsets": "i",
}


def read_arrays(path: str) -> Arrays:
    """All arrays of a file; `ValueError` for what is not of the table, has objects, or more bytes
    than it says or than 2 GiB. Their names are looked at before any of them is unpacked."""
    with zipfile.ZipFile(path) as archive:
        members: dict[str, zipfile.ZipInfo] = {}
        for member in archive.infolist():
            key, ending = os.path.splitext(member.filename)
            if ending != ".npy" or key in members:
                raise ValueError(f"it holds {shortened(member.filename)!r}")
            members[key] = member
        for key in _TABLE:
            if key not in members:
                what = ", so it is not a Frangible cache" if key == "format" else ""
                raise ValueError(f"has no key {key!r}{what}")
        size = sum(member.file_size for member in members.values())
        if size > MOST_BYTES:
            raise ValueError(f"it unpacks to {size} bytes, must be at most {MOST_BYTES}")
        heads = {}
        for key, member in members.items():
            with archive.open(member) as file:
                heads[key] = _head(key, file, member.file_size)
        rows = _body_rows(heads["ids"].shape)
        # What later tables add is not read.
        known = [key for key in heads if key in _ALL]
        for key in known:
            _check_shape(key, heads[key].shape, heads[key].dtype, _ALL[key], rows)
        arrays: Arrays = {}
        for key in known:
            member = members[key]
            with archive.open(member) as file:
                _head(key, file, member.file_size)
                arrays[key] = _array(key, file, heads[key])
    return arrays


@dataclass(frozen=True, slots=True)
class _Head:
    """What the file of an array says before its numbers."""

    shape: tuple[int, ...]
    is_fortran: bool
    dtype: np.dtype[Any]


def _head(key: str, file: Any, size: int) -> _Head:
    version = np.lib.format.read_magic(file)
    readers = np.lib.format.read_array_header_1_0, np.lib.format.read_array_header_2_0
    read = dict(zip([(1, 0), (2, 0)], readers, strict=True)).get(version)
    if read is None:
        raise ValueError(f"{key} has the unknown version {version}")
    shape, is_fortran, dtype = read(file)
    # Nothing is made room for before it is known to be there.
    length = math.prod(shape) * dtype.itemsize
    is_plain = not dtype.hasobject and dtype.itemsize > 0 and min(shape, default=0) >= 0
    if not is_plain or length != size - file.tell():
        raise ValueError(f"{key} has not the {length} bytes of {shape} {dtype}")
    return _Head(shape, is_fortran, dtype)


def _array(key: str, file: Any, head: _Head) -> Array:
    """What follows a head; it is held once."""
    data = np.empty(head.shape, head.dtype, order="F" if head.is_fortran else "C")
    bytes_of: Any = data.reshape(-1, order="A").view(np.uint8) if data.size else b""
    view = memoryview(bytes_of)
    while view:
        count = file.readinto(view[:_CHUNK])
        if not count:
            raise ValueError(f"{key} is cut off")
        view = view[count:]
    return data


def check_arrays(arrays: Arrays) -> None:
    """`ValueError` where the arrays break a rule of the table."""
    table = dict(_TABLE)
    if arrays["format"].shape == () and arrays["format"] >= 4:
        table |= _SKINS
        if arrays["format"] >= 5 or "before" in arrays:
            table |= _BEFORE
        if arrays["format"] >= 6:
            table |= _VOLUMES
    for key in table:
        if key not in arrays:
            raise ValueError(f"has no key {key!r}")
    rows = _body_rows(arrays["ids"].shape)
    for key, rule in table.items():
        _check_array(key, arrays[key], rule, rows)
    counts = {
        name: _shared_out(key, arrays[key], rows[name])
        for key, name in _SHARED.items()
        if key in table
    }
    _check_lengths("orientations", arrays["orientations"], _ROUNDING)
    if len(np.unique(arrays["ids"])) != len(arrays["ids"]):
        raise ValueError("ids: one comes twice")
    _check_lives(arrays, counts["p"])
    if "before" in table:
        _check_before(arrays)

    # Triangles have vertices of their own body.
    if np.any(bad := (counts["t"] == 0) & np.isfinite(arrays["masses"])):
        raise ValueError(f"masses: {arrays['masses'][bad][0]}, must be infinite without triangles")
    triangles, own = arrays["triangles"], np.repeat(counts["v"], counts["t"])
    if np.any(triangles >= own[:, None]):
        raise ValueError("triangles: a vertex that its body does not have")
    if "paths" in table:
        for name, key in (("c", "colours"), ("n", "normals")):
            if np.any((counts[name] != 0) & (counts[name] != counts["t"])):
                raise ValueError(f"{key}: not as many rows as triangles, or none, for each body")
        normals = arrays["normals"].reshape(-1, 3)
        _check_lengths("normals", normals[np.any(normals != 0.0, axis=1)], _NORMAL_ROUNDING)


def _body_rows(ids: tuple[int, ...]) -> dict[str, int]:
    """How many rows arrays have by the letters of the table, as far as those of ids say it."""
    count = ids[0] if len(ids) == 1 else 0
    return {"b": count, "b + 1": count + 1}


def _check_shape(
    key: str, shape: tuple[int, ...], dtype: np.dtype[Any], rule: _Rule, rows: dict[str, int]
) -> None:
    fits = dtype.kind in rule.kind and len(shape) == len(rule.shape)
    # The first array with some rows says how many there are.
    fits = fits and all(
        size == (rows.setdefault(wanted, size) if isinstance(wanted, str) else wanted)
        for size, wanted in zip(shape, rule.shape, strict=True)
    )
    if not fits:
        sizes = (rows.get(size, size) if isinstance(size, str) else size for size in rule.shape)
        wanted = ", ".join(map(str, sizes))
        kind = {"iu": "whole numbers", "f": "numbers", "b": "true or false", "U": "text"}[rule.kind]
        raise ValueError(f"{key}: {shape} of {dtype}, must be ({wanted}) of {kind}")


def _check_array(key: str, array: Array, rule: _Rule, rows: dict[str, int]) -> None:
    _check_shape(key, array.shape, array.dtype, rule, rows)
    if not np.all(good := rule.holds(array)):
        value = array[~good].ravel()[0] if array.ndim else array[()]
        shown = value if array.dtype.kind != "U" else f"{value[:40]!r}"
        raise ValueError(f"{key}: {shown}, must be {rule.says}")


def _shared_out(key: str, array: Array, last: int) -> npt.NDArray[np.int64]:
    """How many rows each body has."""
    ends = array.astype(np.int64)
    if len(ends) == 0 or ends[0] != 0 or ends[-1] != last or np.any(ends[1:] < ends[:-1]):
        raise ValueError(f"{key}: must ascend from 0 to {last}")
    counts: npt.NDArray[np.int64] = np.diff(ends)
    return counts


def _check_lengths(key: str, vectors: Array, rounding: float) -> None:
    lengths = np.linalg.norm(vectors, axis=1)
    if np.any(bad := np.abs(lengths - 1.0) > rounding):
        raise ValueError(f"{key}: one of length {lengths[bad][0]:g}, must be 1")


def _check_before(arrays: Arrays) -> None:
    """Each row is whole, or all NaN; since format 5 it is there for all that broke off while the
    recording ran."""
    before = arrays["before"]
    is_none: Array = np.all(np.isnan(before), axis=1)
    if np.any(bad := np.isnan(before[~is_none])):
        value = before[~is_none][bad][0]
        raise ValueError(f"before: {value}, must be finite, or all of its row NaN")
    _check_lengths("before", before[~is_none][:, 3:], _ROUNDING)
    broke_off = (arrays["parents"] >= 0) & (arrays["birth_frames"] > 0)
    wrong = is_none == broke_off
    if arrays["format"] >= 5 and np.any(wrong):
        body = arrays["ids"][wrong][0]
        what = "NaN" if is_none[wrong][0] else "finite"
        rule = "finite for what broke off, else NaN"
        raise ValueError(f"before: {what} for the body {body}, must be {rule}")


def _check_lives(arrays: Arrays, poses: npt.NDArray[np.int64]) -> None:
    """Each body is there for a frame or more, and has a pose for each of them."""
    last = int(arrays["frames"])
    births = arrays["birth_frames"].astype(np.int64)
    deaths = arrays["death_frames"].astype(np.int64)
    ends = np.where(deaths == -1, last + 1, deaths)
    if np.any(bad := births > last):
        raise ValueError(f"birth_frames: {births[bad][0]}, must be 0 to {last}")
    if np.any(bad := (ends <= births) | (ends > last + 1)):
        rule = f"-1 or after the birth, and at most {last}"
        raise ValueError(f"death_frames: {deaths[bad][0]}, must be {rule}")
    if np.any(poses != ends - births):
        raise ValueError("pose_offsets: must have a row for each frame of a life")


def check_family(arrays: Arrays, reports: list[Any]) -> None:
    """`ValueError` unless each parent is a body, or a fragment of the reports that no frame shows,
    and each source the first of its line."""
    ids = arrays["ids"].tolist()
    births = dict(zip(ids, arrays["birth_frames"].tolist(), strict=True))
    # Those of fragments that broke again before a frame showed them are in the reports alone.
    parent_of: dict[int, int] = {
        fragment: fracture["body"]
        for report in reports
        for fracture in report.get("fractures", [])
        for fragment in fracture["fragments"]
    }
    for id, parent in zip(ids, arrays["parents"].tolist(), strict=True):
        if reports and births[id] > 0 and parent_of.get(id) != parent:
            raise ValueError(f"parents: {parent} of the body {id}, must be that of the reports")
        if parent >= 0:
            parent_of[id] = parent
    # A recording may begin after a break, also one by hand of which the first report tells: only
    # its first bodies have parents before it.
    begins_late = not reports or reports[0]["frame"] > 1
    broken = {fracture["body"] for report in reports[:1] for fracture in report["fractures"]}
    for id, source in zip(ids, arrays["sources"].tolist(), strict=True):
        line = [id]
        while (parent := parent_of.get(line[-1])) is not None and len(line) <= len(parent_of):
            line.append(parent)
        shown = [births[body] for body in line if body in births]
        is_first = births[id] == 0 and (begins_late or line[-1] in broken)
        is_known = line[-1] in births or is_first
        ages = zip(shown, shown[1:], strict=False)
        if not is_known or any(younger <= older for younger, older in ages):
            raise ValueError(f"parents: {line[1]} of the body {id}, must be an older body, or -1")
        if source != line[-1]:
            rule = f"{line[-1]}, the first of its parents"
            raise ValueError(f"sources: {source} of the body {id}, must be {rule}")
