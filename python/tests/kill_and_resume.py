"""A run that is killed at random places goes on to the same bits: for tests, and as a command,

    python python/tests/kill_and_resume.py rain-100 10
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from frangible import Recording
from frangible.kept_frames import steps_kept


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "frangible", *arguments]


def facts(recording: Recording) -> list[object]:
    """All of a recording, but for times."""
    reports = [{**report, "stages": []} for report in recording.reports]
    bodies = [
        [
            *(body.id, body.name, body.parent, body.source, body.birth_frame, body.death_frame),
            *(body.mass, body.volume, body.look),
            *(
                array.tobytes()
                for array in (body.vertices, body.triangles, body.interior, body.coordinates)
            ),
            *(body.positions.tobytes(), body.orientations.tobytes()),
            None if body.before is None else body.before.tobytes(),
        ]
        for body in recording.bodies
    ]
    return [recording.shot, recording.fps, recording.frames, reports, bodies]


def killed(path: Path, frames: int, arguments: list[str]) -> int:
    """Start a run, kill it once it keeps so many frames; how many it kept."""
    with subprocess.Popen(command(*arguments, "--out", str(path)), stderr=subprocess.PIPE) as run:
        journal = f"{path}.part/frames"
        length = 0
        while run.poll() is None:
            if os.path.exists(journal) and os.path.getsize(journal) != length:
                length = os.path.getsize(journal)
                if steps_kept(f"{path}.part") >= frames:
                    run.send_signal(signal.SIGKILL)
                    break
            time.sleep(0.002)
    return steps_kept(f"{path}.part")


def main(shot: str, kills: int) -> None:
    """Compare a run that is killed so many times with one that is not."""
    with tempfile.TemporaryDirectory() as folder:
        whole, path = Path(folder, "whole.npz"), Path(folder, "killed.npz")
        ran = ["run", shot, "--quiet", "--json"]
        first = subprocess.run(command(*ran, "--out", str(whole)), check=True, capture_output=True)
        expected = Recording.load(whole)
        places = sorted(random.sample(range(1, expected.frames), kills))
        for number, frames in enumerate(places):
            kept = killed(path, frames, [*ran, *(["--resume"] if number else [])])
            print(f"killed at frame {kept}", flush=True)
        resumed = [*ran, "--resume", "--out", str(path)]
        last = subprocess.run(command(*resumed), check=True, capture_output=True)
        hashes = [text.split(b'"state_hash": ')[1][:18] for text in (first.stdout, last.stdout)]
        assert hashes[0] == hashes[1], hashes
        assert facts(Recording.load(path)) == facts(expected)
        print(f"{shot}: {kills} kills, state hash {hashes[0].decode()} and the cache are the same")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
