"""Where strands press on each other and what tension they bear, of several runs of one scene over each other.

Run with: python benchmarks/contact_map.py HEXAHEDRA RODS -o FIGURE.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rod_common import table

import knotfem as kf
from knotfem.contact.report import ContactReport
from knotfem.stability.crossings import crossings_of
from knotfem.types import Arrays

WIDTH = 1.5
"""Standard deviation by which the forces of contact samples are spread along the rod [mm]."""
LEAST = 0.01
"""Crossings that bear less of all normal force are left out."""


def per_length(c: Arrays, rod: str, s: np.ndarray) -> np.ndarray:
    """Normal force per length on a rod [N/mm], shape of `s` [mm], of a table of contacts."""
    total = np.zeros_like(s)
    for name, at in (("rod", "arclength_mm"), ("other", "other_arclength_mm")):
        on = c[name] == rod
        bells = np.exp(-0.5 * ((s[:, None] - c[at][on]) / WIDTH) ** 2) / (WIDTH * np.sqrt(2.0 * np.pi))
        total += bells @ c["normal_force_N"][on]
    return total


def centres_of(c: Arrays, rods: list[str], diameter: float) -> np.ndarray:
    """Arclengths of the crossings of the first rod with the last, on both [mm], shape [crossings, 2]."""
    number, none = {name: i for i, name in enumerate(rods)}, np.zeros(len(c["rod"]))
    rod, other = (np.array([number[name] for name in c[column]]) for column in ("rod", "other"))
    places, force = (c["arclength_mm"], c["other_arclength_mm"]), c["normal_force_N"]
    slides, normal = c["state"] == "slips", np.zeros((len(none), 3))
    report = ContactReport(rod, places[0], other, places[1], none, normal, force, c["friction_force_N"], slides)
    found = [crossing for crossing in crossings_of(report, diameter) if crossing.rods == (0, len(rods) - 1)]
    total = sum(crossing.force for crossing in found)
    return np.array([crossing.places for crossing in found if crossing.force > LEAST * total])


def at_crossings(c: Arrays, rods: list[str], centres: np.ndarray) -> list[tuple[float, ...]]:
    """For each crossing: normal force, friction [N], and where they act on the first and the last rod [mm].

    Args:
        c: table of contacts.
        rods: their names.
        centres: arclengths on both by which contacts are told apart [mm], shape [crossings, 2].
    """
    on, back = ((c["rod"] == a) & (c["other"] == b) for a, b in ((rods[0], rods[-1]), (rods[-1], rods[0])))
    there = np.stack((c["arclength_mm"], c["other_arclength_mm"]), axis=1)
    forces = np.stack((c["normal_force_N"], c["friction_force_N"]), axis=1)
    at, force = np.concatenate((there[on], there[back][:, ::-1])), np.concatenate((forces[on], forces[back]))
    nearest = np.argmin(np.linalg.norm(at[:, None] - centres, axis=2), axis=1)
    rows = []
    for crossing in range(len(centres)):
        here = nearest == crossing
        rows.append((*force[here].sum(axis=0), *np.average(at[here], axis=0, weights=force[here, 0])))
    return rows


def main() -> None:
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("contact-map.png"))
    args = parser.parse_args()
    runs = [kf.open_run(folder) for folder in args.runs]
    contacts = [run.contacts() for run in runs]
    rods = sorted(set(contacts[0]["rod"].tolist()))
    figure, axes = plt.subplots(2, len(rods), sharex="col", sharey="row", figsize=(9.0, 5.0), squeeze=False)
    for column, rod in zip(axes.T, rods, strict=True):
        for run, c, folder in zip(runs, contacts, args.runs, strict=True):
            profile = run.tension().of(rod)
            s = profile.arclength
            fine = np.linspace(s.min(), s.max(), 800)
            column[0].plot(fine, 1e3 * per_length(c, rod, fine), label=folder.name)
            column[1].plot(s, profile.tension)
        column[0].set_title(f"rod {rod}")
        column[1].set_xlabel("arclength [mm]")
    axes[0, 0].set_ylabel("normal force [N/m]")
    axes[1, 0].set_ylabel("tension [N]")
    axes[0, 0].legend()
    figure.tight_layout()
    figure.savefig(args.out, dpi=150)
    centres = centres_of(contacts[-1], rods, min(rod.diameter for rod in runs[-1].scene.rods))
    heads = ("normal force, N", "friction, N", f"on {rods[0]}, mm", f"on {rods[-1]}, mm")
    for c, folder in zip(contacts, args.runs, strict=True):
        table(str(folder), heads, at_crossings(c, rods, centres))


if __name__ == "__main__":
    main()
