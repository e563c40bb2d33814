"""The cost table of a scene: its ladders run, their limits, the errors of every rung, the Pareto front."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from knotfem.errors import KnotfemError, Stopped
from knotfem.threads import usable_threads
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene
from knotfem.study.campaign import FAILURES, Campaign
from knotfem.study.choose import Option, combine
from knotfem.study.closed_forms import closed_form
from knotfem.study.convergence import Limit, pareto_front
from knotfem.study.errors_of import MESH, Reference, ladder_limits, mesh_limit, references
from knotfem.study.ladders import BASE, LADDERS, SIZED, Rung, base_rung, make_ladders, refines
from knotfem.study.measured import Measured, measure
from knotfem.study.quantities import main_quantity

TARGETS = (0.05, 0.02, 0.01)
"""Accuracies for which settings are recommended and combinations chosen."""
QUIET_OUTPUT = ("output.fields=false",)
"""Set before the user's own overrides: fields for ParaView are no part of the cost of an answer."""


@dataclass(frozen=True, eq=False)
class Study:
    """A cost table.

    Attributes:
        scene: as it is.
        measured: all rungs, the base first.
        ladders: rungs by ladder, the base in each ladder of sizes.
        limits: by quantity and ladder.
        references: by quantity, the least uncertain first.
        main: the quantity that rungs are ranked by.
    """

    scene: Scene
    measured: list[Measured]
    ladders: dict[str, list[Measured]]
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
        """Relative error of a rung against the reference of the scene; NaN where there is none."""
        found = self.references.get(name)
        return found[0].error(entry.quantities[name]) if entry.done and found else float("nan")

    def own_limit(self, ladder: str, name: str) -> Limit | None:
        """Limit of a quantity that a ladder's own errors are taken against: of elements and the scene, the mesh's."""
        if ladder in (BASE, "element"):
            return mesh_limit(self.base.quantities[name], self.limits[name])
        return self.limits[name].get(ladder)

    def own_error(self, entry: Measured, name: str) -> float:
        """Relative error of a rung against the limit of its own ladder; NaN where there is none."""
        limit = self.own_limit(entry.rung.ladder, name)
        if limit is None or not entry.done:
            return float("nan")
        reference = self.references[name][0]
        return Reference(limit.value, reference.scale, 0.0, "").error(entry.quantities[name])

    def trusted(self, entry: Measured) -> float:
        """Error in the main quantity that a rung is trusted with: the largest among all rungs that refine it.

        Errors of opposite sign can cancel in a coarse rung, which says nothing of another scene. A combination with
        another element is trusted no more than that element on its mesh. NaN for a rung that is not done, and without
        a reference.
        """
        parts = entry.rung.name.split("+") if entry.rung.ladder == "chosen" else []
        elements = [one for one in self.measured if one.rung.ladder == "element" and one.rung.name in parts]
        errors = [self.error(one, self.main) for one in _finer(self.measured, entry)]
        return max([*errors, *(self.trusted(one) for one in elements)], default=float("nan"))

    def bound(self, entry: Measured) -> float:
        """Trusted error in the main quantity with the reference's own uncertainty; NaN where there is none."""
        found = self.references.get(self.main)
        return self.trusted(entry) + found[0].uncertainty if found else float("nan")

    @property
    def front(self) -> list[Measured]:
        """Rungs that none beats in CPU seconds and trusted error; errors below the reference's own are alike."""
        found = self.references[self.main]
        noise = found[0].uncertainty if found else 0.0
        return self._unbeaten(lambda entry: float(np.maximum(self.trusted(entry), noise)))

    @property
    def offers(self) -> list[Measured]:
        """Rungs that none beats in CPU seconds and bound: what `cheapest` chooses from."""
        return self._unbeaten(self.bound)

    def _unbeaten(self, error: Callable[[Measured], float]) -> list[Measured]:
        done = [entry for entry in self.measured if entry.done]
        cpu = np.array([entry.cpu["total"] for entry in done])
        return [done[i] for i in pareto_front(cpu, np.array([error(entry) for entry in done]))]

    def cheapest(self, target: float) -> Measured | None:
        """The rung with the least CPU seconds whose error, the reference's uncertainty added, is within a target."""
        good = [entry for entry in self.measured if entry.done and self.bound(entry) <= target]
        return min(good, key=lambda entry: entry.cpu["total"], default=None)


