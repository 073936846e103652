"""The frames that a run left on a disk, in records (`journal`).

``run`` comes first; then for each frame a ``body`` for each that it shows for the first time, and
the ``frame``.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import IO, Any

import numpy as np

from .errors import CacheError
from .journal import Record, read_journal
from .kept_folder import JOURNAL
from .kept_reports import KeptReports
from .recorder import Known, Path, Poses, SeenBody, assemble, rows_of_bodies
from .recording import Float64, Recording, without_sign_flips
from .report import StepReport

#: Poses are sorted by body block by block: of so many frames and so many rows at least. A block is
#: a piece of work for each of its bodies, 20 us, and a row takes 56 bytes, some times over.
_FRAMES, _ROWS = 32, 2**12


class KeptFrames:
    """`Frames` of a folder: nothing of them stays in memory."""

    def __init__(self, path: str, length: int) -> None:
        self.path = path
        #: Of the journal that is whole.
        self.length = length

    @property
    def journal(self) -> str:
        """The file of the records."""
        return journal_of(self.path)

    def bodies(self) -> Iterator[SeenBody]:
        """See `Frames`."""
        for record in self._records():
            if record.kind == "body":
                yield seen_body(record)

    def reports(self) -> Sequence[StepReport]:
        """See `Frames`."""
        return KeptReports(self.journal, self.length)

    def frames(self) -> Iterator[Record]:
        """The records of all frames."""
        return (record for record in self._records() if record.kind == "frame")

    def fields(self) -> dict[str, Any]:
        """Those that the folder was made with."""
        return next(self._records()).fields

    def paths(self) -> dict[int, Path]:
        """See `Frames`; views of a file without a name beside the others."""
        # Where the rows of each body begin.
        births: dict[int, int] = {}
        counts: dict[int, int] = {}
        for frame, record in enumerate(self.frames()):
            for body_id in record.arrays["ids"].tolist():
                births.setdefault(body_id, frame)
                counts[body_id] = counts.get(body_id, 0) + 1
        begins = dict(zip(counts, np.cumsum([0, *counts.values()]).tolist(), strict=False))
        count = sum(counts.values())
        if count == 0:
            return {}
        written = dict.fromkeys(counts, 0)
        last: dict[int, Float64] = {}

        with self._nameless_file() as file:
            file.truncate(56 * count)

            def sort_in(frames: list[Poses]) -> None:
                for body_id, _, positions, orientations in rows_of_bodies(frames):
                    before = last.get(body_id, orientations[0])
                    turned = without_sign_flips(np.vstack([before, orientations]))[1:]
                    last[body_id] = turned[-1]
                    row = begins[body_id] + written[body_id]
                    written[body_id] += len(positions)
                    os.pwrite(file.fileno(), positions.tobytes(), 24 * row)
                    os.pwrite(file.fileno(), turned.tobytes(), 24 * count + 32 * row)

            block: list[Poses] = []
            rows = 0
            for record in self.frames():
                block.append(poses_of(record))
                rows += len(block[-1].ids)
                if rows >= _ROWS and len(block) >= _FRAMES:
                    sort_in(block)
                    block, rows = [], 0
            if block:
                sort_in(block)
            numbers = np.memmap(file, np.float64, "r")
        positions = numbers[: 3 * count].reshape(count, 3)
        orientations = numbers[3 * count :].reshape(count, 4)
        return {
            body_id: Path(
                births[body_id],
                positions[begin : begin + counts[body_id]],
                orientations[begin : begin + counts[body_id]],
            )
            for body_id, begin in begins.items()
        }

    def _records(self) -> Iterator[Record]:
        return read_journal(self.journal, self.length)

    def _nameless_file(self) -> IO[bytes]:
        # Beside the others, where there is room for them, or else where one may write.
        folder = self.path if os.access(self.path, os.W_OK) else None
        return tempfile.TemporaryFile(dir=folder)


def journal_of(path: str) -> str:
    """The file of a folder's records."""
    return os.path.join(path, JOURNAL)


def steps_kept(path: str) -> int:
    """How many steps a folder keeps; 0 if it is none."""
    journal = journal_of(path)
    if not os.path.isfile(journal):
        return 0
    return max(0, sum(record.kind == "frame" for record in read_journal(journal)) - 1)


def read_folder(path: str) -> Recording:
    """What a run left that was stopped: all of its whole frames, without the looks of its scene."""
    journal = journal_of(path)
    first = next(read_journal(journal), None) if os.path.isfile(journal) else None
    if first is None or first.kind != "run":
        raise CacheError(f"{path}: is a folder, must be a file or the .part folder of a run")
    length = 0
    for record in read_journal(journal):
        # Bodies without their frame are not yet seen.
        length = record.end if record.kind == "frame" else length
    if length == 0:
        raise CacheError(f"{path}: keeps no frame")
    known = known_frames(journal, length)
    named = (first.fields["shot"], first.fields["method"], first.fields["fps"])
    recording = assemble(KeptFrames(path, length), known, {}, named)
    # The folder may go while the recording is used.
    return replace(recording, reports=list(recording.reports))


def known_frames(journal: str, length: int) -> Known:
    """What a recorder needs of the frames in the first ``length`` bytes."""
    known = Known()
    for record in read_journal(journal, length):
        if record.kind == "body":
            known.note_body(seen_body(record))
        elif record.kind == "frame":
            if record.fields["report"] is not None:
                known.note_fractures(record.fields["report"])
            known.note_frame(poses_of(record))
    return known


def poses_of(record: Record) -> Poses:
    """Of a ``frame``."""
    arrays = record.arrays
    return Poses(arrays["ids"], arrays["positions"], arrays["orientations"])


def seen_body(record: Record) -> SeenBody:
    """Of a ``body``."""
    fields, arrays = record.fields, record.arrays
    origin, turn = fields["material_frame"]
    return SeenBody(
        id=fields["id"],
        name=fields["name"],
        mass=fields["mass"],
        volume=fields["volume"],
        look=fields["look"],
        surface=(
            arrays["vertices"],
            arrays["triangles"],
            arrays["interior"],
            arrays["coordinates"],
        ),
        material_frame=(origin, turn),
        parent=fields["parent"],
        before=arrays.get("before"),
    )
