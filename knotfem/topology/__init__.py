"""Knot theory of curves: knot types, links, and interpenetration of strands.

`closure` closes an open curve far away; `diagram` projects it; `simplify` and `reidemeister` reduce the number of its
vertices and crossings; `jones` computes the Jones polynomial and `knot_table` lists those of common knots. `knot_type`
and `linking` put these steps together for one curve and for two. `interpenetration` compares two states of a
simulation. Of the project, this package imports `knotfem.geometry`, `compiled`, `errors` and `types` only.
"""
