"""Shells complete real words: commands, options, shots, patterns and files."""

import shutil
import subprocess
from pathlib import Path

import pytest
from frangible import shots
from frangible.cli import COMMANDS, main

pytest.importorskip("shtab")

#: Completes the last of the words as bash does when somebody presses Tab.
BASH = """
source completion.bash
COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); COMP_LINE="{words}"
COMP_POINT=${{#COMP_LINE}}
$(complete -p frangible | sed 's/.*-F \\([^ ]*\\).*/\\1/') frangible "${{COMP_WORDS[-1]}}" ""
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def script(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


def in_bash(folder: Path, words: str) -> list[str]:
    command = ["bash", "--norc", "-c", BASH.format(words=words)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=30)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return [word.strip() for word in done.stdout.splitlines()]


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "completion.bash").write_text(script("bash", capsys))
    (tmp_path / "wal.toml").write_text("")
    (tmp_path / "cache.npz").write_text("")
    assert in_bash(tmp_path, "frangible re") == ["render"]
    assert in_bash(tmp_path, "frangible sc") == ["scene", "schema"]
    assert in_bash(tmp_path, "frangible film --shu") == ["--shutter"]
    assert in_bash(tmp_path, "frangible render --renderer bl") == ["blender"]
    # A shot's name, and files.
    walls = {name for name, _ in shots() if name.startswith("wal")}
    assert walls and set(in_bash(tmp_path, "frangible run wal")) == walls | {"wal.toml"}
    assert in_bash(tmp_path, "frangible film ca") == ["cache.npz"]
    assert in_bash(tmp_path, "frangible break a.obj --pattern vor") == ["voronoi"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_reads_its_script(
    shell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = script(shell, capsys)
    for word in ("film", "completion", "--shutter", "refracture", "voronoi"):
        assert word in text
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}")
    (tmp_path / "script").write_text(text)
    done = subprocess.run([shell, "-n", str(tmp_path / "script")], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
def test_fish_completes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "frangible.fish").write_text(script("fish", capsys))
    command = "source frangible.fish; complete -C 'frangible run ref'; complete -C 'frangible sc'"
    done = subprocess.run(
        ["fish", "--no-config", "-c", command], cwd=tmp_path, capture_output=True, text=True
    )
    words = {line.split("\t")[0] for line in done.stdout.splitlines()}
    assert {"refracture", "scene", "schema"} <= words


def test_a_shell_that_nobody_knows_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["completion", "bsh"])
    assert "did you mean 'bash'?" in capsys.readouterr().err
    assert len(COMMANDS) >= 13
