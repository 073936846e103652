"""Frames of a run as they are made, in chunks that a page plays."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol

from ..laid import Laid
from ..recorder import Known, Path, Poses, SeenBody, recorded_body, rows_of_bodies
from ..recording import Float32, Recording, without_sign_flips
from ..render.camera import frame_recording
from ..report import StepReport
from ..skin import Skin
from .page import ASPECT
from .page_data import Reel

#: A chunk goes out when that much time has passed since the last one [s]: what is seen is as late,
#: and a chunk costs as little of a run as a thousandth part of that.
_PATIENCE = 0.2
#: How long those who wait for chunks sleep before they look whether somebody hung up [s].
_NAP = 1.0


class Sink(Protocol):
    """Where chunks go."""

    def add(self, blob: bytes) -> None:
        """One more."""


class Chunks:
    """Blobs that grow in number, for any number of readers, each from the first one on."""

    def __init__(self) -> None:
        self._blobs: list[bytes] = []
        self._is_closed = False
        self._changed = threading.Condition()

    def add(self, blob: bytes) -> None:
        """One more."""
        with self._changed:
            self._blobs.append(blob)
            self._changed.notify_all()

    def close(self) -> None:
        """No more will come."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def follow(self) -> Iterator[bytes]:
        """All of them, as they come; empty ones while none comes."""
        number = 0
        while True:
            with self._changed:
                if number == len(self._blobs) and not self._is_closed:
                    self._changed.wait(_NAP)
                ready = self._blobs[number:]
                is_over = self._is_closed
            yield from ready or ([] if is_over else [b""])
            number += len(ready)
            if is_over and not ready:
                return


class LiveReel:
    """A `Store` that hands frames on in chunks, and keeps the last one."""

    def __init__(
        self, chunks: Sink, known: Known, skins: dict[int, Laid], named: tuple[str, str, float]
    ) -> None:
        """``known`` is the recorder's; ``skins`` are by the numbers of bodies; ``named`` by the
        shot, method and frames per second."""
        self._chunks, self._known, self._named = chunks, known, named
        self._skins = skins
        self._reel: Reel | None = None
        self._seen: dict[int, SeenBody] = {}
        self._new: list[int] = []
        self._frames: list[Poses] = []
        self._reports: list[StepReport] = []
        self._first = 0
        self._at = 0.0

    def add_body(self, body: SeenBody) -> None:
        """See `Store`."""
        self._seen[body.id] = body
        self._new.append(body.id)

    def add_frame(self, poses: Poses, report: StepReport | None) -> None:
        """See `Store`."""
        self._frames.append(poses)
        if report is not None:
            self._reports.append(report)

    @property
    def is_behind(self) -> bool:
        """Whether there are frames since the last chunk."""
        return len(self._frames) > 1

    def send_when_due(self) -> None:
        """Hand on what there is, if the last chunk is some time ago."""
        if time.monotonic() - self._at >= _PATIENCE:
            self.send()

    def send(self, *, is_last: bool = False) -> None:
        """Hand on all frames since the last chunk; ``is_last`` if no more will come."""
        recording = self._recording()
        if self._reel is None:
            self._reel = Reel(frame_recording(recording, ASPECT))
        pieces: list[bytes] = []
        self._reel.chunk(recording, self._first, pieces.append, is_last=is_last)
        self._chunks.add(b"".join(pieces))
        self._first += len(self._frames) - 1
        self._frames, self._reports, self._new = self._frames[-1:], [], []
        self._at = time.monotonic()

    def bodies(self) -> Iterator[SeenBody]:
        """See `Frames`."""
        return iter(self._seen.values())

    def reports(self) -> Sequence[StepReport]:
        """Of the frames since the last chunk."""
        return self._reports

    def paths(self) -> dict[int, Path]:
        """Of the frames since the last chunk, and of its last one."""
        return {
            body_id: Path(self._first + first, positions, without_sign_flips(orientations))
            for body_id, first, positions, orientations in rows_of_bodies(self._frames)
        }

    def _recording(self) -> Recording:
        """The frames since the last chunk, with the last one of that."""
        last = self._first + len(self._frames) - 1
        skins = self._laid()
        bodies = []
        for body_id, path in self.paths().items():
            body = recorded_body(self._seen[body_id], path, self._known, last, skins.get(body_id))
            # An earlier chunk showed how it came.
            was_shown = path.birth_frame == self._first
            bodies.append(replace(body, before=None) if was_shown else body)
        bodies.sort(key=lambda body: (body.birth_frame, body.id))
        shot, method, fps = self._named
        return Recording(shot, method, fps, last, bodies, self._reports)

    def _laid(self) -> dict[int, tuple[Skin, Float32]]:
        """Skins of the bodies that are new."""
        laid: dict[int, tuple[Skin, Float32]] = {}
        for number, skin in self._skins.items():
            source = self._known.first_ids[number]
            own = [one for one in self._new if self._known.source(one) == source]
            surfaces = [(self._seen[one].surface, self._seen[one].material_frame) for one in own]
            if surfaces:
                laid.update(zip(own, skin.lay_on(surfaces), strict=True))
        return laid
