"""The package as text: no circles of imports between files or folders, and no long lines."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import frangible
import pytest

PACKAGE = Path(frangible.__file__).parent
FOLDERS = {"bench", "breaking", "cli", "io", "render"}

#: The compiled module, which imports none of the files.
ENGINE = "_frangible"
#: `Recording` saves, loads and records itself: its methods import writers and readers when called.
LATE = {"recording"}


def modules(package: Path) -> dict[str, Path]:
    """Every file, by its place in the package with dots: `io.usd`, `io` for `io/__init__.py`."""
    found = {}
    for path in package.rglob("*.py"):
        parts = path.relative_to(package).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(package: Path) -> dict[str, set[str]]:
    """The files that each file imports names from, wherever in the file it does."""
    known = modules(package)
    return {module: set(imported(module, path, known)) - {module} for module, path in known.items()}


def imported(module: str, path: Path, known: dict[str, Path]) -> Iterator[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    parts = [part for part in module.split(".") if part]
    inside = parts if path.name == "__init__.py" else parts[:-1]
    statements = tree.body if module in LATE else ast.walk(tree)
    for statement in statements:
        if not isinstance(statement, ast.ImportFrom):
            continue
        names = [] if statement.module is None else statement.module.split(".")
        if statement.level > 0:
            names = [*inside[: len(inside) - statement.level + 1], *names]
        elif names[0] == "frangible":
            names = names[1:]
        else:
            continue
        for alias in statement.names:
            both = ".".join([*names, alias.name])
            yield both if both in known or alias.name == ENGINE else ".".join(names)


def by_folder(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """The same for folders; a file beside them stands for itself."""
    folders: dict[str, set[str]] = {}
    for module, others in graph.items():
        folder = module.partition(".")[0]
        uses = folders.setdefault(folder, set())
        uses |= {other.partition(".")[0] for other in others} - {folder}
    return folders


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Those that import each other in a circle, in order; empty without one."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        nodes: list[str] = error.args[1]
        return nodes
    return []


def test_no_two_files_import_each_other_in_a_circle() -> None:
    assert circle(imports(PACKAGE)) == []


def test_no_two_folders_import_each_other_in_a_circle() -> None:
    graph = by_folder(imports(PACKAGE))
    assert set(graph) >= FOLDERS
    assert circle(graph) == []


def test_every_folder_of_the_package_is_known() -> None:
    assert {path.parent.name for path in PACKAGE.glob("*/__init__.py")} == FOLDERS


@pytest.mark.parametrize(
    "there",
    ["from ..io.usd import b", "from ..io import usd", "def f(): from frangible.io.usd import b"],
)
def test_circles_are_found(there: str, tmp_path: Path) -> None:
    for folder in ("io", "render"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").touch()
    (tmp_path / "__init__.py").write_text("from .io.usd import a")
    (tmp_path / "io" / "usd.py").write_text("from ..render.stage import a")
    (tmp_path / "render" / "stage.py").write_text(there)
    assert set(circle(imports(tmp_path))) == {"io.usd", "render.stage"}
    # Two folders can be in a circle though no two files are.
    (tmp_path / "render" / "stage.py").write_text("")
    (tmp_path / "render" / "film.py").write_text(there)
    assert circle(imports(tmp_path)) == []
    assert set(circle(by_folder(imports(tmp_path)))) == {"io", "render"}


def test_a_file_that_imports_through_the_package_is_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "__init__.py").write_text("from ._frangible import World\nfrom .usd import a")
    (tmp_path / "usd.py").write_text("from . import _frangible")
    assert circle(imports(tmp_path)) == []
    (tmp_path / "usd.py").write_text("from . import World")
    assert set(circle(imports(tmp_path))) == {"", "usd"}


def test_no_line_has_more_than_100_columns() -> None:
    for path in [
        *PACKAGE.rglob("*.py"),
        *PACKAGE.glob("*.pyi"),
        *Path(__file__).parent.glob("*.py"),
    ]:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            assert len(line) <= 100, f"{path}:{number}"
