"""What a stage holds that a scene cannot: each kind named once."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class Notes:
    """Sentences about kinds of things, with the first of each and how many there are."""

    #: What became of each kind, first place and number, by kind.
    found: dict[str, tuple[str, str, int]] = field(default_factory=dict)

    def add(self, what: str, at: object, became: str = "left out") -> None:
        """One more of a kind, at a prim."""
        _, first, count = self.found.get(what, ("", str(at), 0))
        self.found[what] = (became, first, count + 1)

    def sentences(self) -> list[str]:
        """One for each kind, in the order of their names."""
        return [
            f"{what} ({first}{f' and {count - 1} more' if count > 1 else ''}): {became}"
            for what, (became, first, count) in sorted(self.found.items())
        ]
