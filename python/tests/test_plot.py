"""Plots of the books: every joule in the file is drawn, and the total lies under its bound."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import CacheError, OutputError, Recording
from frangible.cli import main
from frangible.render.energy_series import read_energy_series
from frangible.render.plot import draw
from matplotlib.axes import Axes


def report(frame: int, **energy: Any) -> Any:
    books = {"kinetic": 0.0, "potential": 0.0, "work": 0.0, "banked": 0.0, "gain": 0.0, **energy}
    momentum = {
        "linear": [frame, 0.0, 0.0],
        "angular": [0.0, 0.0, 2.0 * frame],
        "linear_error": 0.0,
        "angular_error": 1e-12,
    }
    return {
        "frame": frame,
        "time": 0.5 * frame,
        "energy": books,
        "momentum": momentum,
        "fractures": [],
        "quarantined": [],
    }


@pytest.fixture
def told(scripted: Recording) -> Recording:
    """Ten joules at first; six of work enter, of nine that are lost friction takes eight, and a
    body of two is taken out."""
    reports = [
        report(
            1,
            kinetic=14.0,
            potential=-2.0,
            work=6.0,
            gain=-4.0,
            causes={"friction": -4.0, "work": 6.0, "contact": 0.0},
        ),
        report(
            2,
            kinetic=8.0,
            potential=-1.0,
            gain=-4.0,
            banked=1.0,
            causes={"friction": -4.0, "work": 0.0, "contact": -1.0},
        ),
        report(
            3, kinetic=8.0, potential=-3.0, causes={"friction": 0.0, "work": 0.0, "contact": 0.0}
        ),
    ]
    reports[2]["quarantined"] = [1]
    reports[1]["fractures"] = [{}]
    return replace(scripted, frames=3, reports=reports)


def test_books_are_sums_over_the_frames(told: Recording) -> None:
    books = read_energy_series(told)
    assert books.times.tolist() == [0.5, 1.0, 1.5]
    assert books.potential.tolist() == [1.0, 2.0, 0.0]
    assert books.total.tolist() == [15.0, 10.0, 8.0]
    assert books.available.tolist() == [19.0, 19.0, 19.0]
    assert books.bank.tolist() == [0.0, 1.0, 1.0]
    assert {cause: change.tolist() for cause, change in books.causes.items()} == {
        "work": [6.0, 6.0, 6.0],
        "friction": [-4.0, -8.0, -8.0],
        "contact": [0.0, -1.0, -1.0],
        "taken out": [0.0, 0.0, -2.0],
    }
    assert next(iter(books.causes)) == "work"
    assert books.linear.tolist() == [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
    assert books.angular[:, 2].tolist() == [2.0, 4.0, 6.0]
    assert books.breaks.tolist() == [1.0]


def test_a_run_keeps_below_its_bound_and_every_cause_is_counted(wall: Recording) -> None:
    books = read_energy_series(wall)
    scale = books.available.max()
    assert np.all(books.total + books.bank <= books.available + 1e-9 * scale)
    # The wall broke, and lost energy that no line could hide.
    assert books.total[-1] < 0.9 * books.available[-1]
    start = books.available[0] - books.causes["work"][0]
    assert sum(books.causes.values()) == pytest.approx(books.total - start, abs=1e-9 * scale)


def lines(axis: Axes) -> dict[str, list[float]]:
    return {str(line.get_label()): np.asarray(line.get_ydata()).tolist() for line in axis.lines}


def test_a_figure_shows_what_the_books_say(told: Recording) -> None:
    figure = draw(told)
    energy, causes, linear, angular, drift = figure.axes
    assert figure.get_suptitle() == "slab, paper method, 24 frames per second"
    assert lines(energy)["total"] == [15.0, 10.0, 8.0]
    assert lines(energy)["bound: at first + work"] == [19.0, 19.0, 19.0]
    assert lines(energy)["kinetic"] == [14.0, 8.0, 8.0]
    assert "a body breaks" in lines(energy)
    assert lines(causes)["friction"] == [-4.0, -8.0, -8.0]
    assert lines(causes)["taken out"] == [0.0, 0.0, -2.0]
    assert lines(linear)["x"] == [1.0, 2.0, 3.0]
    assert lines(angular)["z"] == [2.0, 4.0, 6.0]
    assert lines(drift)["angular"] == [1e-12] * 3
    # Each panel says what it shows and in which unit.
    figure.draw_without_rendering()
    for axis, unit in ((energy, "J"), (causes, "J"), (linear, "N s"), (angular, "N m s")):
        assert axis.get_xlabel() == "time [s]"
        assert all(label.get_text().endswith(unit) for label in axis.get_yticklabels())
        assert axis.get_title(loc="left")


def test_what_never_mattered_is_named_and_not_drawn(told: Recording) -> None:
    for frame in told.reports:
        frame["energy"]["causes"]["contact"] = 0.0  # type: ignore[typeddict-item]
    causes = lines(draw(told).axes[1])
    assert "contact" not in causes
    assert "next to nothing:\ncontact" in causes


MAGIC = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.mark.parametrize("ending", MAGIC)
def test_equal_recordings_give_equal_plots(ending: str, wall: Recording, tmp_path: Path) -> None:
    cache, first, second = (
        tmp_path / "wall.npz",
        tmp_path / f"first.{ending}",
        tmp_path / f"second.{ending}",
    )
    wall.save(cache)
    assert main(["plot", str(cache), "--out", str(first)]) == 0
    wall.plot(second)
    assert first.read_bytes()[: len(MAGIC[ending])] == MAGIC[ending]
    assert first.read_bytes() == second.read_bytes()


def test_a_recording_without_frames_says_so(scripted: Recording, tmp_path: Path) -> None:
    with pytest.raises(CacheError, match="'slab' has no frames"):
        replace(scripted, reports=[]).plot(tmp_path / "slab.png")
    assert list(tmp_path.iterdir()) == []


def test_the_extra_is_named_where_it_is_missing(
    monkeypatch: pytest.MonkeyPatch, wall: Recording, tmp_path: Path
) -> None:
    monkeypatch.setattr("frangible.extras.find_spec", lambda _: None)
    with pytest.raises(OutputError, match=r"pip install 'frangible\[plot\]'"):
        wall.plot(tmp_path / "wall.png")
