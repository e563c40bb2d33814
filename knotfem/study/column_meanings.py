"""What the columns of a study's tables are; see `knotfem.run.column_meanings` for those of runs."""

from __future__ import annotations

STABILITY_KEYS = {
    "model": '"fem" or "rod"',
    "protocol": '"kept": friction stays what it was when the knot was tied; "lowered": it falls once ends are let go',
    "friction": "coefficient between rods; where it is lowered, that with which the knot is tied",
    "x": "bending stiffness over load and radius squared, B/(T0 r^2)",
    "tension_N": "load T0",
}
"""Values of a point of a stability study."""
JUDGED = {
    "state": '"done", "failed", "stopped" or "waiting"',
    "verdict": '"holds", "slips", "unravels" or "undecided"; empty for a run without one',
    "failure_mode": 'what slips first in a knot that fails: "wrapping", "central" or "none"',
    "reason": "why a run has failed or was stopped",
}
"""How the run of a point ended; in every study."""
STABILITY_FIGURES = {
    "knot_before": "knot as it was tied, before the load acted",
    "rests": "whether the rods came to rest under the load",
    "onset_friction": "friction at which strands began to slip; empty where none did",
    "lost_friction": "friction at which the knot was lost; empty where it was not",
    "lost": "what came undone; empty where nothing did",
}
"""What a stability study collects of each run."""
TABLES = {
    "study": {
        "point": "name of the point, that of its run directory below runs/",
        **STABILITY_KEYS,
        **JUDGED,
        **STABILITY_FIGURES,
    },
    "boundary": {
        "model": '"fem" or "rod"',
        "protocol": '"kept": from points at each friction; "lowered": from runs whose friction falls',
        "x": "bending stiffness over load and radius squared, B/(T0 r^2)",
        "tension_N": "load T0",
        "friction": "friction from which on the knot holds: the middle of the bracket",
        "low": "lower end of the bracket: largest friction at which the knot does not hold",
        "high": "upper end of the bracket: smallest friction above at which it holds; the onset where it is lowered",
        "monotone": "1 where the knot holds at no friction below the bracket, else 0",
    },
}
"""Columns and their meanings, by table."""
ROWS = {
    "study": (
        "a point of a study, here of knotfem stability; knotfem sweep has the keys of its axes between point and "
        "state, and what it collects behind reason"
    ),
    "boundary": "a model, protocol and load of a stability study at which the verdict changes",
}
"""What a row is, by table."""
