"""Names for scene graphs, and the bodies under each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from .recording import Body


class Names:
    """Identifiers made of letters, digits and underscores, each different from those before; of the
    path of a prim its last name."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)
        #: The last number that an identifier got.
        self._counts: dict[str, int] = {}

    def own(self, name: str) -> str:
        """The identifier of one more name."""
        last = name.rpartition("/")[2] if name.startswith("/") else name
        identifier = re.sub(r"[^A-Za-z0-9_]", "_", last) or "body"
        if identifier[0].isdigit():
            identifier = f"_{identifier}"
        candidate, count = identifier, self._counts.get(identifier, 1)
        while candidate in self._taken:
            count += 1
            candidate = f"{identifier}_{count}"
        self._counts[identifier] = count
        self._taken.add(candidate)
        return candidate


def unique_names(names: Iterable[str]) -> Iterator[str]:
    """The identifiers of names, in order."""
    known = Names()
    for name in names:
        yield known.own(name)


def by_source(bodies: Iterable[Body]) -> dict[int, list[Body]]:
    """The bodies of each source, itself first."""
    families: dict[int, list[Body]] = {}
    for body in bodies:
        families.setdefault(body.source, []).append(body)
    return families
