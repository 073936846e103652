"""Measured tables in documents: written anew by what measured them, with all text around them
kept."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime


def today() -> str:
    """The date of what is measured now."""
    return datetime.now(UTC).date().isoformat()


def write_table(path: str, rows: Sequence[Sequence[str]], sentence: str) -> None:
    """Put rows into the table of a document whose head is the first of them.

    A sentence about them takes the place of the one that begins with the same four words and ends
    at the end of a paragraph. `ValueError` if the document has no such table or sentence.
    """
    with open(path, encoding="utf-8") as file:
        text = file.read()
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines = [re.sub(r"  +", " ", line) for line in lines]
    head = f"{lines[0]}\n|{'---|' * len(rows[0])}\n"
    begin = text.find(head)
    if begin < 0:
        raise ValueError(f"{path}: has no table with the head {lines[0]}")
    end = begin + len(head)
    while text.startswith("|", end):
        end = text.index("\n", end) + 1
    text = text[:begin] + head + "".join(f"{line}\n" for line in lines[1:]) + text[end:]

    opening = " ".join(sentence.split()[:4])
    told = re.compile(rf"^{re.escape(opening)}\b.*?\n(?=\n)", re.DOTALL | re.MULTILINE)
    if not told.search(text):
        raise ValueError(f"{path}: has no sentence that begins with {opening!r}")
    text = told.sub(lambda _: f"{sentence}\n", text, count=1)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
