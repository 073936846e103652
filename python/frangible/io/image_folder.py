"""A folder of the images that files refer to."""

from __future__ import annotations

import os

from ..materials import Image
from ..names import unique_names


class ImageFolder:
    """Made and filled when the first material needs it."""

    def __init__(self, folder: str) -> None:
        self._folder = folder
        self._paths: dict[Image, str] = {}

    def path(self, image: Image) -> str:
        """Of the image's file, relative to the folder above."""
        if image not in self._paths:
            os.makedirs(self._folder, exist_ok=True)
            stem, ending = os.path.splitext(image.name)
            stems = [os.path.splitext(os.path.basename(path))[0] for path in self._paths.values()]
            *_, own = unique_names([*stems, stem or "image"])
            name = own + (ending or ("." + image.mime.rpartition("/")[2]))
            with open(os.path.join(self._folder, name), "wb") as file:
                file.write(image.data)
            self._paths[image] = f"{os.path.basename(self._folder)}/{name}"
        return self._paths[image]
