"""``frangible completion``: words that a shell completes."""

from __future__ import annotations

import argparse
import zlib
from collections.abc import Iterator
from typing import Any

from .. import _frangible
from ..errors import OutputError
from ..extras import missing_packages
from .results import print_json

#: Shells, and where each looks for its scripts.
SHELLS = {
    "bash": "~/.local/share/bash-completion/completions/frangible",
    "fish": "~/.config/fish/completions/frangible.fish",
    "zsh": "~/.zfunc/_frangible, with fpath+=~/.zfunc before compinit in ~/.zshrc",
}


def add_completion(commands: Any) -> None:
    """Add the command."""
    places = "\n".join(f"  {shell:5} {place}" for shell, place in SHELLS.items())
    completion = commands.add_parser(
        "completion",
        help="print a script that completes commands, options, shots and files in a shell",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=f"where shells look for it:\n{places}",
    )
    completion.set_defaults(command=_completion)
    completion.add_argument("shell", choices=tuple(SHELLS))


def _completion(options: argparse.Namespace) -> None:
    if hint := missing_packages("completion"):
        raise OutputError(f"completion: {hint}")
    import shtab

    whole: argparse.ArgumentParser = options.whole
    for action in _actions(whole):
        if words := _words(action):
            action.complete = _words_and_files(words)  # type: ignore[attr-defined]
        elif _takes_file(action):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    script = shtab.complete(whole, options.shell)
    if options.json:
        print_json({"shell": options.shell, "script": script})
    else:
        print(script)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Of the parser and of all its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)


def _words(action: argparse.Action) -> list[str]:
    """What the action takes beside files, though its type does not say so."""
    if action.dest == "shot":
        return [name for name, _ in _frangible.shots()]
    if action.dest in ("name", "pattern"):
        return [name for name, _ in _frangible.patterns()]
    if action.dest == "camera":
        return ["fit", "stage"]
    return []


def _takes_file(action: argparse.Action) -> bool:
    return isinstance(action.metavar, str) and any(
        word in action.metavar for word in ("FILE", "FOLDER", "MESH")
    )


def _words_and_files(words: list[str]) -> dict[str, Any]:
    """Completes names, and files."""
    all_words = " ".join(words)
    name = f"_frangible_{zlib.crc32(all_words.encode()):08x}"
    bash = f'{name}() {{\n  compgen -W "{all_words}" -- $1\n  compgen -f -- $1\n}}'
    zsh = f"{name}() {{\n  compadd {all_words}\n  _files\n}}"
    return {
        "bash": name,
        "zsh": name,
        "fish": f"({name})",
        "preamble": {
            "bash": bash,
            "zsh": zsh,
            "fish": f"function {name}\n  string split ' ' '{all_words}'\n"
            "  __fish_complete_path (commandline -ct)\nend",
        },
    }
