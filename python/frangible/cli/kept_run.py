"""A run that is kept on a disk while it is simulated."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from .._frangible import World
from ..bench.run_process import moving_mass
from ..bench.summary import RunFigures
from ..errors import CacheError
from ..kept_folder import check_kept_folder
from ..kept_frames import steps_kept
from ..laid import Laid
from ..recorder import Recorder
from ..recording import Float64, Recording
from ..report import StepReport
from ..run_folder import ENDING, RunFolder, resume_folder
from .options import EXIT_FAILED
from .terminal import say


@dataclass(frozen=True, slots=True)
class Start:
    """A world before its first step."""

    bodies: int
    #: [kg]
    mass: float
    #: Kinetic and potential [J].
    energy: tuple[float, float]

    @staticmethod
    def of(world: World) -> Start:
        """As it is now."""
        return Start(len(world.ids), moving_mass(world), world.energy)


class KeptRun:
    """The folder of a run beside its first output, from the run's first frame until all outputs are
    written."""

    def __init__(self, outputs: Sequence[str], described: Sequence[Any]) -> None:
        """``described`` is all that decides what is simulated, and how it looks. `CacheError` if
        something else is where the run would be kept, or another process runs there."""
        text = json.dumps(described, sort_keys=True, default=str)
        self._identity = hashlib.sha256(text.encode()).hexdigest()
        # Beside a file or a folder: who may write a pipe may not write beside it.
        beside = [
            path
            for path in outputs
            if not os.path.exists(path) or os.path.isfile(path) or os.path.isdir(path)
        ]
        elsewhere = os.path.join(tempfile.gettempdir(), f"frangible-{self._identity[:16]}")
        self.path = (beside[0].rstrip("/") if beside else elsewhere) + ENDING
        check_kept_folder(self.path)
        self._folder: RunFolder | None = None
        self._recorder: Recorder | None = None
        self._named = ("", 0.0)

    def resume(self, frames: int) -> bytes | None:
        """The snapshot of the world to go on from; `None` if nothing is kept. `CacheError` if what
        is kept is of another run, or of more frames than are asked for."""
        found = resume_folder(self.path, self._identity)
        if found is None:
            say(f"frangible: {self.path}: keeps no run to go on with")
            return None
        self._folder, snapshot = found
        if self._folder.known.steps > frames:
            raise CacheError(
                f"--frames: {frames}, must be at least {self._folder.known.steps}, which "
                f"{self.path} keeps"
            )
        return snapshot

    def open(
        self,
        world: World,
        skins: dict[int, Laid],
        start: Start,
        figures: RunFigures,
        named: tuple[str, float],
    ) -> Start:
        """Begin to keep frames, or go on; ``figures`` get those of the frames that are kept
        already. Where the run began."""
        self._named = named
        if self._folder is None:
            if frames := steps_kept(self.path):
                said = f"replaces {frames} frames of a run that was stopped"
                say(f"frangible: {self.path}: {said}")
            shot, rate = named
            fields = {"shot": shot, "fps": rate, "method": world.method, "start": asdict(start)}
            self._folder = RunFolder.create(self.path, self._identity, fields)
        else:
            kept = self._folder.fields()["start"]
            kinetic, potential = kept["energy"]
            start = Start(kept["bodies"], kept["mass"], (kinetic, potential))
            for record in self._folder.frames():
                if record.fields["report"] is not None:
                    figures.add(record.fields["report"], record.fields["step_ms"])
                    figures.depths.add(record.arrays["depths"].copy())
        self._world = world
        self._recorder = Recorder(world, skins, self._folder, self._folder.known)
        return start

    def capture(self, report: StepReport, step_ms: float, depths: Float64) -> None:
        """Keep the state that a step led to."""
        if self._folder is None or self._recorder is None:
            return
        self._folder.step_ms, self._folder.depths = step_ms, depths
        self._recorder.capture(report)
        self._folder.checkpoint_when_due(self._world)

    def finish(self) -> Recording:
        """All frames, as views of files."""
        assert self._recorder is not None
        return self._recorder.finish(*self._named)

    def close(self, is_complete: bool) -> None:
        """Remove what is kept, if all outputs are written; else have it ready to go on with."""
        if self._folder is None:
            return
        if is_complete:
            self._folder.remove()
            return
        # An older checkpoint does, too.
        with suppress(OSError):
            self._folder.checkpoint(self._world)
        self._folder.close()

    def give_up(self, error: OSError) -> int:
        """Say in one sentence that the disk takes no more; the exit status."""
        frames = 0 if self._folder is None else self._folder.known.steps
        if self._folder is not None:
            if frames:
                self._folder.close()
            else:
                self._folder.remove()
        kept = f"; it keeps {frames} frames, and --resume goes on" if frames else ""
        said = f"{self.path}: {error.strerror or error}{kept}"
        say(f"frangible: {said}")
        return EXIT_FAILED
