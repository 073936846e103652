"""Damaged caches are refused in one sentence, without much memory."""

import io
import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from frangible.cli import main
from frangible.errors import CacheError
from frangible.io.cache import read_npz, write_npz
from pxr import Usd


def changed(scripted: Recording, path: Path, **changes: Any) -> str:
    """A cache with some arrays changed; `None` leaves one out."""
    write_npz(scripted, str(path))
    with np.load(path) as arrays:
        held = {key: arrays[key].copy() for key in arrays}
    for key, change in changes.items():
        if change is None:
            del held[key]
        else:
            held[key] = change(held[key]) if callable(change) else np.array(change)
    np.savez_compressed(path, **held)
    return str(path)


def one(index: Any, value: Any) -> Callable[[Any], Any]:
    """Changes one entry."""

    def change(array: Any) -> Any:
        array[index] = value
        return array

    return change


def test_an_undamaged_cache_is_read(scripted: Recording, tmp_path: Path) -> None:
    assert len(read_npz(changed(scripted, tmp_path / "a.npz")).bodies) == len(scripted.bodies)


@pytest.mark.parametrize(
    ("key", "change", "sentence"),
    [
        ("frames", -1, "frames: -1, must be from 0 to 2147483647"),
        ("frames", 10**12, "frames: 1000000000000, must be from 0 to 2147483647"),
        ("frames", 1.5, r"frames: \(\) of float64"),
        ("fps", float("nan"), "fps: nan, must be from 0.001 to 1e\\+06"),
        ("ids", one(0, 5), "ids: one comes twice"),
        ("birth_frames", one(1, -3), "birth_frames: -3, must be from 0 to 2147483647"),
        ("birth_frames", one(-1, 2**20), "birth_frames: 1048576, must be 0 to 6"),
        ("death_frames", one(1, 0), "death_frames: 0, must be -1 or after the birth"),
        ("death_frames", one(1, -7), "death_frames: -7, must be"),
        ("masses", one(0, float("nan")), "masses: nan, must be from 1e-30 to 1e"),
        ("masses", one(1, -1.0), "masses: -1.0, must be from 1e-30 to 1e"),
        ("vertices", one((3, 1), float("inf")), "vertices: inf, must be from -1e"),
        ("positions", one((0, 0), float("nan")), "positions: nan, must be from -1e"),
        ("orientations", one(0, 0.0), "orientations: one of length 0, must be 1"),
        ("triangles", one((0, 0), 8), "triangles: a vertex that its body does not have"),
        ("triangles", lambda array: array.astype(float), r"triangles: .* of float64"),
        ("vertex_offsets", one(1, 2**40), "vertex_offsets: must ascend from 0 to"),
        ("vertex_offsets", one(1, -4), "vertex_offsets: -4, must be from 0 to"),
        ("pose_offsets", one(1, 3), "pose_offsets: must have a row for each frame of a life"),
        ("names", lambda array: array[:-1], r"names: \(4,\)"),
        ("interior", lambda array: array[:-1], "interior: "),
        ("material", lambda array: array[:-1], "material: "),
        ("reports", "{}", "reports: must be a list"),
        ("reports", "[1]", "reports: must be a list"),
        ("reports", "[[[", "is not a readable .npz cache"),
        ("materials", "[]", "is not a readable .npz cache"),
        ("sources", None, "has no key 'sources'"),
        ("format", "x", "is not a readable .npz cache"),
        ("before", one((2, 0), np.inf), "before: inf, must be at most 1e"),
        ("before", one((2, 0), np.nan), "before: nan, must be finite, or all of its row NaN"),
        ("before", one(2, np.nan), "before: NaN for the body 2, must be finite for what broke off"),
        ("before", one(0, [0, 0, 0, 0, 0, 0, 1]), "before: finite for the body 0, must be"),
        ("before", None, "has no key 'before'"),
        ("volumes", None, "has no key 'volumes'"),
        ("volumes", one(1, -1.0), "volumes: -1.0, must be from 0 to 2e.18, or NaN"),
        ("paths", None, "has no key 'paths'"),
        ("paths", lambda paths: np.array(["[1]"] * len(paths)), r"paths: .\[1\]., must be a list"),
        ("image_offsets", [0, 1], "image_offsets: must ascend from 0 to 0"),
        ("image_offsets", [0, 0], "image_offsets: 2, must be one more than images"),
        ("material", one(-1, 2**31 - 1), "material: 2147483647, must be below 0"),
        ("material", one(0, -2), "material: -2, must be from -1 to"),
        ("parents", one(2, 2**63 - 1), "parents: 9223372036854775807 of the body 2"),
        ("parents", one(0, 2**63 - 1), "parents: 9223372036854775807 of the body 0"),
        ("parents", one(1, 1), "parents: 1 of the body 1, must be an older body"),
        ("sources", one(2, 2), "sources: 2 of the body 2, must be 1, the first of its parents"),
        ("frames", 2**63 - 1, "frames: 9223372036854775807, must be from 0 to 2147483647"),
        ("looks", one(0, "g"), "looks: 'g', must be empty or one of glass, "),
        ("masses", one(0, 1e301), "masses: 1e.301, must be from 1e-30"),
        ("reports", '[{"time": NaN}]', "JSON holds NaN"),
        ("before", one((2, 6), 3.0), "before: one of length 3"),
    ],
)
def test_what_breaks_a_rule_is_named(
    scripted: Recording, tmp_path: Path, key: str, change: Any, sentence: str
) -> None:
    path = changed(scripted, tmp_path / "a.npz", **{key: change})
    with pytest.raises(CacheError, match=sentence) as error:
        read_npz(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


#: What damage makes of one entry.
DAMAGE = (-1, 2**31 - 1, 2**63 - 1, float("nan"), float("inf"), -1e300)
#: Arrays whose entries may be any of these numbers, within a rule of their own.
FREE = {"vertices", "coordinates", "positions", "before", "orientations", "volumes"}


@pytest.mark.parametrize("place", [0, 1, 2])
def test_each_entry_of_each_array_is_read_in_range_or_not_at_all(
    scripted: Recording, tmp_path: Path, place: int
) -> None:
    write_npz(scripted, str(tmp_path / "whole.npz"))
    with np.load(tmp_path / "whole.npz") as arrays:
        held = {key: arrays[key].copy() for key in arrays}
    taken = set()
    for key, array in held.items():
        if array.dtype.kind in "Ub" or array.size == 0:
            continue
        for value in DAMAGE:
            kind = np.int64 if isinstance(value, int) else np.float64
            other = array.astype(kind if array.dtype.kind in "iu" else np.float64)
            other.ravel()[(0, array.size // 2, array.size - 1)[place]] = value
            if np.array_equal(other, array, equal_nan=True):
                continue
            path = tmp_path / "a.npz"
            np.savez(path, **{**held, key: other})
            try:
                read_npz(str(path))
                taken.add((key, value))
            except CacheError as error:
                assert re.search(r"cache \(\w+: ", str(error)), error
    # A coordinate may be -1, and a body 2**31 m away.
    others = {key for key, _ in taken} - FREE - {"masses", "material"}
    assert not others, others
    allowed = {
        "material": {-1},
        "masses": {2**31 - 1, 2**63 - 1, float("inf")},
        "volumes": {2**31 - 1, DAMAGE[3]},
    }
    assert all(value in allowed.get(key, {-1, 2**31 - 1}) for key, value in taken), taken


def with_header(path: Path, shape: tuple[int, ...], content: bytes, descr: str = "<f8") -> str:
    """A cache with an array of a shape that its bytes may not have."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": descr, "fortran_order": False, "shape": shape}
    )
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("more.npy", header.getvalue() + content)
    return str(path)


#: A child that may have half a gigabyte more than Python takes.
SMALL = (
    "import resource, sys; from frangible.cli import main; "
    "resource.setrlimit(resource.RLIMIT_AS, ({0}, {0})); sys.exit(main(sys.argv[1:]))"
)


@pytest.mark.parametrize(
    ("shape", "content", "descr"),
    [
        ((10**10,), b"12345678", "<f8"),
        ((2**40, 2**40), b"", "<f8"),
        ((3,), b"", "|O"),
        ((10**10,), b"", "<U0"),
        ((1,), b"1", "<f8"),
    ],
)
def test_a_count_without_its_bytes_takes_no_memory(
    scripted: Recording, tmp_path: Path, shape: tuple[int, ...], content: bytes, descr: str
) -> None:
    path = with_header(Path(changed(scripted, tmp_path / "a.npz")), shape, content, descr)
    with pytest.raises(CacheError, match="is not a readable .npz cache .more has not the "):
        read_npz(path)


def test_a_bomb_is_not_unpacked(scripted: Recording, tmp_path: Path) -> None:
    path = changed(scripted, tmp_path / "a.npz")
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("more.npy", "w", force_zip64=True) as file,
    ):
        for _ in range(2049):
            file.write(bytes(2**20))
    done = subprocess.run(
        [sys.executable, "-c", SMALL.format(2 << 30), "info", path],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (
        done.returncode == 2
        and "must be at most 2147483648" in done.stderr
        and len(done.stderr.splitlines()) == 1
    )


def test_a_plot_of_reports_without_books_is_one_sentence(
    scripted: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reports = [{**report, "energy": 1} for report in scripted.reports]
    path = changed(scripted, tmp_path / "a.npz", reports=json.dumps(reports))
    assert main(["plot", path, "--out", str(tmp_path / "a.png")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not a readable energy report" in line


@pytest.mark.parametrize("ending", ["usda", "usdc"])
def test_a_cache_in_usd_says_so_itself(
    scripted: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path = str(tmp_path / f"a.{ending}")
    scripted.save(path)
    assert main(["info", path]) == 0
    assert "frames          6" in capsys.readouterr().out
    # Damaged.
    stage = Usd.Stage.Open(path)
    for frames in (-4.0, 2.5, float("inf")):
        stage.GetRootLayer().endTimeCode = frames
        stage.Save()
        assert main(["info", path]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "must be a whole number and a rate > 0" in line
    # Somebody else's.
    stage.GetRootLayer().customLayerData = {}
    stage.Save()
    assert main(["info", path]) == 0
    assert "volume_m3" in capsys.readouterr().out
