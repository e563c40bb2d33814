"""Cost by the number of segments: the loose bowline, pulled by 3 mm, from 150 to 2400 segments.

The rod, the scene and the path are the same; CPU seconds and Newton iterations are counted, and the slope of seconds
an iteration over segments is fitted, over all and from 600 on (1: linear).

Run with: python benchmarks/rod_cost.py
"""

from __future__ import annotations

import time

import numpy as np
from rod_common import UP, bowline, hold_ends, rest, table

from knotfem.models.rod.ends import driven
from knotfem.solver.stepping.integrator import StepControl


def measure(segments: int) -> tuple[float, ...]:
    """Segments, iterations of the pull, its CPU seconds, milliseconds an iteration and what part is the solver's."""
    model = bowline(0.33, segments)
    hold_ends(model)
    rest(model)
    since, before = model.time, model.progress.iterations
    way = driven(model.end_frame(0, "start"), UP, lambda now: 4.0 * (now - since))
    system = model.begin({(0, "start"): way})
    began = time.process_time()
    for _ in model.march(StepControl(0.025, 1e-6, 1.5, 3.0), model.settings(), [since + 0.75]):
        pass
    spent = time.process_time() - began
    count = model.progress.iterations - before
    solving = sum(system.clock.cpu.get(name, 0.0) for name in ("analysis", "factorisation", "solve"))
    return segments, count, spent, 1e3 * spent / count, solving / spent


def main() -> None:
    measure(150)
    rows = [measure(segments) for segments in (150, 300, 600, 1200, 2400)]
    table("cost", ("segments", "iterations", "CPU s", "ms/iteration", "solver's share"), rows)
    n, ms = np.log(np.array(rows)[:, [0, 3]].T)
    for since in (0, 2):
        power = np.polyfit(n[since:], ms[since:], 1)[0]
        print(f"from {rows[since][0]} on seconds an iteration grow with segments to the power {power:.2f}")


if __name__ == "__main__":
    main()
