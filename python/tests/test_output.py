"""Output files: checked before a run, and whole or absent after it."""

import errno
import os
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from frangible import OutputError, Recording, _frangible
from frangible.cli import main
from frangible.io.output import open_output
from frangible.io.whole import whole_file, whole_folder


def test_a_file_takes_its_name_only_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")
    with whole_file(str(path)) as part:
        Path(part).write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert os.listdir(tmp_path) == ["file.txt"]


#: Of all files that a recording can be written as.
ENDINGS = ".abc, .gif, .glb, .html, .mp4, .npz, .png, .usda, .usdc, .usdz"


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failed_write_leaves_what_was_there(failure: type[BaseException], tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(failure), whole_file(str(path)) as part:
        Path(part).write_text("half")
        raise failure
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["file.txt"]


@pytest.mark.parametrize("ending", ["usda", "usdc", "glb", "html", "npz", "png"])
def test_every_writer_leaves_nothing_of_a_recording_that_it_cannot_write(
    ending: str, scripted: Recording, tmp_path: Path
) -> None:
    # The last body has a triangle without its third corner, and the reports are no JSON.
    torn = replace(scripted.body(5), id=6, triangles=np.array([[0, 1, 99]], np.uint32))
    broken = replace(scripted, bodies=[*scripted.bodies, torn], reports=[{"time": object()}])
    with pytest.raises((IndexError, TypeError)):
        broken.save(tmp_path / f"slab.{ending}")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_run_that_is_asked_to_end_leaves_nothing(number: signal.Signals, tmp_path: Path) -> None:
    script = (
        "import sys, time\n"
        "from frangible import cli\n"
        "from frangible.io.whole import whole_file\n"
        "from frangible.cli import run as module\n"
        "def run(options):\n"
        "    with whole_file(sys.argv[1]) as part:\n"
        "        open(part, 'w').write('half')\n"
        "        print('writing', flush=True)\n"
        "        time.sleep(60)\n"
        "module._run = run\n"
        "sys.exit(cli.main(['run', 'wall']))\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script, tmp_path / "file.txt"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    assert len(os.listdir(tmp_path)) == 1
    process.send_signal(number)
    # A second one does not disturb what goes away.
    if number != signal.SIGINT:
        process.send_signal(number)
    assert process.wait(timeout=30) == 128 + number
    assert os.listdir(tmp_path) == []


def test_a_link_leads_to_what_is_written(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "real.txt", tmp_path / "link.txt"
    link.symlink_to(target)
    for text in ("new", "newer"):
        with whole_file(str(link)) as part:
            assert Path(part).parent == tmp_path / "there"
            Path(part).write_text(text)
        assert link.is_symlink() and target.read_text() == text
    # Permissions stay as they were.
    target.chmod(0o600)
    with whole_file(str(link)) as part:
        Path(part).write_text("secret")
    assert target.stat().st_mode & 0o777 == 0o600
    assert sorted(os.listdir(tmp_path / "there")) == ["real.txt"]


def test_a_pipe_gets_the_bytes(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.txt"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    with whole_file(str(pipe)) as part:
        Path(part).write_text("through")
    reader.join(timeout=30)
    assert read == ["through"] and pipe.is_fifo() and os.listdir(tmp_path) == ["pipe.txt"]
    assert open_output(str(pipe.rename(tmp_path / "pipe.glb"))).path.endswith("pipe.glb")


def test_a_link_to_the_standard_output_is_one(tmp_path: Path, tetrahedron: str) -> None:
    (tmp_path / "mesh.obj").write_text(tetrahedron)
    (tmp_path / "out.glb").symlink_to("/dev/stdout")
    script = "import sys; from frangible.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [
        sys.executable,
        "-c",
        script,
        "break",
        "mesh.obj",
        "--pattern",
        "slices",
        "--voxels",
        "16",
        "--out",
        "out.glb",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0 and done.stdout.startswith(b"glTF")
    assert (tmp_path / "out.glb").is_symlink()


def test_folders_on_the_way_are_made(scripted: Recording, tmp_path: Path) -> None:
    (tmp_path / "link.npz").symlink_to(tmp_path / "no" / "such.npz")
    for name in ("link.npz", "missing/too/slab.npz"):
        open_output(str(tmp_path / name)).write(scripted)
        assert (tmp_path / name).is_file()
    assert (tmp_path / "link.npz").is_symlink()


def test_what_is_written_is_on_the_disk_before_it_takes_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    sync, replace_file = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda descriptor: (order.append("sync"), sync(descriptor)))
    monkeypatch.setattr(os, "replace", lambda *paths: (order.append("name"), replace_file(*paths)))
    with whole_file(str(tmp_path / "file.txt")) as part:
        Path(part).write_text("new")
    assert order == ["sync", "name", "sync"]


def test_a_folder_is_swapped_whole_or_not_at_all(tmp_path: Path) -> None:
    folder = tmp_path / "pieces"
    for names in (["a", "b"], ["c"]):
        with whole_folder(str(folder)) as part:
            for name in names:
                (Path(part) / name).write_text(name)
        assert sorted(os.listdir(folder)) == names
    with pytest.raises(KeyboardInterrupt), whole_folder(str(folder)) as part:
        (Path(part) / "d").write_text("half")
        raise KeyboardInterrupt
    assert os.listdir(folder) == ["c"] and os.listdir(tmp_path) == ["pieces"]
    # A link to a folder stays one.
    (tmp_path / "link").symlink_to(folder)
    with whole_folder(str(tmp_path / "link") + "/") as part:
        (Path(part) / "e").write_text("e")
    assert (tmp_path / "link").is_symlink() and os.listdir(folder) == ["e"]


def test_old_pieces_stay_until_the_new_ones_are_there(
    tmp_path: Path, tetrahedron: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mesh.obj").write_text(tetrahedron)
    folder = tmp_path / "pieces"
    command = [
        "break",
        str(tmp_path / "mesh.obj"),
        "--pattern",
        "slices",
        "--voxels",
        "16",
        "--out",
        f"{folder}/",
        "--cells",
    ]
    assert main([*command, "12"]) == 0
    before = sorted(os.listdir(folder))
    assert "pieces.json" in before

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("frangible.io.pieces_output._write_report", fail)
    assert main([*command, "2"]) == 1
    monkeypatch.undo()
    assert sorted(os.listdir(folder)) == before and sorted(os.listdir(tmp_path)) == [
        "mesh.obj",
        "pieces",
    ]
    assert main([*command, "2"]) == 0
    assert len(os.listdir(folder)) < len(before)
    monkeypatch.chdir(folder)
    assert main([*command[:-2], "./"]) == 2


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("wall.fbx", f"must be one of {ENDINGS}"),
        ("wall", f"must be one of {ENDINGS}"),
        ("folder.glb", "must be a file"),
    ],
)
def test_destinations_that_cannot_be_written_are_named(
    name: str, rule: str, tmp_path: Path
) -> None:
    (tmp_path / "folder.glb").mkdir()
    with pytest.raises(OutputError) as caught:
        open_output(str(tmp_path / name))
    assert str(tmp_path / name) in str(caught.value)
    assert rule in str(caught.value)


def test_a_missing_optional_package_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("frangible.extras.find_spec", lambda _: None)
    with pytest.raises(OutputError, match=r"pip install 'frangible\[usd\]'"):
        open_output(str(tmp_path / "wall.usdc"))


def test_a_picture_shows_the_bodies_on_the_floor(scripted: Recording) -> None:
    from frangible.render.picture import picture

    scripted = replace(scripted, bodies=[replace(body, look=None) for body in scripted.bodies])
    image = picture(scripted, 5, width=160, height=90).astype(int)
    assert image.shape == (90, 160, 3)
    # Limestone and clay are warm, the floor and the sky are not.
    warm = image[:, :, 0] > image[:, :, 2] + 12
    assert 0.02 < warm.mean() < 0.6
    # Clay is what cracks laid bare: there is none before the break, though stone is there.
    clay = image[:, :, 0] > 1.6 * image[:, :, 2]
    before = picture(scripted, 2, width=160, height=90).astype(int)
    assert clay.mean() > 0.002
    assert (before[:, :, 0] > 1.6 * before[:, :, 2]).mean() < 0.2 * clay.mean()
    # The same picture every time.
    assert np.array_equal(image, picture(scripted, 5, width=160, height=90))


@pytest.mark.parametrize("ending", ["usda", "usdc", "npz", "glb"])
def test_a_full_disk_is_a_sentence_that_names_the_file(ending: str, tmp_path: Path) -> None:
    script = (
        "import resource, sys; from frangible.cli import main;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000));"
        f"sys.exit(main(['run', 'wall', '--frames', '6', '--out', 'wall.{ending}']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 1
    # The frames are kept beside the file while the run lasts, and there the disk is full.
    assert done.stderr.splitlines()[-1].startswith(f"frangible: wall.{ending}.part: File too large")
    assert "Traceback" not in done.stderr
    assert set(os.listdir(tmp_path)) <= {f"wall.{ending}.part"}


def test_the_compiled_module_names_no_folder_of_the_machine_that_built_it() -> None:
    module = Path(_frangible.__file__).read_bytes()
    assert b"crates/geometry/src/" in module, "panics must say where they come from"
    for folder in (b"/registry/src/", bytes(Path.home()) + b"/"):
        assert folder not in module


def test_glass_lets_through_what_lies_behind(scripted: Recording) -> None:
    from frangible.render.camera import Camera
    from frangible.render.picture import picture

    brick = replace(scripted.body(4), interior=np.zeros(12, bool), look="brick")
    before_it = brick.positions + [-0.5, 0.5, 1.1]
    middle = brick.positions[2]
    camera = Camera.look_at(middle + [-2.0, 2.0, 4.0], middle)

    def red(look: str) -> float:
        front = replace(brick, id=6, look=look, positions=before_it)
        image = picture(replace(scripted, bodies=[brick, front]), 5, 96, 54, camera).astype(int)
        return float((image[:, :, 0] > 1.6 * image[:, :, 2]).mean())

    assert red("glass") > 3.0 * red("stone")
