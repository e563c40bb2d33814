"""Pieces that slices are cut into for samples, and how much arclength each sample stands for.

The rate of arclength with the coordinate in segments is linear from the middle of a slice to the next and constant
beyond the first and the last (see `knotfem.contact.stations`), so that half pieces are integrated by their middles.
"""

from __future__ import annotations

import numpy as np

from knotfem.geometry.slices import Slices


def middles(slices: Slices, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the pieces of a rod in segments, and the arclength that each stands for [mm], shape [samples] each.

    Args:
        slices: of the rod.
        spacing: largest length of a piece [mm].
    """
    slice_of, many, within = _pieces(slices, spacing)
    u, quarter = (slice_of * many + within + 0.5) / many, 0.25 / many
    return u, 0.5 * (_rate(slices, u - quarter) + _rate(slices, u + quarter)) / many


def borders(slices: Slices, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Borders of the pieces of a rod, ends included; see `middles`. Each stands for half a piece on either side."""
    slice_of, many, within = _pieces(slices, spacing)
    u = (slice_of * many + within) / many
    ahead, behind = _rate(slices, u + 0.25 / many) / many, _rate(slices, u + 0.75 / many) / many
    return np.append(u, float(slices.count)), 0.5 * (np.append(ahead, 0.0) + np.append(0.0, behind))


def _pieces(slices: Slices, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slice of each piece, the number of pieces of this slice, and the place among them, shape [pieces] each."""
    sections = _rate(slices, np.arange(slices.count + 1.0))
    fastest = np.maximum(slices.lengths, np.maximum(sections[:-1], sections[1:]))
    pieces = np.maximum(1, np.ceil(fastest / spacing - 1e-9)).astype(np.int64)
    slice_of = np.repeat(np.arange(slices.count), pieces)
    return slice_of, pieces[slice_of], np.arange(slice_of.size) - (np.cumsum(pieces) - pieces)[slice_of]


def _rate(slices: Slices, u: np.ndarray) -> np.ndarray:
    return np.interp(u, np.arange(slices.count) + 0.5, slices.lengths)
