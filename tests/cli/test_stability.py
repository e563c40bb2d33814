"""Details of `knotfem stability`."""

from pathlib import Path

from knotfem_cli.stability import named


def test_studies_in_folders_of_one_name_are_told_apart():
    a, b, c = Path("a/out"), Path("b/out"), Path("c/other")
    assert named([a, b, c]) == {"a/out": a, "b/out": b, "other": c}
