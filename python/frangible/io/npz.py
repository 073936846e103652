"""``.npz`` files, written without holding what goes into them."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
import numpy.typing as npt

#: The date of all members: equal recordings are equal files. The earliest that an archive can say.
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Arrays that are written as one: the rows of each after those of the one before."""

    parts: Sequence[npt.NDArray[Any]]
    #: Of a row.
    shape: tuple[int, ...]
    dtype: npt.DTypeLike


@dataclass(frozen=True, slots=True, eq=False)
class Text:
    """A text that is written as an array () without being held; asked for its pieces twice."""

    pieces: Callable[[], Iterator[str]]

    def write(self, out: IO[bytes]) -> None:
        """As NumPy writes an array of one text: its header has the length."""
        length = sum(len(piece) for piece in self.pieces())
        header = {"descr": f"<U{length}", "fortran_order": False, "shape": ()}
        np.lib.format.write_array_header_1_0(out, header)
        for piece in self.pieces():
            out.write(piece.encode("utf-32-le"))


def write_arrays(path: str, arrays: Mapping[str, npt.NDArray[Any] | Parts | Text]) -> None:
    """Write compressed arrays, part by part."""
    with (
        open(path, "wb") as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", _DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(member, "w", force_zip64=True) as out:
                if isinstance(array, Text):
                    array.write(out)
                    continue
                if not isinstance(array, Parts):
                    np.lib.format.write_array(out, array, allow_pickle=False)
                    continue
                count = sum(len(part) for part in array.parts)
                header = {
                    "descr": np.lib.format.dtype_to_descr(np.dtype(array.dtype)),
                    "fortran_order": False,
                    "shape": (count, *array.shape),
                }
                np.lib.format.write_array_header_1_0(out, header)
                for part in array.parts:
                    out.write(np.ascontiguousarray(part, array.dtype).tobytes())
