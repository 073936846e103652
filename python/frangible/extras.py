"""Optional packages, by the extra of the installation that brings them."""

from __future__ import annotations

from importlib.util import find_spec

#: Modules that each extra brings.
_EXTRAS = {
    "alembic": ("alembic3d", "imath"),
    "completion": ("shtab",),
    "exact": ("manifold3d",),
    "film": ("embreex", "PIL", "imageio_ffmpeg"),
    "gltf": ("DracoPy",),
    "notebook": ("anywidget",),
    "plot": ("matplotlib",),
    "render": ("embreex", "PIL"),
    "usd": ("pxr",),
}


def missing_packages(extra: str) -> str | None:
    """How to install what an extra brings; `None` if all of it is there."""
    if all(find_spec(module) is not None for module in _EXTRAS[extra]):
        return None
    return f"needs an optional package, install it with: pip install 'frangible[{extra}]'"
