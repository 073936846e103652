"""The ``frangible`` command: each of its commands is a module of this package."""

from __future__ import annotations

import argparse
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from .. import _frangible
from ..bench.run_process import BenchError
from ..bench.verification import ClaimError
from ..errors import CacheError, OutputError
from ..interrupts import own_process
from ..io.reading import FileNote
from ..render.camera import CameraError
from .bench import add_bench
from .breaking import add_break
from .completion import add_completion
from .files import add_info, add_plot, add_shots
from .options import (
    EXIT_BAD_INPUT,
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_PIPE_CLOSED,
    BadArguments,
    Parser,
)
from .pattern import add_pattern
from .render import add_film, add_render
from .results import add_json, error_as_json, wants_json
from .run import add_run
from .scene import add_scene, add_schema
from .terminal import flushed, say
from .verify import add_verify
from .view import add_view_command

#: In the order in which the help lists them.
COMMANDS = (
    add_run,
    add_view_command,
    add_scene,
    add_bench,
    add_break,
    add_plot,
    add_film,
    add_render,
    add_verify,
    add_pattern,
    add_shots,
    add_info,
    add_schema,
    add_completion,
)


#: Signals that ask a program to end.
POLITE = (signal.SIGTERM, signal.SIGHUP)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; answers with its exit status."""

    # A polite kill, or the end of the terminal, unwinds like an interrupt, so that temporary files
    # go away.
    def terminate(number: int, _: object) -> NoReturn:
        # A second one must not disturb that.
        for polite in POLITE:
            signal.signal(polite, signal.SIG_IGN)
        sys.exit(128 + number)

    for polite in POLITE:
        # A signal that the caller ignores, as `nohup` does, stays ignored.
        if signal.getsignal(polite) != signal.SIG_IGN:
            signal.signal(polite, terminate)
    warnings.simplefilter("always", FileNote)
    warnings.showwarning = _tell_note
    whole = parser()
    try:
        options = _read(whole, arguments)
    except BadArguments as error:
        given = list(sys.argv[1:] if arguments is None else arguments)
        sys.exit(_failed(str(error), EXIT_BAD_INPUT, wants_json(given)))
    if not hasattr(options, "command"):
        whole.print_help()
        return 0
    try:
        with own_process():
            status: int = options.command(options) or 0
        sys.stdout.flush()
        return status
    except (
        _frangible.BuildError,
        BadArguments,
        BenchError,
        CacheError,
        CameraError,
        ClaimError,
        OutputError,
    ) as error:
        # A sentence about arguments begins with the command.
        sentence = str(error) if isinstance(error, BadArguments) else f"frangible: {error}"
        return _failed(sentence, EXIT_BAD_INPUT, options.json)
    except BrokenPipeError:
        # The reader of our output has seen enough; the interpreter must not try to flush the rest.
        flushed()
        return EXIT_PIPE_CLOSED
    except OSError as error:
        # The disk is full, or the folder went away during the run.
        sentence = f"frangible: {error.filename or 'output'}: {error.strerror or error}"
        return _failed(sentence, EXIT_FAILED, options.json)
    except KeyboardInterrupt:
        return _failed("frangible: interrupted", EXIT_INTERRUPTED, options.json)


def _read(whole: argparse.ArgumentParser, arguments: Sequence[str] | None) -> argparse.Namespace:
    """The options; `BadArguments` in one sentence."""
    options, unknown = whole.parse_known_args(arguments)
    if unknown:
        # The command's own usage, and the nearest of its own options.
        getattr(options, "parser", whole).error(f"unrecognized arguments: {' '.join(unknown)}")
    return options


def _failed(sentence: str, status: int, as_json: bool) -> int:
    """The sentence on stderr, and as JSON on stdout if somebody asked for it, and stdout takes
    it."""
    say(sentence)
    if flushed() and as_json:
        with suppress(OSError):
            error_as_json(sentence, status)
        flushed()
    return status


def _tell_note(message: Warning | str, *_: object, **__: object) -> None:
    """A line about what was left out of a file."""
    say(f"frangible: {message}")


def parser() -> argparse.ArgumentParser:
    """Reads the arguments of all commands."""
    whole = Parser(prog="frangible", description="Rigid bodies that break.")
    whole.add_argument("--version", action="version", version=f"frangible {_frangible.__version__}")
    commands = whole.add_subparsers(metavar="COMMAND")
    for add in COMMANDS:
        add(commands)
    for command in commands.choices.values():
        add_json(command)
        command.set_defaults(parser=command, whole=whole)
    return whole
