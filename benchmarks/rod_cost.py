"""Cost by the number of segments: the loose bowline, pulled by 3 mm, from 150 to 2400 segments.

The rod, the scene and the path are the same; CPU seconds and Newton iterations are counted, and the slope of seconds
per iteration over segments is fitted, over all and from 600 on (1: linear).

Run with: python benchmarks/rod_cost.py
"""

from __future__ import annotations

import time

import numpy as np
from rod_common import bowline, table

import knotfem as kf

SOLVER = ("analysis", "factorisation", "solve")


def measure(segments: int) -> tuple[float, ...]:
    """Segments, iterations of the pull, its CPU seconds, milliseconds per iteration and the solver's fraction."""
    began, count, solving = time.process_time(), 0, 0.0
    scene = bowline(segments, **{"steps.pull.displacement": "3 mm"})
    for step in kf.steps("bowline", scene):
        if step.step.name == "relax":
            began = time.process_time()
        else:
            count += step.accepted.solution.iterations
            solving = sum(step.system.clock.cpu.get(name, 0.0) for name in SOLVER)
    spent = time.process_time() - began
    return segments, count, spent, 1e3 * spent / count, solving / spent


def main() -> None:
    measure(150)
    rows = [measure(segments) for segments in (150, 300, 600, 1200, 2400)]
    table("cost", ("segments", "iterations", "CPU s", "ms/iteration", "solver's fraction"), rows)
    n, ms = np.log(np.array(rows)[:, [0, 3]].T)
    for since in (0, 2):
        power = np.polyfit(n[since:], ms[since:], 1)[0]
        print(f"from {rows[since][0]} on seconds per iteration grow with segments to the power {power:.2f}")


if __name__ == "__main__":
    main()
