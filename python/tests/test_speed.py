"""The paper's frame rate, on one core."""

import resource
import subprocess
import sys

#: Frames per second of the wall in the paper, on one core.
PAPER = 15.0


def test_the_wall_runs_at_the_papers_rate_on_one_core() -> None:
    # Processor time, so that what else the machine does counts little; start-up and build are in
    # it.
    frames = 120
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [
        sys.executable,
        "-m",
        "frangible",
        "run",
        "wall",
        "--method",
        "paper",
        "--threads",
        "1",
        "--frames",
        str(frames),
    ]
    subprocess.run(command, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    assert frames / seconds > PAPER, f"{frames / seconds:.1f} frames per second"
