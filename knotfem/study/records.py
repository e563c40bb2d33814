"""Settings that were measured to reach an accuracy, stored by class of scenes."""

from __future__ import annotations

import os
import platform
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, cannot_write
from knotfem.files import read_json, write_json
from knotfem.scene.control import OLDER_KEYS
from knotfem.scene.model import Scene
from knotfem.study.convergence import ConvergenceStudy
from knotfem.study.refinement import SIZED
from knotfem.study.similarity import class_of, frictions_of, window_of
from knotfem.threads import usable_threads
from knotfem.version import __version__


@dataclass(frozen=True)
class Setting:
    """A refinement level, as it can be applied to other scenes of its class: lengths over d, forces over E d^2.

    Attributes:
        level: its name.
        error: bound on the relative error in the main quantity.
        uncertainty: of the reference it is taken against.
        cpu_s, wall_s, memory_mb: what it took.
        model: "fem" or "rod".
        element: formulation.
        section_elements: of the cross-section.
        element_length, move, tolerance, stiffness, sample_spacing, stick: without dimension.
        rate, settling: tolerance and slip of `scene.QuasiStatic`; None where no quasi-static steps were measured.
        line_stiffness, ramp: of contact; None where others than the scene's own were not thought of.
    """

    level: str
    error: float
    uncertainty: float
    cpu_s: float
    wall_s: float
    memory_mb: float
    model: str
    element: str
    section_elements: int
    element_length: float
    move: float
    tolerance: float
    stiffness: float
    sample_spacing: float
    stick: float
    rate: float | None = None
    settling: float | None = None
    line_stiffness: float | None = None
    ramp: float | None = None

    @property
    def bound(self) -> float:
        """Error that is promised: the reference's uncertainty added."""
        return self.error + self.uncertainty


@dataclass(frozen=True)
class Record:
    """Settings measured on one scene, the cheapest for their error.

    Attributes:
        scene: its name.
        model: "fem" or "rod", whose limit the errors are taken against.
        scene_class: see `class_of`.
        quantity: that the errors are of.
        window: see `window_of`.
        frictions: see `frictions_of`.
        settings: by rising cost.
        reference: what errors are taken against.
        version: of knotfem.
        date: of the measurement.
        machine: on which the times hold.
    """

    scene: str
    model: str
    scene_class: str
    quantity: str
    window: float
    frictions: tuple[float, float]
    settings: tuple[Setting, ...]
    reference: str
    version: str
    date: str
    machine: dict[str, Any]


def record_of(study: ConvergenceStudy) -> Record:
    """What a study recommends: settings that none beats in CPU seconds and promised error.

    Raises:
        InputError: it has no reference, or none that is bounded.
    """
    if not study.references[study.main]:
        raise InputError("the refinement series give no reference", expected=f"one of {', '.join(SIZED)} among them")
    reference = study.references[study.main][0]
    if reference.lacks:
        lacking = f"{', '.join(reference.lacks)} with a level that is done, or uniform"
        raise InputError("nothing bounds the reference", key="--store", found=reference.source, expected=lacking)
    settings = []
    for entry in study.offers:
        assert entry.scene is not None, "offers are done"
        cost = (entry.cpu["total"], entry.wall["total"], entry.counts["peak_memory_mb"])
        figures = (entry.level.name, study.error_bound(entry), reference.uncertainty, *cost)
        settings.append(Setting(*figures, **_dimensionless(entry.scene)))
    return Record(
        study.scene.name,
        study.scene.model,
        class_of(study.scene),
        study.main,
        window_of(study.scene),
        frictions_of(study.scene),
        tuple(settings),
        reference.source,
        __version__,
        datetime.now(UTC).date().isoformat(),
        {"platform": platform.platform(), "processor": _processor(), "processors": usable_threads()},
    )


def user_file() -> Path:
    """Where a user's own measurements are kept."""
    home = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(home) / "knotfem" / "recommendations.json"


def store(record: Record, path: Path) -> Record | None:
    """Put a record into a file, in place of an older one of the same scene and model.

    Returns:
        The one that it replaces, if any.

    Raises:
        InputError: the file cannot be read or written.
    """

    def key(entry: Record) -> tuple[str, str]:
        return entry.scene, entry.model

    kept = {key(entry): entry for entry in (_read(path) if path.exists() else [])}
    replaced = kept.pop(key(record), None)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from error
    write_json(path, {"measured": [asdict(entry) for entry in sorted([*kept.values(), record], key=key)]})
    return replaced


def stored() -> list[Record]:
    """All records: the user's own first, then the shipped ones.

    Raises:
        InputError: a file is damaged.
    """
    own = user_file()
    shipped = Path(str(files("knotfem.study") / "recommendations.json"))
    return [record for path in (own, shipped) if path.exists() for record in _read(path)]


def _dimensionless(scene: Scene) -> dict[str, Any]:
    rod, contact = scene.rods[0], scene.contact
    return {
        "model": scene.model,
        "element": rod.mesh.element,
        "section_elements": rod.mesh.section_elements,
        "element_length": rod.mesh.element_length / rod.diameter,
        "move": scene.solver.move_over_diameter,
        "tolerance": scene.solver.force_tolerance / (scene.youngs_modulus * scene.diameter**2),
        "stiffness": contact.stiffness_over_modulus,
        "sample_spacing": contact.sample_spacing_over_diameter,
        "stick": contact.stick_over_diameter,
        "rate": scene.quasi_static.tolerance,
        "settling": scene.quasi_static.settling_slip_over_diameter,
        "line_stiffness": contact.line_stiffness_over_hertz,
        "ramp": contact.ramp_over_diameter,
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _read(path: Path) -> list[Record]:
    data = read_json(path)
    try:
        return [_record(**entry) for entry in data["measured"]]
    except (KeyError, TypeError) as error:
        expected = "a file that knotfem cost --store of this version wrote"
        raise InputError(f"no recommendations are in it ({error})", file=path, expected=expected) from None


def _record(settings: list[dict[str, Any]], frictions: list[float], **others: Any) -> Record:
    read = tuple(Setting(**{OLDER_KEYS.get(key, key): value for key, value in s.items()}) for s in settings)
    return Record(settings=read, frictions=(frictions[0], frictions[1]), **others)
