"""Scenes as dataclasses, with their files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Self

from .errors import OutputError
from .io.toml_text import as_toml
from .io.whole import whole_file
from .scene_types import SceneDesc
from .scenes import TEXT_ENDINGS, as_json, read_scene


@dataclass(slots=True)
class Scene(SceneDesc):
    """A scene: bodies, gravity and how they are simulated. SI units, y up."""

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The scene of a file; `BuildError` if it is none."""
        return cls.from_dict(read_scene(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene as .json or .toml; `OutputError` for another ending."""
        name = os.fspath(path)
        ending = os.path.splitext(name)[1].lower()
        if ending not in TEXT_ENDINGS:
            raise OutputError(
                f"{name}: ends in {ending!r}, must end in {' or '.join(TEXT_ENDINGS)}"
            )
        fields = self.to_dict()
        text = as_toml(fields) if ending == ".toml" else f"{as_json(fields)}\n"
        with whole_file(name) as part, open(part, "w", encoding="utf-8") as file:
            file.write(text)
