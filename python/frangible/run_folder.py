"""A run on a disk while it is simulated: a folder that grows with each frame, from which a run that
was stopped goes on.

=============== ====================================================================================
file            content
=============== ====================================================================================
``frames``      records (`journal`): ``run`` first, then for each frame a ``body`` for each that it
                shows for the first time, and the ``frame``
``checkpoint``  a record, ``checkpoint``: a world (`World.snapshot`), and the length of ``frames``
                then; another one takes its place whole
``lock``        empty; the process that writes the folder has it locked (`kept_folder`)
=============== ====================================================================================
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import CacheError
from .journal import Array, Journal, read_journal, record_bytes
from .kept_folder import CHECKPOINT, NEW_CHECKPOINT, KeptFolder
from .kept_frames import KeptFrames, journal_of, known_frames
from .recorder import Known, Poses, SeenBody
from .recording import Float64
from .report import StepReport

if TYPE_CHECKING:
    from ._frangible import World

#: What ends the names of such folders.
ENDING = ".part"

#: Writing checkpoints takes at most this part of the time of a run: the next one waits nineteen
#: times as long as the last one took. Of `rain-100` one takes 40 ms, and a frame 130.
_SHARE = 0.05


class RunFolder(KeptFrames):
    """Frames that are kept on a disk: a `Store`. Memory does not grow with their number."""

    def __init__(self, folder: KeptFolder, journal: Journal, known: Known) -> None:
        super().__init__(folder.path, journal.length)
        self.known = known
        self._folder = folder
        self._journal = journal
        # Of the last checkpoint: how long it took [s], and when it was there.
        self._checkpoint_took, self._checkpoint_at = 0.0, time.perf_counter()
        # Of the frame to come.
        self.step_ms = 0.0
        self.depths: Float64 = np.zeros(0)

    @staticmethod
    def create(path: str, identity: str, fields: Mapping[str, Any]) -> RunFolder:
        """A new folder for a run of this identity, in the place of an old one. `CacheError` if
        something else is there, or another process writes it."""
        kept = KeptFolder(path, is_new=True)
        kept.clear()
        try:
            folder = RunFolder(kept, Journal(journal_of(path)), Known())
            folder._append("run", {**fields, "identity": identity}, {})
        except OSError:
            kept.remove()
            raise
        return folder

    def add_body(self, body: SeenBody) -> None:
        """See `Store`."""
        vertices, triangles, interior, coordinates = body.surface
        arrays = {
            "vertices": vertices,
            "triangles": triangles,
            "interior": interior,
            "coordinates": coordinates,
        }
        if body.before is not None:
            arrays["before"] = body.before
        fields = {
            "id": body.id,
            "name": body.name,
            "mass": body.mass,
            "volume": body.volume,
            "look": body.look,
            "parent": body.parent,
            "material_frame": body.material_frame,
        }
        self._append("body", fields, arrays)

    def add_frame(self, poses: Poses, report: StepReport | None) -> None:
        """See `Store`."""
        arrays = {
            "ids": poses.ids,
            "positions": poses.positions,
            "orientations": poses.orientations,
            "depths": self.depths,
        }
        self._append("frame", {"report": report, "step_ms": self.step_ms}, arrays)

    def checkpoint_when_due(self, world: World) -> None:
        """Write a checkpoint if that costs little of the run's time."""
        waited = time.perf_counter() - self._checkpoint_at
        if waited >= self._checkpoint_took * (1.0 / _SHARE - 1.0):
            self.checkpoint(world)

    def checkpoint(self, world: World) -> None:
        """Write a checkpoint of the world after the last frame."""
        begin = time.perf_counter()
        self._journal.sync()
        path = os.path.join(self.path, CHECKPOINT)
        new = os.path.join(self.path, NEW_CHECKPOINT)
        fields = {"length": self._journal.length, "frame": self.known.steps}
        arrays = {"world": np.frombuffer(world.snapshot(), np.uint8)}
        try:
            with open(new, "wb") as file:
                file.write(record_bytes("checkpoint", fields, arrays))
                file.flush()
                os.fsync(file.fileno())
            os.replace(new, path)
        except OSError:
            with suppress(OSError):
                os.unlink(new)
            raise
        self._checkpoint_at = time.perf_counter()
        self._checkpoint_took = self._checkpoint_at - begin

    def _append(self, kind: str, fields: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
        self._journal.append(kind, fields, arrays)
        self.length = self._journal.length

    def close(self) -> None:
        """Nothing more is added."""
        self._journal.close()
        self._folder.let_go()

    def remove(self) -> None:
        """The run is in its outputs: the folder is not needed any more."""
        self._journal.close()
        self._folder.remove()


def resume_folder(path: str, identity: str) -> tuple[RunFolder, bytes] | None:
    """A folder to go on with, and the snapshot of its world; `None` if it has no checkpoint yet.

    `CacheError` if it is of another run, or damaged, or another process writes it.
    """
    if not os.path.isdir(path):
        return None
    folder = KeptFolder(path, is_new=False)
    try:
        found = _resumed(folder, identity)
    except BaseException:
        folder.let_go()
        raise
    if found is None:
        folder.let_go()
    return found


def _resumed(folder: KeptFolder, identity: str) -> tuple[RunFolder, bytes] | None:
    path, journal = folder.path, journal_of(folder.path)
    first = next(read_journal(journal), None) if os.path.isfile(journal) else None
    if first is None:
        return None
    if first.kind != "run" or first.fields.get("identity") != identity:
        raise CacheError(
            f"{path}: keeps a run of another scene, must be of this one, with the same options"
        )
    checkpoint = os.path.join(path, CHECKPOINT)
    if not os.path.exists(checkpoint):
        return None
    kept = next(read_journal(checkpoint), None)
    if kept is None or kept.kind != "checkpoint":
        raise CacheError(f"{checkpoint}: is damaged")
    length = int(kept.fields["length"])
    known = known_frames(journal, length)
    if known.steps != kept.fields["frame"]:
        raise CacheError(f"{journal}: is damaged before frame {kept.fields['frame']}")
    return RunFolder(folder, Journal(journal, length), known), kept.arrays["world"].tobytes()
