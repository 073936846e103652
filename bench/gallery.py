"""Pictures of docs/images that are of a shot, a scene or a pattern, made anew.

Run from the repository's root: python bench/gallery.py --mesh BUNNY [NAME ...], as `make gallery`
does; a name is a picture's, without its ending. All of them take hours, most for figure 1.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

from PIL import Image

IMAGES = os.path.join("docs", "images")
#: Of a picture, and of one of several in a picture [pixels].
WHOLE, HALF = (1280, 720), (640, 360)
#: Of JPEG files, of 100.
QUALITY = 88
PATTERNS = ("radial", "voronoi", "natural", "slices", "bricks", "splinters", "concrete")
#: Of each pattern.
CELLS = 40


@dataclass(frozen=True, slots=True)
class Panel:
    """One picture of a run."""

    #: Of `frangible run`.
    run: str
    frame: int
    #: Of `frangible render`.
    view: str = ""


#: Panels from left to right, two in a row.
PICTURES = {
    "figure1.jpg": (
        Panel("pillar", 9, "--camera docs/cameras/pillar.json"),
        Panel("pillar --fps 3000 --frames 9000", 9000, "--camera docs/cameras/pillar.json"),
        Panel("pillar --method paper-uncorrected", 90, "--camera docs/cameras/pillar.json"),
        Panel("pillar", 90, "--camera docs/cameras/pillar.json"),
    ),
    "figure4.jpg": (
        Panel("wall", 14),
        Panel("wall-middle", 14),
        Panel("wall-corner", 14),
        Panel("wall-ball", 12),
    ),
    "cylinder.jpg": (Panel("cylinder", 14),),
    "bunny.jpg": (Panel("bunny --mesh {mesh}", 9),),
    "refracture.jpg": (Panel("refracture", 26), Panel("refracture", 46)),
    "rain.jpg": (Panel("rain-100", 50), Panel("rain-100", 90)),
    "wall-natural.jpg": (Panel("wall-natural", 14),),
    "plank.jpg": (
        Panel("plank", 111, "--camera docs/cameras/plank.json"),
        Panel("plank", 117, "--camera docs/cameras/plank.json"),
    ),
    "stack.jpg": (Panel("stack", 108),),
    "incline.jpg": (Panel("incline", 150),),
    "pane.jpg": (Panel("pane", 6),),
    "masonry.jpg": (Panel("masonry", 14),),
    "timber.jpg": (Panel("timber", 6),),
    "concrete.jpg": (Panel("concrete", 9),),
    "bonded_pillar.jpg": (Panel("bonded-pillar", 42),),
    "card-house.jpg": (Panel("card-house --frames 300", 300),),
    "cradle.jpg": (Panel("cradle", 20),),
    "pile-table.jpg": (Panel("pile-table", 60),),
    "wall.jpg": (Panel("wall", 14),),
    "craters.png": (Panel("docs/scenes/craters.toml", 30),),
}
#: Alone, and small.
SMALL = ("stack.jpg", "incline.jpg", "craters.png")
#: Of a scene.
FILMS = {"scene.gif": "docs/scenes/wall.toml --frames 30 --size 320x180"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of pictures [all]")
    parser.add_argument("--mesh", default="", help="the Stanford bunny, for figure 6")
    options = parser.parse_args()
    patterns = {f"pattern-{kind}.png": kind for kind in PATTERNS}
    known = [*PICTURES, *FILMS, *patterns]
    names = [
        name for name in known if not options.names or os.path.splitext(name)[0] in options.names
    ]
    for unknown in {*options.names} - {os.path.splitext(name)[0] for name in known}:
        parser.error(f"{unknown}: no such picture")
    if any("{mesh}" in panel.run for name in names for panel in PICTURES.get(name, ())):
        if not os.path.isfile(options.mesh):
            parser.error("--mesh: must be the Stanford bunny's file, for figure 6")

    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            path = os.path.join(IMAGES, name)
            if name in PICTURES:
                _draw(name, path, folder, options.mesh)
            elif name in FILMS:
                _frangible(f"run {FILMS[name]} --quiet --out {path}")
            else:
                drawn = os.path.join(folder, name)
                _frangible(f"pattern {patterns[name]} --cells {CELLS} --out {drawn}")
                with Image.open(drawn) as picture:
                    picture.resize(HALF, Image.Resampling.LANCZOS).save(path)
            print(path, flush=True)


def _draw(name: str, path: str, folder: str, mesh: str) -> None:
    """Write a picture; runs are kept in a folder for those that come after."""
    panels = PICTURES[name]
    width, height = WHOLE if len(panels) == 1 and name not in SMALL else HALF
    columns = min(len(panels), 2)
    rows = -(-len(panels) // columns)
    picture = Image.new("RGB", (columns * width, rows * height))
    for index, panel in enumerate(panels):
        cache = os.path.join(folder, f"{_file_name(panel.run)}.npz")
        if not os.path.exists(cache):
            _frangible(f"run {panel.run.format(mesh=mesh)} --quiet --out {cache}")
        drawn = os.path.join(folder, "panel.png")
        _frangible(
            f"render {cache} --frame {panel.frame} --size {width}x{height} {panel.view} "
            f"--quiet --out {drawn}"
        )
        with Image.open(drawn) as part:
            picture.paste(part, (index % columns * width, index // columns * height))
    picture.save(path, quality=QUALITY, optimize=True)


def _file_name(run: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in run)


def _frangible(arguments: str) -> None:
    command = [sys.executable, "-m", "frangible", *arguments.split()]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
