"""Results of commands for programs: JSON on stdout, errors too."""

from __future__ import annotations

import argparse
import json
from typing import Any


def add_json(command: argparse.ArgumentParser) -> None:
    """Add ``--json`` to a command that has none."""
    if "--json" not in command._option_string_actions:
        command.add_argument(
            "--json", action="store_true", help="end with a line of JSON on stdout"
        )


def print_json(result: Any) -> None:
    """The line with a command's result."""
    print(json.dumps(result, allow_nan=False), flush=True)


def error_as_json(sentence: str, status: int) -> None:
    """The line that takes a result's place; ``status`` is the exit status."""
    print_json({"error": sentence, "status": status})


def wants_json(arguments: list[str]) -> bool:
    """True if arguments that cannot be read ask for JSON all the same."""
    return "--json" in arguments
