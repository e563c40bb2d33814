"""gmsh, meshio and scikit-fem are imported by the runs that need them, and by no other."""

import json
import subprocess
import sys

import pytest

PACKAGES = {"skfem", "meshio", "gmsh"}
PROGRAM = """
import json, sys
import knotfem as kf
changes = ["rods.0.mesh.element_length=8 mm", "steps.0.duration=0.05 s", "solver.threads=1", *json.loads(sys.argv[1])]
kf.pull("cantilever", changes, progress=False)
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""


@pytest.mark.parametrize(
    ("changes", "needed"),
    [
        (["model=rod"], set()),
        (["rods.0.mesh.section_elements=5"], {"skfem", "meshio"}),
        (["rods.0.mesh.section_elements=32", "output.fields=false"], {"skfem", "gmsh"}),
    ],
    ids=["rod", "shipped", "made"],
)
def test_a_run_imports_what_it_needs(changes, needed):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(changes)], capture_output=True, text=True, check=True
    )
    assert set(json.loads(done.stdout.splitlines()[-1])) & PACKAGES == needed
