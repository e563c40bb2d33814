"""A convergence study of a scene: refinement series, their limits, errors of all levels, the Pareto front."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from knotfem.errors import KnotfemError, Stopped
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene
from knotfem.study.choose import Option, combine
from knotfem.study.closed_forms import closed_form
from knotfem.study.engine.outcomes import FAILURES
from knotfem.study.engine.places import Local, Place
from knotfem.study.extrapolation import Limit, pareto_front
from knotfem.study.jobs import Jobs
from knotfem.study.measured import Measured, measure
from knotfem.study.quantities import main_quantity
from knotfem.study.references import MESH, Reference, mesh_limit, references, series_limits
from knotfem.study.refinement import BASE, SERIES, SIZED, Level, base_level, make_series, refines

TARGETS = (0.05, 0.02, 0.01)
"""Accuracies for which settings are recommended and combinations chosen."""
QUIET_OUTPUT = ("output.fields=false",)
"""Set before the user's own overrides: fields for ParaView are no part of the cost of an answer."""


@dataclass(frozen=True, eq=False)
class ConvergenceStudy:
    """Refinement series of a scene, run and evaluated.

    Attributes:
        scene: as it is.
        measured: all levels, the base first.
        series: levels by series, the base among those with sizes.
        limits: by quantity and series.
        references: by quantity, the least uncertain first.
        main: the quantity that levels are ranked by.
    """

    scene: Scene
    measured: list[Measured]
    series: dict[str, list[Measured]]
    limits: dict[str, dict[str, Limit]]
    references: dict[str, list[Reference]]
    main: str

    @property
    def base(self) -> Measured:
        """The scene as it is."""
        return self.measured[0]

    @property
    def bounded(self) -> bool:
        """Whether the main quantity has a reference that is bounded."""
        found = self.references[self.main]
        return bool(found) and not found[0].lacks

    def error(self, entry: Measured, name: str) -> float:
        """Relative error of a level against the reference of the scene; NaN where there is none."""
        found = self.references.get(name)
        return found[0].error(entry.quantities[name]) if entry.done and found else float("nan")

    def own_limit(self, series: str, name: str) -> Limit | None:
        """Limit of a quantity that the errors of a series are taken against: of elements and the scene, the mesh's."""
        if series in (BASE, "element"):
            return mesh_limit(self.base.quantities[name], self.limits[name])
        return self.limits[name].get(series)

    def own_error(self, entry: Measured, name: str) -> float:
        """Relative error of a level against the limit of its own series; NaN where there is none."""
        limit = self.own_limit(entry.level.series, name)
        if limit is None or not entry.done:
            return float("nan")
        reference = self.references[name][0]
        return Reference(limit.value, reference.scale, 0.0, "").error(entry.quantities[name])

    def error_bound(self, entry: Measured) -> float:
        """Bound on the error in the main quantity: the largest among a level and all that refine it.

        Errors of opposite sign can cancel in a coarse level, which says nothing of another scene. A combination with
        another element has at least the bound of that element on its mesh. NaN for a level that is not done, and
        without a reference.
        """
        parts = entry.level.name.split("+") if entry.level.series == "chosen" else []
        elements = [one for one in self.measured if one.level.series == "element" and one.level.name in parts]
        errors = [self.error(one, self.main) for one in _finer(self.measured, entry)]
        return max([*errors, *(self.error_bound(one) for one in elements)], default=float("nan"))

    def promised_error(self, entry: Measured) -> float:
        """Error bound in the main quantity with the reference's own uncertainty; NaN where there is none."""
        found = self.references.get(self.main)
        return self.error_bound(entry) + found[0].uncertainty if found else float("nan")

    @property
    def front(self) -> list[Measured]:
        """Levels that none beats in CPU seconds and error bound; errors below the reference's own are alike."""
        found = self.references[self.main]
        noise = found[0].uncertainty if found else 0.0
        return self._unbeaten(lambda entry: float(np.maximum(self.error_bound(entry), noise)))

    @property
    def offers(self) -> list[Measured]:
        """Levels that none beats in CPU seconds and promised error: what `cheapest` chooses from."""
        return self._unbeaten(self.promised_error)

    def _unbeaten(self, error: Callable[[Measured], float]) -> list[Measured]:
        done = [entry for entry in self.measured if entry.done]
        cpu = np.array([entry.cpu["total"] for entry in done])
        return [done[i] for i in pareto_front(cpu, np.array([error(entry) for entry in done]))]

    def cheapest(self, target: float) -> Measured | None:
        """The level with the least CPU seconds whose error, the reference's uncertainty added, is within a target."""
        good = [entry for entry in self.measured if entry.done and self.promised_error(entry) <= target]
        return min(good, key=lambda entry: entry.cpu["total"], default=None)


