"""The command as a process: help, exit codes, quick start."""

import errno
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from knotfem_cli import main as cli


def knotfem(*arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "knotfem_cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60, check=False)


def test_help_lists_the_verbs_in_order() -> None:
    result = knotfem("--help")
    assert result.returncode == 0
    assert result.stdout.startswith("Usage: knotfem ")
    places = [result.stdout.index(f"\n  {verb} ") for verb in cli.VERBS]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["pul"], 2, "No such command"),
        (["tie"], 2, "Missing argument"),
        (["tie", "bowline", "--path", "straight"], 2, "Invalid value"),
        (["tie", "bowlin"], 3, 'knotfem: no shipped scene has this name; found "bowlin"; expected "bowline"'),
        (["check", "none.toml"], 3, "knotfem: none.toml: no such file"),
        (["resume", "nowhere"], 3, "knotfem: nowhere: no such run"),
    ],
)
def test_exit_codes(arguments: list[str], code: int, text: str, tmp_path: Path) -> None:
    result = knotfem(*arguments, folder=tmp_path)
    assert result.returncode == code
    assert text in result.stderr
    assert "Traceback" not in result.stderr
    assert not list(tmp_path.iterdir())


def test_help_loads_no_numerics() -> None:
    heavy = "{'pint', 'pydantic', 'numpy', 'h5py', 'numba', 'rich', 'pyvista', 'gmsh', 'matplotlib'}"
    program = f"""
import sys
from knotfem_cli.main import main
sys.argv = ["knotfem", "--help"]
try:
    main()
except SystemExit:
    print("loaded:", *({heavy} & set(sys.modules)))
"""
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout.splitlines()[-1] == "loaded:"


@pytest.mark.parametrize("verb", cli.VERBS)
def test_every_verb_has_the_shared_options_and_an_example(verb: str) -> None:
    command = cli.knotfem_command.get_command(click.Context(cli.knotfem_command), verb)
    assert command is not None
    text = command.get_help(click.Context(command, info_name=verb))
    assert f"  Example:\n    knotfem {verb}" in text or "  Example:\n    knotfem" in text
    for option in ("--set KEY=VALUE", "--quiet", "--log-format [text|json]", "--help"):
        assert option in text


@pytest.mark.parametrize(("error", "code"), [(KeyboardInterrupt(), 130), (click.Abort(), 130), (BrokenPipeError(), 0)])
def test_ends_without_a_traceback(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def fail(**options: object) -> None:
        raise error

    monkeypatch.setattr(cli.knotfem_command, "main", fail)
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == code
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    "arguments", [("--help",), ("pull", "--help"), ("scenes",), ("scenes", "--log-format", "json")]
)
def test_a_full_disk_under_the_output_is_one_message(arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "knotfem_cli", *arguments]
        result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert result.returncode == 3
    assert len(result.stderr.splitlines()) == 1
    assert "the output: cannot be used (No space left on device)" in result.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_messages_that_nobody_can_read_do_not_change_the_exit_code(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "knotfem_cli", "resume", "nowhere"]
        result = subprocess.run(command, stdout=full, stderr=full, cwd=tmp_path, timeout=60, check=False)
    assert result.returncode == 3


def test_a_file_of_which_no_function_has_said_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> list[str]:
        raise OSError(errno.EROFS, "Read-only file system", "there/study")

    monkeypatch.setattr("knotfem.shipped.scene_names", fail)
    result = CliRunner().invoke(cli.knotfem_command, ["scenes"])
    assert (result.exit_code, result.stderr) == (3, "knotfem: there/study: cannot be used (Read-only file system)\n")
