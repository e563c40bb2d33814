"""Centrelines: read, interpolate, smooth, resample, frame, measure, check, and name the knot.

Modules, each usable alone: `curve` and `nurbs` (files to smooth curves), `smoothing`, `resample`, `frames`, `measures`,
`validate`, `closure` (ends extended far away, linking number), `diagram`, `simplify`, `reidemeister`, `jones`,
`knot_type` (from polyline to name) and `passage` (strands that went through each other).
"""
