"""Names for scene graphs, and the bodies under each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from .recording import Body


def unique_names(names: Iterable[str]) -> Iterator[str]:
    """Identifiers made of letters, digits and underscores, each different from those before; of the
    path of a prim its last name."""
    taken: set[str] = set()
    for name in names:
        own = name.rpartition("/")[2] if name.startswith("/") else name
        identifier = re.sub(r"[^A-Za-z0-9_]", "_", own) or "body"
        if identifier[0].isdigit():
            identifier = f"_{identifier}"
        candidate, count = identifier, 1
        while candidate in taken:
            count += 1
            candidate = f"{identifier}_{count}"
        taken.add(candidate)
        yield candidate


def by_source(bodies: Iterable[Body]) -> dict[int, list[Body]]:
    """The bodies of each source, itself first."""
    families: dict[int, list[Body]] = {}
    for body in bodies:
        families.setdefault(body.source, []).append(body)
    return families
