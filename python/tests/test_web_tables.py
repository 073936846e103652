"""What pages know of materials and looks is what the package does."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest
from frangible.material_presets import PRESETS
from frangible.materials import INSIDE, LOOKS, OUTSIDE, SCENERY

TABLES = Path(__file__).parents[2] / "web" / "npm" / "src"
pytestmark = pytest.mark.skipif(not TABLES.is_dir(), reason="no sources of the page")


def test_looks_are_those_of_pictures() -> None:
    table = json.loads((TABLES / "looks.json").read_text())
    sides = ("colour", "metallic", "clear")
    looks = {
        name: {
            "outside": {key: asdict(look.outside)[key] for key in sides},
            "inside": {key: asdict(look.inside)[key] for key in sides},
            "variation": look.variation,
        }
        for name, look in LOOKS.items()
    }
    plain = {"outside": OUTSIDE, "inside": INSIDE, "scenery": SCENERY}
    expected = json.loads(json.dumps({"looks": looks, **plain, "variation": 0.34}))
    assert table == expected


def test_materials_are_the_presets() -> None:
    table = json.loads((TABLES / "materials.json").read_text())
    assert table["presets"] == PRESETS
    named = {preset["strength"] for preset in PRESETS.values() if "strength" in preset}
    assert set(table["strengths"]) == named
