"""`frangible verify`: what holds, what does not, and how it is told."""

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Barrier, Event
from typing import Any

import pytest
from frangible import ClaimError, Verdict, _frangible, claims, verify
from frangible.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"


def finding(measured: float, low: float = -math.inf, high: float = math.inf) -> Any:
    bounded = math.isfinite(low) or math.isfinite(high)
    return {
        "quantity": "height",
        "unit": "m",
        "measured": measured,
        "low": low,
        "high": high,
        "holds": low <= measured <= high,
        "bounded": bounded,
    }


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What each claim finds, in place of the engine's own claims."""
    findings: dict[str, Any] = {}
    monkeypatch.setattr(
        "frangible._frangible.claims",
        lambda: [(name, f"{name} rises", "mechanics") for name in findings],
    )
    monkeypatch.setattr("frangible._frangible.check_claim", lambda name: findings[name])
    return findings


def cells(text: str) -> list[list[str]]:
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]


def test_a_claim_of_the_engine_is_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "bounces"]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("bounces holds, measured in ")
    head, rule, claim, *rows = cells(captured.out)
    assert head == ["claim", "source", "quantity", "measured", "bound", "verdict"]
    assert set(rule) == {"---"}
    says, source = next(told[1:] for told in claims() if told[0] == "bounces")
    assert claim == ["bounces", source, says, "", "", "holds"]
    # The same numbers as the engine's.
    found = _frangible.check_claim("bounces")
    assert [(row[2], row[3]) for row in rows] == [
        (item["quantity"], f"{item['measured']:.5g}") for item in found
    ]
    assert {row[5] for row in rows} == {"holds", "(beside)"}


def test_bounds_and_verdicts_are_told(
    told: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    told["good"] = [
        finding(1.5, 1.0, 2.0),
        finding(1.5, high=2.0),
        finding(1.5, low=1.0),
        finding(1.5),
    ]
    told["bad"] = [finding(3.0, 1.0, 2.0), finding(math.nan, high=2.0), finding(1.5)]
    assert main(["verify"]) == 1
    captured = capsys.readouterr()
    assert [row[3:] for row in cells(captured.out)[2:]] == [
        ["", "", "holds"],
        ["1.5 m", "1 to 2", "holds"],
        ["1.5 m", "<= 2", "holds"],
        ["1.5 m", ">= 1", "holds"],
        ["1.5 m", "", "(beside)"],
        ["", "", "does not hold"],
        ["3 m", "1 to 2", "does not hold"],
        ["nan m", "<= 2", "does not hold"],
        ["1.5 m", "", "(beside)"],
    ]
    assert sorted(line.split(",")[0] for line in captured.err.splitlines()) == [
        "bad does not hold",
        "good holds",
    ]
    assert main(["verify", "good"]) == 0


def test_json_is_one_object_of_standard_json(
    told: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    told["good"], told["bad"] = [finding(1.5, low=1.0)], [finding(math.nan, high=2.0)]

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    assert main(["verify", "--json"]) == 1
    told_json = json.loads(capsys.readouterr().out, parse_constant=refuse)
    good, bad = told_json["claims"]
    assert told_json["holds"] is False
    assert (good["claim"], good["says"], good["source"], good["holds"]) == (
        "good",
        "good rises",
        "mechanics",
        True,
    )
    assert good["seconds"] >= 0.0
    assert good["findings"] == [{**finding(1.5, low=1.0), "high": None}]
    assert (bad["holds"], bad["findings"][0]["measured"], bad["findings"][0]["high"]) == (
        False,
        None,
        2.0,
    )
    assert main(["verify", "--json", "good"]) == 0
    assert json.loads(capsys.readouterr().out)["holds"] is True


def test_a_claim_that_nobody_makes_is_named_before_anything_is_measured(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(KeyError, match="perpetual-motion"):
        _frangible.check_claim("perpetual-motion")
    monkeypatch.setattr(
        "frangible._frangible.check_claim", lambda _: pytest.fail("must not be measured")
    )
    assert main(["verify", "bounces", "perpetual-motion"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    names = ", ".join(name for name, _, _ in claims())
    assert captured.err == f"frangible: unknown claim 'perpetual-motion', must be one of: {names}\n"
    with pytest.raises(ClaimError):
        verify("perpetual-motion")


def test_claims_are_measured_side_by_side_and_told_in_order(
    told: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    told |= {"slow": [finding(1.0)], "quick": [finding(2.0)]}
    both, quick_is_done = Barrier(2, timeout=10), Event()

    def check(name: str) -> Any:
        both.wait()
        if name == "slow":
            assert quick_is_done.wait(10)
        return told[name]

    done: list[str] = []

    def on_done(verdict: Verdict) -> None:
        done.append(verdict.claim)
        quick_is_done.set()

    monkeypatch.setattr("frangible._frangible.check_claim", check)
    assert [verdict.claim for verdict in verify(on_done=on_done)] == ["slow", "quick"]
    assert done == ["quick", "slow"]


def test_an_error_in_a_claim_reaches_the_caller(
    told: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    told["broken"] = []
    monkeypatch.setattr("frangible._frangible.check_claim", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        next(verify())


def test_an_interrupt_need_not_wait_for_what_is_measured() -> None:
    command = [sys.executable, "-m", "frangible", "verify", "bounces", "random-scenes"]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    assert process.stderr.readline().startswith("bounces holds")
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors == "frangible: interrupted\n"
    # Two hundred scenes take many seconds more.
    assert time.monotonic() - begin < 4.0


def test_the_docs_have_a_row_for_every_claim() -> None:
    rows = [
        row[0]
        for row in cells((DOCS / "claims.md").read_text(encoding="utf-8"))
        if len(row) == 6 and row[0]
    ]
    assert rows == ["claim", "---", *(name for name, _, _ in claims())], "run: make claims"
