"""Pulls three knots in memory and draws their force curves and tensions over each other."""

import matplotlib.pyplot as plt

import knotfem as kf

figure, (force, tension) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for name in ("overhand", "figure-eight", "clove-hitch"):
    run = kf.pull(name, {"model": "rod", "steps.pull.displacement": "20 mm"})
    run.force.plot(force, label=f"{name}, {run.cost.cpu_s:.1f} CPU s")
    run.tension().plot(tension, label=name)
force.legend()
figure.savefig("three_knots.png")
