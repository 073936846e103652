"""Images that mesh files refer to, or hold."""

from __future__ import annotations

import os
import warnings
from io import BytesIO

from ..extras import missing_packages
from ..materials import Image
from .gltf_document import own_file
from .reading import FileNote, file_fault

#: How files of images begin.
_MAGIC = {b"\x89PNG": "image/png", b"\xff\xd8": "image/jpeg"}


def image_file(path: str, uri: str) -> Image | None:
    """An image in a file of its own, in the folder of the file at ``path`` or below; a note and
    nothing if it cannot be read."""
    name = own_file(path, uri.replace("\\", "/"))
    if name is None or file_fault(name):
        warnings.warn(f"{path}: has no image {uri!r} in its own folder", FileNote, stacklevel=2)
        return None
    with open(name, "rb") as file:
        return known_image(path, os.path.basename(name), file.read())


def known_image(path: str, name: str, data: bytes) -> Image | None:
    """An image that all our files can hold; others are turned into PNG where a library is there."""
    for magic, mime in _MAGIC.items():
        if data.startswith(magic):
            return Image(name, mime, data)
    if not missing_packages("render"):
        from PIL import Image as Picture

        try:
            made = BytesIO()
            Picture.open(BytesIO(data)).save(made, "PNG")
            return Image(os.path.splitext(name)[0] + ".png", "image/png", made.getvalue())
        except (OSError, ValueError, Picture.DecompressionBombError):
            pass
    warnings.warn(
        f"{path}: the image {name!r} is neither PNG nor JPEG, and is left out",
        FileNote,
        stacklevel=2,
    )
    return None
