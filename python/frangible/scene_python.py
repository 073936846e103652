"""Scenes that a Python file makes."""

from __future__ import annotations

import os
import sys
import traceback
from typing import Any

from ._frangible import BuildError
from .description import Description


def python_scene(path: str) -> Any:
    """The scene that a Python file defines: ``scene``, a `Scene` or a dictionary, or a function
    without arguments that returns one. What it imports may lie beside it.

    `BuildError` names the line of the file in which it failed.
    """
    with open(path, "rb") as file:
        content = file.read()
    folder = os.path.dirname(os.path.abspath(path))
    before = list(sys.path)
    sys.path.insert(0, folder)
    try:
        names: dict[str, Any] = {"__name__": "__frangible__", "__file__": os.path.abspath(path)}
        exec(compile(content, path, "exec"), names)
        found = names.get("scene")
        if callable(found) and not isinstance(found, Description):
            found = found()
    except SyntaxError as error:
        line = error.text or ""
        raise BuildError(
            f"{path}, line {error.lineno}: {error.msg}, must be Python\n"
            f"  {error.lineno} | {line.rstrip()}"
        ) from None
    except Exception as error:
        raise BuildError(_sentence(path, error)) from error
    finally:
        sys.path[:] = before
    if found is None:
        raise BuildError(
            f"{path}: defines no scene, must define 'scene': a frangible.Scene, a dictionary, or a "
            "function that returns one"
        )
    return found


def _sentence(path: str, error: Exception) -> str:
    """What was raised, and the last line of the file that led to it."""
    said = f"{type(error).__name__}: {error}" if not isinstance(error, BuildError) else str(error)
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path
    ]
    if not frames:
        return f"{path}: {said}"
    number = frames[-1].lineno
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = file.read().splitlines()
    line = lines[number - 1] if number is not None and number <= len(lines) else ""
    return f"{path}, line {number}: {said}\n  {number} | {line.rstrip()}"
