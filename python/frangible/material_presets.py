"""Presets of materials for scenes. `docs/materials.md` says where the numbers come from."""

from __future__ import annotations

from typing import Any

#: By name: density [kg/m^3], friction against itself, restitution, strength (of the core's table),
#: pattern, look. Patterns show what breaks a metre across: some dozens of pieces.
PRESETS: dict[str, dict[str, Any]] = {
    "concrete": {
        "density": 2400.0,
        "friction": 0.6,
        "restitution": 0.1,
        "strength": "concrete",
        "pattern": {"kind": "concrete", "cells": 60},
        "look": "concrete",
    },
    "glass": {
        "density": 2500.0,
        "friction": 0.4,
        "restitution": 0.2,
        "strength": "glass",
        "pattern": {"kind": "radial", "spokes": 16, "rings": 4},
        "look": "glass",
    },
    "brick": {
        "density": 1900.0,
        "friction": 0.6,
        "restitution": 0.1,
        "strength": "brick",
        "pattern": {"kind": "natural", "cells": 40, "clustering": 2.0},
        "look": "brick",
    },
    "masonry": {
        "density": 1900.0,
        "friction": 0.6,
        "restitution": 0.05,
        "strength": "brick",
        "pattern": {"kind": "bricks"},
        "look": "masonry",
    },
    "wood": {
        "density": 500.0,
        "friction": 0.5,
        "restitution": 0.2,
        "strength": "wood",
        "pattern": {"kind": "splinters"},
        "look": "wood",
    },
    "ice": {
        "density": 917.0,
        "friction": 0.05,
        "restitution": 0.2,
        "strength": "ice",
        "pattern": {"kind": "voronoi", "cells": 60},
        "look": "glass",
    },
    "steel": {
        "density": 7800.0,
        "friction": 0.4,
        "restitution": 0.3,
        "look": "metal",
    },
}
