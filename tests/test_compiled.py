"""Compiled kernels on disk: found again, never stale, whatever folders and other processes do."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from knotfem import compiled
from knotfem.sources import sources

INNER = """
from knotfem.compiled import kernel

@kernel(inline="always")
def inner(x):
    return x + {added}
"""
OUTER = """
from knotfem.compiled import kernel
from {package}.inner import inner

@kernel
def outer(x):
    return 10 * inner(x)
"""
CALL = """
import sys
from {package}.outer import outer

print(*(outer(float(x) if "." in x else int(x)) for x in sys.argv[1:]))
stats = outer.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()), stats.cache_path)
"""


class Package:
    """Two modules, the kernel of one inlining the kernel of the other, called in processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.name = folder, "ours"
        self.path = folder / self.name
        self.path.mkdir()
        (self.path / "__init__.py").write_text("")
        (self.path / "outer.py").write_text(OUTER.format(package=self.name))
        self.write_inner(1)
        self.cache = folder / "cache"
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(folder), str(Path(compiled.__file__).parents[1])]),
            "NUMBA_CACHE_DIR": str(self.cache),
        }

    def write_inner(self, added: int) -> None:
        (self.path / "inner.py").write_text(INNER.format(added=added))

    def start(self, *values: str, before: str = "") -> subprocess.Popen[str]:
        code = before + CALL.format(package=self.name)
        command = [sys.executable, "-c", code, *values]
        return subprocess.Popen(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=self.folder
        )

    def result(self, process: subprocess.Popen[str]) -> tuple[str, int, int, str, str]:
        """What was printed: values, hits, misses, folder; and what was said on the standard error."""
        out, said = process.communicate(timeout=120)
        assert process.returncode == 0, said
        values, numbers = out.splitlines()
        hits, misses, path = numbers.split(" ", 2)
        return values, int(hits), int(misses), path, said

    def call(self, *values: str, before: str = "") -> tuple[str, int, int, str, str]:
        return self.result(self.start(*values, before=before))


@pytest.fixture
def package(tmp_path: Path) -> Package:
    return Package(tmp_path)


def test_loaded_by_the_next_process(package: Package) -> None:
    assert package.call("1")[:3] == ("20", 0, 1)
    values, hits, misses, folder, said = package.call("1")
    assert (values, hits, misses, said) == ("20", 1, 0, "")
    assert Path(folder).is_relative_to(package.cache)
    beside = {path.suffix for path in package.path.rglob("*") if path.is_file()}
    assert beside <= {".py", ".pyc"}


def test_a_change_of_an_inlined_kernel_in_another_module(package: Package) -> None:
    assert package.call("1")[0] == "20"
    package.write_inner(2)
    assert package.call("1")[:3] == ("30", 0, 1)
    package.write_inner(1)
    assert package.call("1")[:3] == ("20", 1, 0)


def test_a_change_of_this_process_sources_while_it_runs(package: Package) -> None:
    """The process has imported the old text; what it compiles must not stand for the new one."""
    change = f"""
import pathlib, time
import {package.name}.outer
time.sleep(0.05)
pathlib.Path({str(package.path / "inner.py")!r}).write_text({INNER.format(added=2)!r})
"""
    assert package.call("1", before=change)[0] == "20"
    assert package.call("1")[:3] == ("30", 0, 1)


def test_two_processes_at_once(package: Package) -> None:
    for _ in range(2):
        started = [package.start("1"), package.start("1.5"), package.start("1")]
        assert [package.result(process)[0] for process in started] == ["20", "25.0", "20"]
        assert package.call("1", "1.5")[:3] == ("20 25.0", 2, 0)
        assert not list(package.cache.rglob("*.part"))
        shutil.rmtree(package.cache)


def test_a_file_that_was_cut_short(package: Package) -> None:
    package.call("1")
    (file,) = package.cache.rglob("*.nbc")
    file.write_bytes(file.read_bytes()[:1000])
    assert package.call("1")[:3] == ("20", 0, 1)
    assert package.call("1")[:3] == ("20", 1, 0)


def test_a_folder_that_cannot_be_written(package: Package, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    package.environment |= {"NUMBA_CACHE_DIR": str(tmp_path / "file" / "below"), "TMPDIR": str(temporary)}
    values, hits, misses, folder, said = package.call("1", "1.5")
    assert (values, hits, misses) == ("20 25.0", 0, 2)
    assert Path(folder).is_relative_to(temporary)
    assert said.count("compiled kernels are kept in") == 1
    assert package.call("1")[:3] == ("20", 1, 0)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders of other users")
def test_a_temporary_folder_that_others_can_write(package: Package, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    theirs = tmp_path / f"knotfem-{os.getuid()}"
    theirs.mkdir()
    theirs.chmod(0o777)
    package.environment |= {"NUMBA_CACHE_DIR": str(tmp_path / "file"), "TMPDIR": str(tmp_path)}
    values, hits, misses, folder, said = package.call("1")
    assert (values, hits, misses, folder) == ("20", 0, 1, "None")
    assert said.count("compiled kernels cannot be kept") == 1
    assert not list(theirs.iterdir())


def test_the_user_s_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert compiled.cache_folder() == compiled.wanted_folder() == tmp_path / "knotfem"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name, appauthor: tmp_path / name)
    assert compiled.wanted_folder() == tmp_path / "knotfem" / "kernels"


def test_old_versions_are_removed(package: Package) -> None:
    package.call("1")
    module = package.cache / "knotfem" / f"{package.name}.outer"
    gone = package.cache / "knotfem" / "gone"
    day = 86400
    for age in (31, *range(1, 12)):
        for folder in (module / f"{age}", gone / f"{age + 30}"):
            folder.mkdir(parents=True)
            (folder / "old.nbc").write_text("")
            then = time.time() - int(folder.name) * day
            os.utime(folder, (then, then))
    package.write_inner(2)
    package.call("1")
    found = [folder.name for folder in module.iterdir()]
    assert len(found) == 10
    assert {name for name in found if len(name) < 3} == {str(age) for age in range(1, 9)}
    assert not gone.exists()


def test_sources_of_a_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    texts = {
        "theirs/__init__.py": "from theirs.never import x",
        "theirs/a.py": "import numpy\nfrom . import b\nfrom .sub import c\nif 1:\n    import theirs.e\n",
        "theirs/b.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from theirs.never import x\n",
        "theirs/sub/__init__.py": "from theirs.sub.c import d\n",
        "theirs/sub/c.py": "from theirs.a import b\ndef f():\n    from theirs import never\n",
        "theirs/e.py": "from .sub.f import *\n",
        "theirs/sub/f.py": "from knotfem.errors import InputError\n",
        "theirs/never.py": "",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
        os.utime(tmp_path / name, (1e9, 1e9))
    monkeypatch.setitem(sys.modules, "theirs", type(sys)("theirs"))
    monkeypatch.setattr(sys.modules["theirs"], "__path__", [str(tmp_path / "theirs")], raising=False)
    monkeypatch.setattr("knotfem.sources._STARTED", time.time() + 60)
    found = sources("theirs.a", tmp_path / "theirs" / "a.py")
    names = {"theirs", "theirs.a", "theirs.b", "theirs.sub", "theirs.sub.c", "theirs.e", "theirs.sub.f", "theirs.never"}
    assert set(found) == names | {"knotfem.errors"}
    (tmp_path / "theirs" / "__init__.py").write_text("")
    assert set(sources("theirs.a", tmp_path / "theirs" / "a.py")) == names - {"theirs.never"} | {"knotfem.errors"}
