"""Bodies of a stage that wait: ``physics:startsAsleep``, and ``frangible:startsAtFrame``."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, UsdPhysics

from .usd_bodies import StageBody
from .usd_notes import Notes

#: Frame of the stage's timeline at which a body begins to move.
AT_FRAME = "frangible:startsAtFrame"


def add_start(
    fields: dict[str, Any], body: StageBody, first_frame: float, time: Any, notes: Notes
) -> None:
    """Add when a body starts, if it waits; `fields` has its velocities."""
    asleep = bool(UsdPhysics.RigidBodyAPI(body.prim).GetStartsAsleepAttr().Get(time))
    attribute = body.prim.GetAttribute(AT_FRAME)
    frame = attribute.Get(time) if attribute and attribute.HasAuthoredValue() else None
    if body.motion == "kinematic":
        if asleep or frame is not None:
            notes.add("kinematic body that waits", body.name, "follows its transform")
    elif frame is not None:
        fields["starts"] = {"frame": max(0, round(float(frame) - first_frame))}
    elif asleep and ("linear_velocity" in fields or "angular_velocity" in fields):
        notes.add("body that starts asleep and moves", body.name, "starts awake")
    elif asleep:
        fields["starts"] = {"when": "struck"}


def write_start(prim: Any, body: dict[str, Any]) -> None:
    """Say when a body starts, if it waits; the stage's timeline begins at 0."""
    starts = body.get("starts") or {}
    if starts.get("when") == "struck":
        UsdPhysics.RigidBodyAPI(prim).CreateStartsAsleepAttr(True)
    if (frame := starts.get("frame")) is not None:
        # Frames beyond what the attribute holds are kept beside it.
        most = 2**31 - 1
        prim.CreateAttribute(AT_FRAME, Sdf.ValueTypeNames.Int, False).Set(min(int(frame), most))
