"""A deck that we export, run by CalculiX, against our own solution of the same problem."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from specimens import make_rod, moduli, static

from knotfem.mesh.deck import Solid, Springs, deck
from knotfem.mesh.export import ExportMesh, rod_blocks, rod_sets, write_mesh
from knotfem.mesh.rod import RodMesh
from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.verify.benchmarks.rods import bent_into_arc

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")

LENGTH, YOUNGS, POISSON = 60.0, 1.25, 0.49


def plate(mesh: RodMesh, angle: float) -> np.ndarray:
    """Places of the end section as a rigid plate on a circular arc of the rod's length."""
    c, s, radius = np.cos(angle), np.sin(angle), LENGTH / angle
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    centre = np.array([radius * (1.0 - c), 0.0, radius * s])
    return centre + (mesh.nodes[mesh.section_nodes[-1]] - [0.0, 0.0, LENGTH]) @ turn.T


def run_ccx(mesh: RodMesh, folder: Path, stages: list[np.ndarray], core: float = 0.0) -> np.ndarray:
    """Force and moment about the origin on the clamped section at the end, shape [6]."""
    far, blocks = mesh.section_nodes[-1], rod_blocks(mesh)
    materials: list[Solid | Springs] = [Solid("bulk", *moduli(YOUNGS, POISSON), 1.16e-9)]
    if core:
        materials.append(Springs("core", core / mesh.element_length))
    else:
        blocks = [block for block in blocks if block.group != "core"]
    steps = [dict(zip(far.tolist(), places - mesh.nodes[far], strict=True)) for places in stages]
    cards = deck(materials, ["start"], steps, increment=0.5)
    write_mesh(ExportMesh(mesh.nodes, blocks, node_sets=rod_sets(mesh), cards=cards), folder / "rod.inp")
    done = subprocess.run(["ccx", "-i", "rod"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    last = re.split(r"for set START and time.*", (folder / "rod.dat").read_text())[-1]
    rows = np.array([[float(x) for x in line.split()] for line in last.splitlines() if line.strip()])
    nodes, force = rows[:, 0].astype(int) - 1, rows[:, 1:]
    assert sorted(nodes) == mesh.section_nodes[0].tolist()
    return np.concatenate([force.sum(axis=0), np.cross(mesh.nodes[nodes], force).sum(axis=0)])


def bent(angle: float, element: str) -> float:
    """Our own moment at the clamp on the paper's mesh."""
    rod = make_rod(LENGTH, 60, section=44, element=element, youngs=YOUNGS, poisson=POISSON, match_bending=False)
    near, far = rod.sections[0], rod.sections[-1]
    goal = plate(rod.mesh, angle)
    ends = [held(near, rod.mesh.nodes[near]), Prescribed(far, lambda time: goal)]
    x, system, _ = static(
        rod.terms, bent_into_arc(rod, angle), ends, Sections.single(rod.section_of_node), tolerance=1e-7
    )
    return float(np.cross(x[near], system.residual(x)[near]).sum(axis=0)[1])


def test_pulled_rod_with_a_core(tmp_path):
    rod = make_rod(LENGTH, 20, section=4, element="hex8-incompatible", youngs=YOUNGS, poisson=POISSON)
    stretched = rod.mesh.nodes[rod.mesh.section_nodes[-1]] + [0.0, 0.0, 0.3]
    found = run_ccx(rod.mesh, tmp_path, [stretched], core=3826.0)
    expected = (3826.0 + YOUNGS * rod.area) * 0.3 / LENGTH
    np.testing.assert_allclose(found[:3], [0.0, 0.0, -expected], atol=0.01 * expected)


def test_bending_moment(tmp_path):
    angle = np.pi / 6.0
    rod = make_rod(LENGTH, 60, section=44, element="hex8", match_bending=False)
    found = run_ccx(rod.mesh, tmp_path, [plate(rod.mesh, angle)])
    assert found[4] == pytest.approx(bent(angle, "hex8-incompatible"), rel=0.01)
    np.testing.assert_allclose(found[[0, 1, 2, 3, 5]], 0.0, atol=0.01 * abs(found[4]))


@pytest.mark.slow
def test_bending_moment_at_a_right_angle(tmp_path):
    angle = np.pi / 2.0
    rod = make_rod(LENGTH, 60, section=44, element="hex8", match_bending=False)
    found = run_ccx(rod.mesh, tmp_path, [plate(rod.mesh, a) for a in np.linspace(0.0, angle, 7)[1:]])
    assert found[4] == pytest.approx(bent(angle, "hex8"), rel=0.01)
    assert found[4] == pytest.approx(bent(angle, "hex8-incompatible"), rel=0.01)
    assert abs(found[4]) == pytest.approx(2.031, rel=0.01)
