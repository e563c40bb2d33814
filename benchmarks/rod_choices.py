"""What the choices of the reduced model do to the force of knots, one at a time, and what they cost.

The bowline round its cylinder, pulled by 99 mm, and knots of the user's own: stiffness of contact, stick distance and
ramp of contact, length of segments, of load steps and of steps in which the rods settle. The reef knot of two rods at
mu = 0.5 has the most sensitive force of all knots tried so far.

Run with: python benchmarks/rod_choices.py [SCENE.toml] ...
"""

from __future__ import annotations

import sys

from rod_common import table

import knotfem as kf

CHOICES = {
    "contact.line_stiffness_over_hertz": (1.0, 10.0, 30.0, 100.0, 300.0),
    "contact.stick_over_diameter": (0.02, 0.01, 0.005, 0.0025),
    "contact.ramp_over_diameter": (1 / 15, 1 / 30, 1 / 60),
    "contact.onset_over_ramp": (0.5, 0.25),
    "contact.sample_spacing_over_diameter": (0.125, 0.0625),
    "solver.move_over_diameter": (0.5, 0.1),
    "solver.force_tolerance": ("1e-4 N", "1e-5 N", "1e-6 N"),
    "quasi_static.tolerance": (0.001, 0.0001, 0.00001),
    "quasi_static.settling_slip_over_diameter": (0.1, 0.02, 0.004),
    "slices": (3.0, 2.0, 1.5, 1.0),
}


def measure(scene: str, key: str, value: float | str) -> tuple[float, ...]:
    """Force at the end, deepest penetration over the diameter, cutbacks, iterations and CPU seconds."""
    rods = len(kf.load_scene(scene).rods)
    changed = {f"rods.{i}.mesh.element_length": f"{value} mm" for i in range(rods)} if key == "slices" else {key: value}
    run = kf.pull(scene, {"model": "rod", "output.fields": False, **changed}, progress=False)
    cost, s = run.cost, run.summary
    return run.force.force[-1], s["max_penetration_over_d"], s["cutbacks"], cost.newton_iterations, cost.cpu_s


def main() -> None:
    scenes = {"bowline": "bowline", **{path: path for path in sys.argv[1:]}}
    for key, values in CHOICES.items():
        for name, scene in scenes.items():
            rows = [(value, *measure(scene, key, value)) for value in values]
            table(f"{name}: {key}", ("value", "F/N", "depth/d", "cutbacks", "iterations", "CPU s"), rows)


if __name__ == "__main__":
    main()
