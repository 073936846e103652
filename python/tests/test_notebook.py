"""A world that is stepped in a notebook, and the widget that shows it: what goes over its wire."""

from __future__ import annotations

import json
import zlib
from typing import Any

import pytest
from frangible import OutputError, World, extras, notebook, shot_scene

anywidget = pytest.importorskip("anywidget", reason="needs the extra notebook")


class Wire:
    """What a widget sends, and the way to answer it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        from comm import base_comm
        from ipywidgets import comm

        wire = self

        class Comm(base_comm.BaseComm):
            def publish_msg(self, _: str, data: Any = None, **rest: Any) -> None:
                wire.comm = self
                wire.sent.append((data or {}, list(rest.get("buffers") or [])))

        self.sent: list[tuple[dict[str, Any], list[Any]]] = []
        self.comm: Any = None
        monkeypatch.setattr(comm, "create_comm", Comm)

    def chunks(self) -> list[tuple[int, bytes]]:
        """Chunks since they were asked for last, with their numbers."""
        found = [
            (data["content"]["number"], bytes(buffers[0]))
            for data, buffers in self.sent
            if data.get("method") == "custom"
        ]
        self.sent.clear()
        return found

    def tell(self, **data: Any) -> None:
        """As a page does."""
        self.comm.handle_msg({"content": {"data": data}, "buffers": []})


def header(blob: bytes) -> dict[str, Any]:
    inflated = zlib.decompress(blob)
    read: dict[str, Any] = json.loads(inflated[4 : 4 + int.from_bytes(inflated[:4], "little")])
    return read


def test_frames_go_to_the_notebook_as_they_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    wire = Wire(monkeypatch)
    world = World.build(shot_scene("wall"))
    player = notebook.live(world, "a wall")
    state = next(data["state"] for data, _ in wire.sent if "title" in data.get("state", {}))
    assert state["title"] == "a wall" and state["picked"] is None
    assert ">posted</script>" in state["page"] and "connect-src" not in state["page"]
    first = wire.chunks()
    assert [header(blob)["frames"] for _, blob in first] == [0]

    player.run(12)
    report = player.step()
    assert (report["frame"], world.frame) == (13, 13)
    later = wire.chunks()
    player.end()
    later += wire.chunks()
    # Each begins where the one before ends.
    heads = [header(blob) for _, blob in first + later]
    assert [head["first"] for head in heads[1:]] == [head["frames"] for head in heads[:-1]]
    assert [head["isLast"] for head in heads] == [False] * (len(heads) - 1) + [True]
    assert heads[-1]["frames"] == 13
    assert sum(len(head["names"]) for head in heads) > 20

    # A page that was opened again gets all of it, one that lost some the rest.
    wire.tell(method="custom", content={"from": 0})
    assert wire.chunks() == first + later
    wire.tell(method="custom", content={"from": len(heads) - 1})
    assert wire.chunks() == later[-1:]


def test_a_press_on_a_body_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    wire = Wire(monkeypatch)
    world = World.build(shot_scene("wall"))
    player = notebook.live(world)
    seen: list[Any] = []
    player.observe(lambda change: seen.append(change["new"]), "picked")
    ball = int(world.ids[-1])
    wire.tell(method="update", state={"picked": ball}, buffer_paths=[])
    assert player.picked == ball
    wire.sent.clear()
    player.picked = None
    assert wire.sent[0][0]["state"] == {"picked": None}
    assert seen == [ball, None]


def test_what_others_step_is_shown_when_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wire = Wire(monkeypatch)
    world = World.build(shot_scene("wall"))
    player = notebook.live(world)
    wire.chunks()
    for _ in range(3):
        player.capture(world.step())
    # As at the end of a cell.
    player._send_rest()
    assert header(wire.chunks()[-1][1])["frames"] == 3
    player._send_rest()
    assert wire.chunks() == []


def test_without_the_extra_a_sentence_tells_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    told = r"^a live player needs an optional package.*frangible\[notebook\]"
    with pytest.raises(OutputError, match=told):
        notebook.live(World.build(shot_scene("wall")))
