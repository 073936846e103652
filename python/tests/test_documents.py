"""Commands that write measured tables and pictures into the documents."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
#: Pictures of something else: drawn by other scripts of bench, by a browser, and by Blender.
OTHERS = {"curve.svg", "pattern-sizes.png", "player.jpg", "renderers.jpg"}
TEXT = """# Times

Before, | a | b | c |.

The times are of long
ago, and of others.

| a | b |
|---|---|
| 1 | 2 |
| 3 | 4 |

After.

| a | c |
|---|---|
| 5 | 6 |
"""


def of_bench(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setattr(sys, "path", [str(ROOT / "bench"), *sys.path])
    return importlib.import_module(name)


def test_a_table_is_written_anew_and_the_text_around_it_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    documents = of_bench("documents", monkeypatch)
    path = tmp_path / "times.md"
    path.write_text(TEXT)
    documents.write_table(str(path), [("a", "b"), ("7", "")], "The times are of today.")
    now = TEXT.replace("of long\nago, and of others.", "of today.")
    assert path.read_text() == now.replace("| 1 | 2 |\n| 3 | 4 |\n", "| 7 | |\n")


@pytest.mark.parametrize(
    ("head", "sentence", "fault"),
    [("x", "The times are of today.", "no table"), ("b", "Others are of today.", "no sentence")],
)
def test_a_document_without_the_table_or_the_sentence_is_left_as_it_is(
    head: str, sentence: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    documents = of_bench("documents", monkeypatch)
    path = tmp_path / "times.md"
    path.write_text(TEXT)
    with pytest.raises(ValueError, match=fault):
        documents.write_table(str(path), [("a", head), ("7", "8")], sentence)
    assert path.read_text() == TEXT


@pytest.mark.parametrize("name", ["figure_speed", "pile_stages"])
def test_documents_have_the_tables_that_are_measured(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = of_bench(name, monkeypatch)
    text = (ROOT / script.DOCUMENT).read_text()
    assert "| " + " | ".join(script.HEAD) + " |\n" in text


def test_every_picture_of_a_shot_can_be_made_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    gallery = of_bench("gallery", monkeypatch)
    patterns = {f"pattern-{kind}.png" for kind in gallery.PATTERNS}
    made = {*gallery.PICTURES, *gallery.FILMS, *patterns}
    assert made | OTHERS == {path.name for path in (ROOT / "docs" / "images").iterdir()}
    assert not made & OTHERS


def test_captions_name_the_shots_of_their_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    gallery = of_bench("gallery", monkeypatch)
    text = (ROOT / "docs" / "gallery.md").read_text()
    for picture, panels in gallery.PICTURES.items():
        if f"images/{picture}" in text:
            for panel in panels:
                assert f"`{panel.run.split()[0]}" in text
                assert str(panel.frame) in text or panel.run == "pillar"
