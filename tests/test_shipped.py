"""Shipped files are found by name, wherever the program is installed."""

import pytest

from knotfem import shipped
from knotfem.errors import InputError


def test_names_and_files_agree() -> None:
    assert {"bowline", "bowline-paper", "overhand", "cantilever", "crossed-rods"} <= set(shipped.scene_names())
    assert {"bowline", "overhand", "straight"} <= set(shipped.centreline_names())
    assert {12, 44, 48} <= set(shipped.section_counts())
    assert all(shipped.scene_path(name).is_file() for name in shipped.scene_names())
    assert all(shipped.centreline_path(name).is_file() for name in shipped.centreline_names())
    assert all(shipped.section_path(count).is_file() for count in shipped.section_counts())
    assert shipped.section_counts() == sorted(shipped.section_counts())


def test_every_centreline_has_a_title() -> None:
    assert all(shipped.centreline_title(name) for name in shipped.centreline_names())


def test_unknown_names_are_refused_with_the_closest() -> None:
    with pytest.raises(InputError, match='found "bowlin"; expected "bowline"'):
        shipped.scene_path("bowlin")
    with pytest.raises(InputError, match='expected "figure_eight"'):
        shipped.centreline_path("figure-eight")
    with pytest.raises(InputError, match="found 13; expected one of 4, 12"):
        shipped.section_path(13)
