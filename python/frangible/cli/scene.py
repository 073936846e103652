"""``frangible scene``: a scene to start from."""

from __future__ import annotations

import argparse
import json
import os
from typing import Any

from ..io.toml_text import as_toml
from ..scene_file import save_scene
from ..scene_schema import scene_schema
from ..scenes import as_json
from .options import add_scene_options, chosen_scene
from .results import print_json
from .scene_module import scene_module
from .scene_page import scene_page
from .wishes import add_wishes, wished


def add_scene(commands: Any) -> None:
    """Add the command."""
    about = "print the scene of a shot as JSON or TOML, to start one of your own from"
    scene = commands.add_parser("scene", help=about)
    scene.set_defaults(command=_scene)
    add_scene_options(scene)
    add_wishes(scene)
    form = scene.add_mutually_exclusive_group()
    form.add_argument("--toml", action="store_true", help="print TOML, not JSON")
    scene.add_argument("--json", action="store_true", help="JSON in one line, also with --out")
    form.add_argument(
        "--out", metavar="FILE", help="write it as .json, .toml, .usda, .usdc or .usd instead"
    )


def _scene(options: argparse.Namespace) -> None:
    if options.toml and options.json:
        options.parser.error("argument --toml: not allowed with argument --json")
    scene, *_ = chosen_scene(options, wished(options))
    if options.out is not None:
        save_scene(scene, options.out)
        if options.json:
            print_json({"outputs": [{"path": options.out, "bytes": os.path.getsize(options.out)}]})
        return
    if options.json:
        print_json(scene)
        return
    print(as_toml(scene), end="") if options.toml else print(as_json(scene))


def add_schema(commands: Any) -> None:
    """Add the command."""
    schema = commands.add_parser(
        "schema", help="print the JSON Schema of scene files, or their description for people"
    )
    schema.set_defaults(command=_schema)
    form = schema.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="docs/scene_format.md")
    form.add_argument("--json", action="store_true", help="the schema in one line")
    form.add_argument("--python", action="store_true", help="frangible/scene_types.py")


def _schema(options: argparse.Namespace) -> None:
    schema = scene_schema()
    if options.markdown:
        print(scene_page(schema), end="")
    elif options.python:
        print(scene_module(schema), end="")
    elif options.json:
        print_json(schema)
    else:
        print(json.dumps(schema, indent=2))
