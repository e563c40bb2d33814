"""What a scene would take, found out without running it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from knotfem.models.base import Simulation, make_simulation
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded, Pull
from knotfem.solver.term import Term
from knotfem.sparse import linear

MEMORY_MB = (330.0, 0.021)
"""Memory of a run: in all, and for each unknown; measured on the bowline at 15,000 and 96,000 unknowns."""
SECONDS_AN_ITERATION = {"fem": (4.4e-8, 1.5), "rod": (6.5e-6, 1.0)}
"""Wall seconds of a Newton iteration, factor and power of the unknowns: measured on the bowline at 15,000 and 96,000
unknowns on two cores, of the rod model on one."""
ITERATIONS_A_MM = {"fem": 11.0, "rod": 6.0}
"""Newton iterations for each mm of a pull."""
RELAXING_ITERATIONS = {"fem": 150.0, "rod": 90.0}
"""Newton iterations before it."""
UNUSED = {
    "fem": ("contact.line_stiffness_over_hertz", "tie.source", "tie.source_state"),
    "rod": (
        "contact.stiffness_over_modulus", "contact.stick_over_diameter", "rods.mesh.section_elements",
        "rods.mesh.element", "rods.mesh.match_bending_stiffness",
    ),
}  # fmt: skip
"""Keys that tell one model how to compute, and mean nothing to the other."""


def check(scene: Scene) -> dict[str, Any]:
    """Effects that will run and those that will not, size, expected memory and time.

    Raises:
        InputError: a centreline along which no rod can lie.
    """
    model = make_simulation(scene)
    unknowns = model.dofs
    pulled = sum(step.displacement for step in scene.loading_steps if isinstance(step, Pull))
    iterations = RELAXING_ITERATIONS[scene.model] * bool(scene.tying_steps) + ITERATIONS_A_MM[scene.model] * pulled
    minutes = iterations * seconds_an_iteration(scene.model, unknowns) / 60.0
    return {
        "effects": _effects(model.effects, scene),
        "absent": model.absent,
        "keys of the other model": list(UNUSED[scene.model]),
        "dofs": unknowns,
        "hexes": model.hexes,
        "segments": model.segments,
        "mapping": f"{_mapped(model)} alone; tying has no contact",
        "system": _symmetry(model.effects, scene),
        "linear_solver": linear.available()[0] if scene.solver.linear == "auto" else scene.solver.linear,
        "expected_memory_mb": round(MEMORY_MB[0] + MEMORY_MB[1] * unknowns),
        "expected_minutes": float(f"{minutes:.2g}"),
        "warnings": model.warnings,
    }


def seconds_an_iteration(model: str, unknowns: int) -> float:
    """Expected wall time of a Newton iteration [s]."""
    factor, power = SECONDS_AN_ITERATION[model]
    return factor * unknowns**power


def _mapped(model: Simulation) -> str:
    return ", ".join(dict.fromkeys(effect.name for effect in model.elastic)) if model.hexes else "the centrelines"


def _effects(effects: Sequence[Term], scene: Scene) -> dict[str, str]:
    """What runs, by name, with its figures; effects of one name side by side."""
    said: dict[str, list[str]] = {}
    for effect in effects:
        said.setdefault(effect.name, []).append(_says(effect))
    if loaded := [step.name for step in scene.steps if step.having(Loaded)]:
        said["load"] = [f"in {', '.join(loaded)}"]
    if scene.model == "rod" and any(rod.core is not None for rod in scene.rods):
        said["core"] = ["in the EA of the stretch"]
    return {name: "; ".join(texts) for name, texts in said.items()}


def _symmetry(effects: Sequence[Term], scene: Scene) -> str:
    """Whether the matrix is symmetric, and what decides; hexahedra's is then stored and factorised as such."""
    culprits = list(dict.fromkeys(effect.name for effect in effects if not effect.symmetric))
    ends = (end for step in scene.steps for end in step.all_ends().values())
    if any(isinstance(end, Loaded) and end.following for end in ends):
        culprits.append("following load, in its steps")
    kind = f"unsymmetric ({', '.join(culprits)})" if culprits else "symmetric"
    return f"{kind}, stored in full" if scene.model == "rod" else kind


def _says(effect: Any) -> str:
    match effect.name:
        case "contact":
            unit = "MPa/mm" if hasattr(effect, "tubes") else "N/mm^2"
            return f"{effect.samples.u.size} samples, penalty {effect.law.stiffness:.4g} {unit}"
        case "friction":
            return f"coefficients {effect.coefficients.tolist()}"
        case "cylinder friction":
            return f"coefficients {effect.coefficients.tolist()}"
        case "elasticity":
            return f"{effect.elements.shape[0] * effect.elements.shape[1]} hexahedra, G {effect.shear_modulus:.4g} MPa"
        case "core":
            return f"EA {effect.axial_stiffness:.5g} N"
        case "stretch" | "bend" | "twist":
            name, unit = {"stretch": ("EA", "N"), "bend": ("B", "N mm^2"), "twist": ("C", "N mm^2")}[effect.name]
            return f"{name} {', '.join(f'{value:.5g}' for value in np.unique(effect.stiffness))} {unit}"
        case "internal damping":
            name, unit = effect.coefficient
            return f"{name} {', '.join(f'{value:.5g}' for value in np.unique(effect.stiffness))} {unit}"
        case "drag":
            return f"{effect.rate:g} 1/s"
        case "gravity":
            return f"{np.linalg.norm(effect.acceleration) / 1000.0:.4g} m/s^2"
        case "cylinder":
            return f"diameter {2.0 * effect.radius:g} mm"
    return "on"
