"""Opening USD stages: units, times, and no noise."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Tf, Usd, UsdUtils

from .._frangible import BuildError
from ..errors import one_sentence
from .usd_bounds import MOST_PRIMS, has_too_many_prims
from .usd_faults import syntax_fault

#: The key of a layer's custom data that says that we wrote it, and as what.
MARKER = "frangible"


@contextmanager
def open_stage(path: str, error: type[ValueError] = BuildError) -> Iterator[Any]:
    """A stage while the context lasts; ``error`` in one sentence if the library says that it cannot
    be read.

    Messages that the library prints go nowhere: the stage can tell what is missing.
    """
    silence = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        with redirect_stderr(io.StringIO()), one_sentence(path, "USD file", error):
            yield _opened(path, error)
    finally:
        silence.TakeCoalescedDiagnostics()


def _opened(path: str, error: type[ValueError]) -> Any:
    try:
        if has_too_many_prims(path):
            raise error(
                f"{path}: has more than {MOST_PRIMS} prims, each instance counted, must have at "
                "most so many"
            )
        return Usd.Stage.Open(path)
    except Tf.ErrorException as reason:
        if (fault := syntax_fault(reason)) is None:
            raise
        raise error(fault) from None


def written_as(stage: Any) -> str | None:
    """The marker that we wrote, such as ``recording``; `None` if somebody else wrote it."""
    kind = stage.GetRootLayer().customLayerData.get(MARKER)
    return kind if isinstance(kind, str) else None


def mark(stage: Any, kind: str) -> None:
    """Say in the file that we wrote it, and as what."""
    layer = stage.GetRootLayer()
    layer.customLayerData = {**layer.customLayerData, MARKER: kind}


def metres_from_stage(path: str, stage: Any) -> npt.NDArray[np.float64]:
    """The matrix (3, 3) that turns lengths of a stage into metres, and its axes until y is up."""
    unit = number_of(stage, "metersPerUnit", 0.01)
    if not (math.isfinite(unit) and unit > 0.0):
        raise BuildError(f"{path}: metersPerUnit: {unit}, must be a number > 0")
    scale = np.diag([unit] * 3)
    if str(stage.GetRootLayer().pseudoRoot.GetInfo("upAxis") or "Y").upper() != "Z":
        return scale
    # x stays, z goes up, y comes from the back.
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) @ scale


def number_of(stage: Any, key: str, otherwise: float) -> float:
    """A number of the stage's metadata, of whichever type it was stored as."""
    layers = (stage.GetSessionLayer(), stage.GetRootLayer())
    layer = next((layer for layer in layers if layer and layer.pseudoRoot.HasInfo(key)), None)
    if layer is None:
        return otherwise
    try:
        value = float(layer.pseudoRoot.GetInfo(key))
    except (TypeError, ValueError, Tf.ErrorException):
        return math.nan
    return short_number(value)


def short_number(value: float) -> float:
    """The short number that a single was meant as, of which it is the nearest."""
    if not math.isfinite(value) or abs(value) > 1e38:
        return value
    single = np.float32(value)
    return float(str(single)) if float(single) == value else value


def time_code(stage: Any, pose_time: float | None) -> Any:
    """The time of the stage that is so many seconds after its beginning; its first time without
    that."""
    if not stage.HasAuthoredTimeCodeRange() and pose_time is None:
        return Usd.TimeCode.EarliestTime()
    start = stage.GetStartTimeCode() if stage.HasAuthoredTimeCodeRange() else 0.0
    return Usd.TimeCode(start + (pose_time or 0.0) * stage.GetTimeCodesPerSecond())
