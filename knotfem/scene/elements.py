"""Elements of hexahedral rods, by name."""

from __future__ import annotations

ORDERS = {"hex8": 1, "hex8-reduced": 1, "hex8-incompatible": 1, "hex27": 2}
"""Order of each element: 2 has nodes on edges, faces and inside, and spans two slices."""