def run_convergence(
    source: str,
    overrides: Sequence[str],
    folder: Path,
    *,
    budget: float | None,
    names: Sequence[str] = (),
    place: Place | None = None,
    tell: Callable[[str], None],
) -> ConvergenceStudy:
    """Run a scene's series and evaluate them.

    Args:
        source: a scene, as for `load_scene`.
        overrides: likewise, for all levels.
        folder: where the runs are or go.
        budget: wall seconds, or none.
        names: of the series, all by default.
        place: where runs are computed; one a processor of this machine by default.
        tell: told what starts and ends.

    Raises:
        KnotfemError: the scene itself did not run to its end, or a level cannot be.
    """
    jobs = make_jobs(source, overrides, folder, budget=budget, place=place, tell=tell)
    base = base_level()
    series = make_series(jobs.scene_of(base), names)
    jobs.run([base, *(level for levels in series.values() for level in levels)])
    require_base(jobs)
    study = evaluate(jobs, series)
    if "chosen" in series:
        series["chosen"] = chosen(study)
        jobs.run(series["chosen"])
        study = evaluate(jobs, series)
    return study


def make_jobs(
    source: str,
    overrides: Sequence[str],
    folder: Path,
    *,
    budget: float | None,
    place: Place | None = None,
    tell: Callable[[str], None],
) -> Jobs:
    """Runs of a scene in a folder; see `run_convergence`."""
    where = place or Local()

    @cache
    def scene_of(level: Level) -> Scene:
        return load_scene(source, [*QUIET_OUTPUT, f"solver.threads={where.threads}", *overrides, *level.overrides])

    deadline = time.monotonic() + budget if budget is not None else float("inf")
    return Jobs(folder, scene_of, where, deadline, tell)


def require_base(jobs: Jobs) -> None:
    """Check that the scene itself ran to its end.

    Raises:
        KnotfemError: it did not; with the exit code of its own failure.
    """
    outcome = jobs.outcomes[BASE]
    if outcome.state == "failed":
        raise FAILURES.get(outcome.exit_code, KnotfemError)(f"the scene itself fails: {outcome.reason}")
    if outcome.state != "done":
        raise Stopped(f"the scene itself is not through: {outcome.reason}")


def evaluate(jobs: Jobs, series: dict[str, list[Level]]) -> ConvergenceStudy:
    """Errors of all levels that have an outcome.

    Raises:
        KnotfemError: results are missing.
    """
    scene, base = jobs.scene_of(base_level()), measure(jobs, base_level())
    measured = {
        name: [measure(jobs, level) for level in series[name] if level.name in jobs.outcomes]
        for name in SERIES
        if name in series
    }
    every = [base, *(entry for entries in measured.values() for entry in entries)]
    with_base = {name: _sized(name, [base, *entries]) for name, entries in measured.items()}
    theory = closed_form(scene)
    limits = {name: series_limits(with_base, name) for name in base.quantities}
    needed = [name for name in make_series(scene) if name in SIZED and name != "uniform"]
    found = {name: references(name, base.quantities[name], limits[name], theory, needed) for name in base.quantities}
    return ConvergenceStudy(scene, every, with_base, limits, found, main_quantity(list(base.quantities)))


def chosen(study: ConvergenceStudy) -> list[Level]:
    """Combinations of levels that are expected to be cheapest for each target.

    The mesh of a combination is that of levels of section and slice, or that of another element.
    """
    singles = {name: _options(study, name) for name in study.limits[study.main] if name != "uniform"}
    families = [singles] if singles else []
    if study.own_limit("element", study.main) is not None and "element" in study.series:
        others = {name: options for name, options in singles.items() if name not in MESH}
        families.append({"element": _options(study, "element"), **others})
    found = [combine(families, target) for target in TARGETS]
    return list({level.name: level for level in found if level is not None}.values())


def _options(study: ConvergenceStudy, name: str) -> list[Option]:
    limit, scale = study.own_limit(name, study.main), study.references[study.main][0].scale
    assert limit is not None, "the series has a limit"
    reference = Reference(limit.value, scale, limit.uncertainty / scale, "")
    done = [entry for entry in study.series[name] if entry.done]

    def error_bound(entry: Measured) -> float:
        return max(reference.error(one.quantities[study.main]) for one in _finer(done, entry))

    return [
        Option(entry.level, error_bound(entry) + reference.uncertainty, entry.cpu["total"] / study.base.cpu["total"])
        for entry in done
    ]


def _finer(measured: Sequence[Measured], coarse: Measured) -> list[Measured]:
    """Those that refine a level, itself among them; none of one that is not done."""
    return [one for one in measured if one.scene and coarse.scene and refines(one.scene, coarse.scene)]


def _sized(name: str, levels: list[Measured]) -> list[Measured]:
    """Levels of a series; where the step is what changes, sized by the steps that were taken."""
    if name != "step":
        return levels
    steps = levels[0].counts["loading_steps"]
    return [
        replace(entry, size=steps / max(entry.counts["loading_steps"], 1.0)) if entry.done else entry
        for entry in levels
    ]