def run_study(
    source: str,
    overrides: Sequence[str],
    folder: Path,
    *,
    budget: float | None,
    names: Sequence[str] = (),
    jobs: int | None = None,
    tell: Callable[[str], None],
) -> Study:
    """Run a scene's ladders and evaluate them.

    Args:
        source: a scene, as for `load_scene`.
        overrides: likewise, for all rungs.
        folder: where the runs are or go.
        budget: wall seconds, or none.
        names: of the ladders, all by default.
        jobs: processes at a time; as many as there are processors by default.
        tell: told what starts and ends.

    Raises:
        KnotfemError: the scene itself did not run to its end, or a rung cannot be.
    """
    campaign = make_campaign(source, overrides, folder, budget=budget, jobs=jobs, tell=tell)
    base = base_rung()
    ladders = make_ladders(campaign.scene_of(base), names)
    campaign.take([base, *(rung for rungs in ladders.values() for rung in rungs)])
    require_base(campaign)
    study = evaluate(campaign, ladders)
    if "chosen" in ladders:
        ladders["chosen"] = chosen(study)
        campaign.take(ladders["chosen"])
        study = evaluate(campaign, ladders)
    return study


def make_campaign(
    source: str,
    overrides: Sequence[str],
    folder: Path,
    *,
    budget: float | None,
    jobs: int | None,
    tell: Callable[[str], None],
) -> Campaign:
    """Runs of a scene in a folder; see `run_study`."""
    processors = usable_threads()
    jobs = jobs or processors
    threads = max(1, processors // jobs)

    @cache
    def scene_of(rung: Rung) -> Scene:
        return load_scene(source, [*QUIET_OUTPUT, f"solver.threads={threads}", *overrides, *rung.overrides])

    deadline = time.monotonic() + budget if budget is not None else float("inf")
    return Campaign(folder, scene_of, jobs, threads, deadline, tell)


def require_base(campaign: Campaign) -> None:
    """Check that the scene itself ran to its end.

    Raises:
        KnotfemError: it did not; with the exit code of its own failure.
    """
    outcome = campaign.outcomes[BASE]
    if outcome.state == "failed":
        raise FAILURES.get(outcome.exit_code, KnotfemError)(f"the scene itself fails: {outcome.reason}")
    if outcome.state != "done":
        raise Stopped(f"the scene itself is not through: {outcome.reason}")


def evaluate(campaign: Campaign, ladders: dict[str, list[Rung]]) -> Study:
    """Errors of all rungs that have an outcome.

    Raises:
        KnotfemError: results are missing.
    """
    scene, base = campaign.scene_of(base_rung()), measure(campaign, base_rung())
    measured = {
        name: [measure(campaign, rung) for rung in ladders[name] if rung.name in campaign.outcomes]
        for name in LADDERS
        if name in ladders
    }
    every = [base, *(entry for entries in measured.values() for entry in entries)]
    with_base = {name: _sized(name, [base, *entries]) for name, entries in measured.items()}
    theory = closed_form(scene)
    limits = {name: ladder_limits(with_base, name) for name in base.quantities}
    needed = [name for name in make_ladders(scene) if name in SIZED and name != "uniform"]
    found = {name: references(name, base.quantities[name], limits[name], theory, needed) for name in base.quantities}
    return Study(scene, every, with_base, limits, found, main_quantity(list(base.quantities)))


def chosen(study: Study) -> list[Rung]:
    """Combinations of rungs that are expected to be cheapest for each target.

    Of the mesh a combination has either a rung of section and of slice, or another element with its own mesh.
    """
    singles = {ladder: _options(study, ladder) for ladder in study.limits[study.main] if ladder != "uniform"}
    families = [singles] if singles else []
    if study.own_limit("element", study.main) is not None and "element" in study.ladders:
        others = {ladder: options for ladder, options in singles.items() if ladder not in MESH}
        families.append({"element": _options(study, "element"), **others})
    found = [combine(families, target) for target in TARGETS]
    return list({rung.name: rung for rung in found if rung is not None}.values())


def _options(study: Study, ladder: str) -> list[Option]:
    limit, scale = study.own_limit(ladder, study.main), study.references[study.main][0].scale
    assert limit is not None, "the ladder has a limit"
    reference = Reference(limit.value, scale, limit.uncertainty / scale, "")
    done = [entry for entry in study.ladders[ladder] if entry.done]

    def trusted(entry: Measured) -> float:
        return max(reference.error(one.quantities[study.main]) for one in _finer(done, entry))

    return [
        Option(entry.rung, trusted(entry) + reference.uncertainty, entry.cpu["total"] / study.base.cpu["total"])
        for entry in done
    ]


def _finer(measured: Sequence[Measured], coarse: Measured) -> list[Measured]:
    """Those that refine a rung, itself among them; none of one that is not done."""
    return [one for one in measured if one.scene and coarse.scene and refines(one.scene, coarse.scene)]


def _sized(name: str, rungs: list[Measured]) -> list[Measured]:
    """Rungs of a ladder; where the step is what changes, sized by the steps that were taken."""
    if name != "step":
        return rungs
    steps = rungs[0].counts["loading_steps"]
    return [
        replace(entry, size=steps / max(entry.counts["loading_steps"], 1.0)) if entry.done else entry for entry in rungs
    ]
