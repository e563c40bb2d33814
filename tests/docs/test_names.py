"""What the documents name exists: files, links, modules, functions, commands, options, keys of scenes, cases."""

from __future__ import annotations

import re
import shlex
from importlib import import_module
from pathlib import Path

import click
import pytest

import knotfem as kf
from knotfem import shipped
from knotfem.scene import load_scene
from knotfem.verify.stress.suite import hard_cases
from knotfem.verify.suite import closed_forms
from knotfem_cli.main import VERBS, Verbs

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "benchmarks" / "README.md", *(ROOT / "docs").glob("*.md")]
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
PATH = re.compile(r"(?<![\w./-])(?:knotfem|cli|tests|benchmarks|docs|configs|meshes)/[\w./-]*\w/?")
TABLE = re.compile(r"(?:^\|.*\n)+", re.MULTILINE)


def commands(text: str) -> list[str]:
    """Command lines of knotfem in code, a line each."""
    lines = [line for block in FENCE.findall(text) for line in block.splitlines()]
    inline = [" ".join(code.split()) for code in re.findall(r"`([^`]+)`", FENCE.sub("", text))]
    parts = [part.strip() for line in [*lines, *inline] for part in line.split("&&")]
    return [part for part in parts if part.startswith("knotfem ")]


@pytest.fixture(params=PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def page(request: pytest.FixtureRequest) -> Path:
    return request.param


@pytest.fixture
def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def test_files(text: str) -> None:
    assert [name for name in PATH.findall(text) if not (ROOT / name).exists()] == []


def test_links(page: Path, text: str) -> None:
    targets = [target.partition("#")[0] for target in re.findall(r"\]\(([^)\s]+)\)", text)]
    local = [target for target in targets if target and "://" not in target]
    assert [target for target in local if not (page.parent / target).exists()] == []


def test_modules_and_functions(text: str) -> None:
    for name in re.findall(r"(?<![\w./-])knotfem(?:\.[A-Za-z_]\w*)+", text):
        assert resolves(name), name
    assert set(re.findall(r"(?<![\w.])kf\.([A-Za-z]\w*)", text)) <= set(kf.__all__)


def resolves(name: str) -> bool:
    """Whether a dotted name is that of a module or of something in one."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        try:
            found: object = import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for part in parts[length:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def test_commands(text: str) -> None:
    for line in commands(text):
        verb = line.split()[1]
        assert verb in (*VERBS, "VERB"), line
        command = Verbs().get_command(click.Context(click.Command("knotfem")), verb)
        known = {option for parameter in command.params for option in parameter.opts} if command else set()
        given = re.findall(r"(?<=\s)--?[a-z][\w-]*", re.split(r"\s{2,}", line)[0])
        assert set(given) <= {*known, "--help"}, line


def test_scenes_and_keys(text: str) -> None:
    for line in commands(text):
        words = shlex.split(re.split(r"\s{2,}|\s#", line)[0])
        if len(words) < 3 or words[2] not in shipped.scene_names():
            continue
        given = [words[i + 1] for i, word in enumerate(words) if word == "--set"]
        load_scene(words[2], [change for change in given if not change.partition("=")[2].isupper()])


def test_cases_of_the_tables() -> None:
    pages = {"validation.md": closed_forms(), "hard-cases.md": hard_cases()}
    for name, known in pages.items():
        tables = TABLE.findall((ROOT / "docs" / name).read_text(encoding="utf-8"))
        rows = "".join(table for table in tables if "(`--only`)" in table.partition("\n")[0])
        named = re.findall(r"^\| `([^`]+)`", rows, re.MULTILINE)
        assert named
        assert [case for case in named if not any(case in (c.name, c.group) for c in known)] == []
