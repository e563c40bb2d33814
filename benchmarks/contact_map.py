"""Where strands press on each other and what tension they bear, of several runs of one scene over each other.

Run with: python benchmarks/contact_map.py HEXAHEDRA RODS -o FIGURE.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rod_common import table
from scipy.cluster.hierarchy import fcluster, linkage

import knotfem as kf

WIDTH = 1.5
"""Standard deviation by which the forces of contact samples are smeared along the rod [mm]."""
PLACE = 3.0
"""Contacts of two strands closer along both belong to one place [mm]."""


def per_length(run: kf.Run, rod: str, s: np.ndarray) -> np.ndarray:
    """Normal force per length on a rod [N/mm], shape of `s` [mm]."""
    c = run.contacts()
    total = np.zeros_like(s)
    for name, at in (("rod", "arclength_mm"), ("other", "other_arclength_mm")):
        on = c[name] == rod
        bells = np.exp(-0.5 * ((s[:, None] - c[at][on]) / WIDTH) ** 2) / (WIDTH * np.sqrt(2.0 * np.pi))
        total += bells @ c["normal_force_N"][on]
    return total


def between(run: kf.Run) -> tuple[np.ndarray, np.ndarray]:
    """Contacts of first and last rod: arclengths on both [mm], normal force and friction [N], each [n, 2]."""
    c = run.contacts()
    first, last = min(c["rod"]), max(c["rod"])
    on, back = ((c["rod"] == a) & (c["other"] == b) for a, b in ((first, last), (last, first)))
    there = np.stack((c["arclength_mm"], c["other_arclength_mm"]), axis=1)
    force = np.stack((c["normal_force_N"], c["friction_force_N"]), axis=1)
    return np.concatenate((there[on], there[back][:, ::-1])), np.concatenate((force[on], force[back]))


def centres_of(run: kf.Run) -> np.ndarray:
    """Places of contact, arclengths on both rods [mm], shape [places, 2], in the order of the first rod."""
    at, force = between(run)
    place = fcluster(linkage(at, "single"), PLACE, "distance")
    heavy = [k for k in range(1, place.max() + 1) if force[place == k, 0].sum() > 0.01 * force[:, 0].sum()]
    centres = np.array([np.average(at[place == k], axis=0, weights=force[place == k, 0]) for k in heavy])
    return centres[np.argsort(centres[:, 0])]


def places(run: kf.Run, centres: np.ndarray) -> list[tuple[float, ...]]:
    """For each place: normal force, friction [N], and where they act on both rods [mm].

    Args:
        run: of two rods.
        centres: arclengths on both by which contacts are told apart [mm], shape [places, 2].
    """
    at, force = between(run)
    nearest = np.argmin(np.linalg.norm(at[:, None] - centres, axis=2), axis=1)
    rows = []
    for place in range(len(centres)):
        here = nearest == place
        rows.append((*force[here].sum(axis=0), *np.average(at[here], axis=0, weights=force[here, 0])))
    return rows


def main() -> None:
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("contact-map.png"))
    args = parser.parse_args()
    runs = [kf.open_run(folder) for folder in args.runs]
    rods = sorted(set(runs[0].contacts()["rod"]))
    figure, axes = plt.subplots(2, len(rods), sharex="col", sharey="row", figsize=(9.0, 5.0), squeeze=False)
    for column, rod in zip(axes.T, rods, strict=True):
        for run, folder in zip(runs, args.runs, strict=True):
            profile = run.tension().of(rod)
            s = profile.arclength
            fine = np.linspace(s.min(), s.max(), 800)
            column[0].plot(fine, 1e3 * per_length(run, rod, fine), label=folder.name)
            column[1].plot(s, profile.tension)
        column[0].set_title(f"rod {rod}")
        column[1].set_xlabel("arclength [mm]")
    axes[0, 0].set_ylabel("normal force [N/m]")
    axes[1, 0].set_ylabel("tension [N]")
    axes[0, 0].legend()
    figure.tight_layout()
    figure.savefig(args.out, dpi=150)
    centres = centres_of(runs[-1])
    for run, folder in zip(runs, args.runs, strict=True):
        heads = ("normal force, N", "friction, N", f"on {rods[0]}, mm", f"on {rods[-1]}, mm")
        table(str(folder), heads, places(run, centres))


if __name__ == "__main__":
    main()
