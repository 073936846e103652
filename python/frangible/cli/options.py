"""Options of commands: how they are read, and how bad ones are answered."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from collections.abc import Callable
from typing import Any, NoReturn

#: More threads than any machine has processors.
MOST_THREADS = 4096

EXIT_FAILED = 1
#: Bad input, as for `argparse`.
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 128 + signal.SIGINT
EXIT_TERMINATED = 128 + signal.SIGTERM
EXIT_PIPE_CLOSED = 128 + signal.SIGPIPE


class Parser(argparse.ArgumentParser):
    """Answers bad arguments with one sentence."""

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: {message}", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)


def finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}, must be a finite number")
    return value


def positive(kind: Callable[[str], Any], noun: str) -> Callable[[str], Any]:
    def parse(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not 0 < value < math.inf:
            raise argparse.ArgumentTypeError(f"{text!r}, must be {noun} > 0")
        return value

    return parse


def natural(largest: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) > largest:
            raise argparse.ArgumentTypeError(f"{text!r}, must be a whole number >= 0 and <= {largest}")
        return int(text)

    return parse


def naturals(largest: int) -> Callable[[str], list[int]]:
    parse = natural(largest)
    return lambda text: [parse(part) for part in text.split(",")]


def readable(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        between = "; " if value and isinstance(value[0], list) else " "
        return between.join(readable(item) for item in value)
    return str(value)
