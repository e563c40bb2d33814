"""What the keys of summary.json are; names of numbers end with the unit."""

from __future__ import annotations

NAME = "NAME"
"""Stands for the name of a phase, a term, a rod, an end or a measure."""
SUMMARY = {
    "phases": "what each phase (mapping, steps of the scene) took, by its name",
    "phases.NAME.wall_s": "wall time",
    "phases.NAME.cpu_s": "CPU time",
    "effects": "what each effect took, by its name",
    "effects.NAME.cpu_s": "CPU time",
    "effects.NAME.share": "CPU time over that of all phases",
    "solver_cpu_s": "CPU time of the parts of the solver, by name",
    "other_cpu_s": "CPU time that belongs to no effect, no part of the solver and no output",
    "costs": "wall and CPU time of assembly, contact, factorisation, solve and output",
    "absent_effects": "effects that do not act, and why",
    "curves": "in which size the curve of each rod was taken, by the rod's name",
    "curves.NAME.curve": "file or shipped name",
    "curves.NAME.mm_per_unit": "factor by which its coordinates were multiplied; null for a rod that a run has left",
    "curves.NAME.from": "what gave the factor: the length of the rod, the unit in the file's header, or rods.N.scale",
    "curves.NAME.ends_longer_mm": "by how much both ends together were made longer, negative where they were cut",
    "dofs": "degrees of freedom",
    "hexes": "hexahedra",
    "segments": "segments of discrete rods",
    "slices": "intervals between cross-sections of each rod, and their lengths",
    "steps": "accepted steps",
    "newton_iterations": "iterations of Newton's method in accepted attempts",
    "cutbacks": "attempts at steps that were rejected and retried with shorter ones",
    "analyses": "symbolic factorisations of the matrix",
    "factorisations": "numerical factorisations of the matrix",
    "peak_memory_mb": "largest memory of the process [MB]",
    "max_stretch_deviation": (
        "largest |stretch - 1| of any edge of a centreline in any increment of the mapping, which ties the rods; "
        "steps after tying do not count, and stretch.png shows all edges"
    ),
    "max_penetration_over_d": "deepest overlap of surfaces in any accepted step after tying, over the diameter",
    "min_jacobian": "smallest determinant of the deformation gradient in any accepted step; 1 without hexahedra",
    "max_imbalance_N": "largest sum of external forces, without drag and inertia, in any stored state",
    "max_imbalance_over_force": "the same over the force at the reported end, the largest of all stored states",
    "max_drag_force_N": "largest sum of viscous forces in any stored state",
    "max_rate_force_over_force": "largest dynamic residual over the force at the reported end in any stored state",
    "events": "number of jumps: motions under loads that stand still, from one branch of equilibria to another",
    "settling": "how each step that ties comes to rest, by its name",
    "knot_before": "knot that the steps set out from; of several rods a record each, as under knot_before_details",
    "knot_after": "knot in the last state, likewise",
    "knot_before_details": "by rod: knot, closures of each name, polynomial, crossings, linking numbers, turns, links",
    "knot_after_details": "the same in the last state",
    "remarks": "what was said of the run when it happened: text, step, time, displacement",
    "validity": "how far the run came towards the limits of its model, by measure",
    "validity.NAME.largest": "largest value of all states",
    "validity.NAME.limit": "limit of the model",
    "validity.NAME.exceeded": "whether it was passed",
    "verdict": (
        '"holds": the knot is what it was and came to rest under the load, or the last displacement did not run '
        'through it. "slips": it is what it was, but the rod runs through it, or a free end was drawn in as far as the '
        'step allows. "unravels": it is no longer what it was. "undecided": none of these showed before the run ended. '
        "null without a step that has a loaded and a free end"
    ),
    "verdict_evidence": "what the verdict rests on; in_words says it in a sentence",
    "verdict_evidence.in_words": "the verdict as a sentence",
    "verdict_evidence.at_rest": "whether the rods came to rest under loads that stood still",
    "verdict_evidence.lost": "what came undone, in which step, when and at which friction; null where nothing did",
    "verdict_evidence.travel_in_last_step": "how far ends moved, and rod ran through the knot, in the last step",
    "verdict_evidence.travel_since_loaded": "the same since the first step that loads the knot with free ends",
    "verdict_evidence.fraction_of_last_displacement": "part of the last two diameters of a pull that ran through",
    "verdict_evidence.rod_diameter_mm": "diameter of the thinnest rod",
    "verdict_evidence.locking_unit": "the strands that hold each other, and how far each has slipped",
    "verdict_evidence.slips_measured": "between which states the slips of the strands were measured",
    "verdict_evidence.onset": "step, time and friction at which the strands began to slip",
    "failure_mode": (
        'what slips first in a knot that fails: "wrapping" or "central" strands of its locking unit; "none" where '
        "nothing fails or it is not known"
    ),
    "holding": (
        "what the knot bore in the last step that pulled or loaded it while ends were free; null without such a step. "
        "knotfem hold tightens a knot, lets its free ends go and pulls on until it slips"
    ),
    "holding.slip_mm": "length that a free end may be drawn in by before the knot counts as slipped",
    "holding.slipped": "whether a free end was drawn in by more",
    "holding.holding_force_N": "largest force in equilibrium before that",
    "holding.at_step_displacement_mm": "displacement at this force, since the step began",
    "holding.slipping_force_N": "force when the free end had been drawn in by the slip; null where it was not",
    "holding.slipped_at_step_displacement_mm": "displacement then, since the step began",
    "holding.drawn_in_mm": "by how much it had been drawn in in the last state",
    "final_force_N": "force at the reported end in the last accepted step",
    "linear_solver": "library that solved the linear systems",
    "energies_Nmm": "balance of energy at the end: work, stored and dissipated parts, and missing, its error",
}
"""What a key is, by its dotted name."""
FILES = {
    "scene.toml": "the resolved scene of a run, every default written out",
    "provenance.json": "versions, linear solver, threads, start, end and what ended each session of a run",
    "status.json": "whether a run is running, done, failed or stopped, and how far it is",
    "log.jsonl": "a line for each increment of the mapping and each accepted step of a run",
    "summary.json": "figures of a whole run",
    "results.vtkhdf": "fields of stored states, for ParaView",
    "stretch.png": "stretch of the centrelines in the increments of the mapping",
    "force.png": "force against displacement",
    "tension.png": "tension along the rods in the last stored state",
}
"""What the files of runs and studies hold, but for tables."""
