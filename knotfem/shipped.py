"""The one module that finds the scenes, centrelines and cross-sections that travel with the program."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from knotfem.errors import InputError
from knotfem.names import suggestion


def _folder(package: str) -> Path:
    try:
        return Path(str(files(package)))
    except ModuleNotFoundError:
        raise InputError(
            f"the package {package} is missing: install knotfem with pip (pip install -e . in a checkout)"
        ) from None


def _names(folder: Path, pattern: str) -> dict[str, Path]:
    found = {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob(pattern)}
    return dict(sorted(found.items()))


def _scenes() -> dict[str, Path]:
    return _names(_folder("knotfem_data.configs"), "*.toml")


def _centrelines() -> dict[str, Path]:
    return _names(_folder("knotfem_data.meshes") / "centrelines", "*.csv")


def _sections() -> dict[int, Path]:
    folder = _folder("knotfem_data.meshes") / "sections"
    found = {int(path.stem.removeprefix("section_")): path for path in folder.glob("section_*.msh")}
    return dict(sorted(found.items()))


def _pick(kind: str, name: str, known: dict[str, Path]) -> Path:
    if name in known:
        return known[name]
    raise InputError(f"no shipped {kind} has this name", found=f'"{name}"', expected=suggestion(name, known))


def scene_names() -> list[str]:
    """Names of the shipped scenes, such as "bowline" or "hard/...", sorted."""
    return list(_scenes())


def centreline_names() -> list[str]:
    """Names of the shipped centrelines, sorted."""
    return list(_centrelines())


def section_counts() -> list[int]:
    """Element counts of the ready-made cross-sections, ascending."""
    return list(_sections())


def scene_path(name: str) -> Path:
    """File of a shipped scene.

    Raises:
        InputError: no such scene; the message lists the names.
    """
    return _pick("scene", name, _scenes())


def centreline_path(name: str) -> Path:
    """File of a shipped centreline.

    Raises:
        InputError: no such centreline; the message lists the names.
    """
    return _pick("centreline", name, _centrelines())


def section_path(count: int) -> Path:
    """File of the ready-made cross-section with `count` quadrilaterals.

    Raises:
        InputError: no such section; the message lists the counts.
    """
    known = _sections()
    if count not in known:
        raise InputError(
            "no ready-made cross-section",
            key="mesh.section_elements",
            found=count,
            expected=f"one of {', '.join(map(str, known))} elements",
        )
    return known[count]


def centreline_title(name: str) -> str:
    """What a shipped centreline is: its file's first comment line.

    Raises:
        InputError: no such centreline.
    """
    with centreline_path(name).open(encoding="utf-8") as file:
        return file.readline().lstrip("# ").partition(": ")[2].strip()


def drawn_diameter(name: str) -> float:
    """Diameter of the rod for which a shipped centreline is drawn, in its own units, as its comments say.

    Raises:
        InputError: no such centreline.
    """
    text = centreline_path(name).read_text(encoding="utf-8")
    return float(re.findall(r"rod diameter d = ([\d.]+)", text)[0])
