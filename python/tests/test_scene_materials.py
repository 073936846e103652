"""Materials of scenes: one word for all that a body is made of."""

import re
from pathlib import Path
from typing import Any

import frangible
import pytest
from frangible import BuildError, World
from frangible.material_presets import PRESETS
from frangible.scene_materials import FIELDS, with_materials

BOX = {"kind": "box", "size": [1, 1, 1]}
DOCS = Path(__file__).parents[2] / "docs"


def resolved(body: dict[str, Any], **materials: Any) -> dict[str, Any]:
    """A body with its material's fields."""
    scene = with_materials({"materials": materials, "bodies": [{"shape": BOX, **body}]})
    assert "materials" not in scene
    (found,) = scene["bodies"]
    assert "material" not in found
    fields: dict[str, Any] = found
    return fields


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_builds_and_breaks_if_it_says_so(name: str) -> None:
    body = resolved({"material": name})
    assert body["density"] == PRESETS[name]["density"] and body["look"] == PRESETS[name]["look"]
    assert ("breaking" in body) == ("strength" in PRESETS[name])
    World.build({"bodies": [{"shape": BOX, "material": name}]}, 1)


def test_fields_of_the_body_count_more() -> None:
    body = resolved({"material": "concrete", "density": 1000, "look": "wood"})
    assert (body["density"], body["look"], body["friction"]) == (1000, "wood", 0.6)
    body = resolved({"material": "concrete", "breaking": {"strength": 5.0, "pieces": 30}})
    assert body["breaking"] == {"strength": 5.0, "pieces": 30} | {
        "pattern": PRESETS["concrete"]["pattern"]
    }
    assert resolved({"material": "concrete", "density": None})["density"] == 2400


def test_what_cannot_or_shall_not_break_does_not() -> None:
    for motion in ("static", "kinematic"):
        assert "breaking" not in resolved({"material": "glass", "motion": motion})
    glue = {"tensile_strength": 1.0, "shear_strength": 1.0}
    assert "breaking" not in resolved({"material": "glass", "bonds": glue})
    assert "breaking" not in resolved({"material": {"like": "glass", "breaks": False}})
    assert resolved({"material": {"like": "glass", "breaks": False}})["look"] == "glass"


def test_materials_of_ones_own() -> None:
    marble = {"like": "concrete", "density": 2700, "look": "stone"}
    body = resolved({"material": "dark"}, marble=marble, dark={"like": "marble", "friction": 0.7})
    assert (body["density"], body["look"], body["friction"]) == (2700, "stone", 0.7)
    assert body["breaking"]["strength"] == "concrete"
    # One of a preset's name takes its place, and may be like it.
    own = resolved({"material": "glass"}, glass={"like": "glass", "density": 2600})
    assert (own["density"], own["friction"]) == (2600, 0.4)
    assert resolved({"material": "glass"}, glass={"density": 2600}) == {
        "shape": BOX,
        "density": 2600,
    }


@pytest.mark.parametrize(
    ("scene", "sentence"),
    [
        (
            {"bodies": [{"name": "wall", "shape": BOX, "material": "concret"}]},
            "bodies[0].material: \"concret\" (did you mean 'concrete'?), must be one of concrete, ",
        ),
        ({"bodies": [{"shape": BOX, "material": 3}]}, "bodies[0].material: 3, must be the name"),
        (
            {"bodies": [], "materials": {"a": {"like": "b"}, "b": {"like": "a"}}},
            'materials.b.like: "a", must not be like itself',
        ),
        ({"bodies": [], "materials": {"a": {"like": "a"}}}, 'materials.a.like: "a", must not be'),
        (
            {"bodies": [], "materials": {"a": {"frction": 1}}},
            "materials.a.frction: unknown field (did you mean 'friction'?), must be one of like,",
        ),
        ({"bodies": [], "materials": []}, "materials: [], must be an object"),
        ({"bodies": [], "materials": {"a": {"breaks": 1}}}, "materials.a.breaks: 1, must be true"),
        (
            {"bodies": [{"name": "x", "shape": BOX, "material": {"density": -1}}]},
            "bodies[0].density: -1.0, must be between 1e-6 and 1e9",
        ),
    ],
)
def test_what_is_no_material_is_named(scene: dict[str, Any], sentence: str) -> None:
    with pytest.raises(BuildError) as caught:
        World.build(scene, 1)
    assert str(caught.value).startswith(sentence), caught.value
    if scene["bodies"] and "name" in scene["bodies"][0]:
        assert str(caught.value).endswith(f'(body "{scene["bodies"][0]["name"]}")')


def test_the_schema_has_the_fields_of_materials() -> None:
    material = frangible.scene_schema()["$defs"]["Material"]
    assert sorted(material["properties"]) == sorted(FIELDS)


def test_the_page_has_the_numbers_of_the_presets() -> None:
    """The table of docs/materials.md, row by row."""
    page = (DOCS / "materials.md").read_text(encoding="utf-8")
    rows = [re.split(r" *\| *", line)[1:-1] for line in page.splitlines() if line.startswith("| `")]
    found = {
        row[0].strip("`"): [float(row[index].split()[0].strip(":,")) for index in (1, 2, 3)]
        for row in rows
    }
    expected = {
        name: [preset[field] for field in ("density", "friction", "restitution")]
        for name, preset in PRESETS.items()
    }
    assert found == expected
