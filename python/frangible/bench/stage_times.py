"""``frangible bench``: how long the stages of a frame take, how much memory a piece, and what
stands."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any

from .. import _frangible
from .run_process import LAST_FRAMES, Request, run_apart
from .summary import Summary

#: What is measured unless somebody says what: the large piles, and small shots.
SHOTS = (
    "pile-spread",
    "pile-deep",
    "pile-table",
    "bricks",
    "bricks-still",
    "wall",
    "pillar",
    "stack",
)

#: Where tables go, unless somebody says where.
RESULTS = os.path.join("bench", "results")

#: Name of the row for whole frames.
FRAME = "frame"

COLUMNS = (
    "date", "shot", "method", "threads", "frames", "pieces", "stage", "last_median_ms",
    "last_p95_ms", "last_max_ms", "all_median_ms", "all_p95_ms", "all_max_ms", "peak_memory_MiB",
    "memory_per_piece_KiB", "standing", "median_height_m",
)  # fmt: skip


def shots_to_bench(name: str | None) -> list[str]:
    """The names that an argument stands for: a shot, ``all`` of those that need no mesh, or
    `SHOTS`; `BuildError` for an unknown one."""
    if name is None:
        return list(SHOTS)
    if name == "all":
        return [shot for shot, _ in _frangible.shots() if not _needs_mesh(shot)]
    # Says why if it cannot be run.
    _frangible.shot_scene(name)
    return [name]


def _needs_mesh(shot: str) -> bool:
    try:
        _frangible.shot_scene(shot)
    except _frangible.BuildError:
        return True
    return False


def bench(
    shots: Sequence[str],
    *,
    frames: int | None,
    threads: Sequence[int],
    folder: str,
    on_done: Callable[[Summary], None],
) -> None:
    """Measure shots one after the other, on each number of threads, in processes of their own;
    append them to a table in a folder."""
    os.makedirs(folder, exist_ok=True)
    for shot in shots:
        count = _frangible.shot_frames(shot) if frames is None else frames
        for number in threads:
            summary = run_apart(Request(shot, count, number))
            append_rows(os.path.join(folder, "stages.csv"), COLUMNS, stage_rows(summary))
            on_done(summary)


def append_rows(path: str, columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Append to a table, with a head if it is new."""
    is_new = not os.path.exists(path) or os.path.getsize(path) == 0
    with open(path, "a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns)
        if is_new:
            writer.writeheader()
        writer.writerows(rows)


def today() -> str:
    """The date, for tables."""
    return datetime.now(UTC).date().isoformat()


def stage_rows(summary: Summary) -> list[dict[str, Any]]:
    """A row for every stage and one for whole frames, as `COLUMNS` names them."""
    common = {
        "date": today(),
        **{key: summary[key] for key in ("shot", "method", "threads", "frames", "pieces")},
        "peak_memory_MiB": round(summary["peak_memory_MiB"], 1),
        "memory_per_piece_KiB": round(summary["memory_per_piece_KiB"], 2),
        "standing": round(summary["standing"], 4),
        "median_height_m": round(summary["median_height_m"], 4),
    }
    return [
        common
        | {"stage": stage}
        | {
            f"{span}_{key}_ms": round(times[key], 3)
            for span, times in spans
            for key in ("median", "p95", "max")
        }
        for stage, spans in _by_stage(summary)
    ]


def describe_bench(summary: Summary) -> str:
    """The table for people."""
    frames = summary["frames"]
    last = f"last {min(frames, LAST_FRAMES)} frames"
    threads = (
        "a thread for every processor"
        if summary["threads"] == 0
        else _count(summary["threads"], "thread")
    )
    lines = [
        f"{summary['shot']}: {_count(summary['pieces'], 'piece')}, {_count(frames, 'frame')} of "
        f"{summary['dt'] * 1e3:.4g} ms"
        f" ({summary['method']} method), {threads}",
        f"  {'ms':18}{last:>30}{'all frames':>30}",
        f"  {'stage':18}" + 2 * f"{'median':>10}{'p95':>10}{'max':>10}",
    ]
    for stage, spans in _by_stage(summary):
        lines.append(
            f"  {stage:18}"
            + "".join(
                f"{times[key]:10.3f}" for _, times in spans for key in ("median", "p95", "max")
            )
        )
    share, height = 100.0 * summary["standing"], summary["median_height_m"]
    lines.append(
        f"  stands  {share:.3g} % of the pieces where they stood, median height {height:.4g} m"
    )
    lines.append(
        f"  memory  {summary['peak_memory_MiB']:.4g} MiB at most, "
        f"{summary['memory_per_piece_KiB']:.3g} KiB a piece"
    )
    return "\n".join(lines)


def _by_stage(summary: Summary) -> list[tuple[str, list[tuple[str, dict[str, float]]]]]:
    """For every stage, then for whole frames: times of the last frames and of all."""
    rows = [
        (stage, [("last", times), ("all", summary["stages_all_ms"][stage])])
        for stage, times in summary["stages_last_ms"].items()
    ]
    return [
        *rows,
        (FRAME, [("last", summary["ms_per_frame"]), ("all", summary["ms_per_frame_all"])]),
    ]


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
