"""Geometry of curves in space: centrelines from file to polyline, frames, rotations, measures and checks.

`readers` reads centreline files into the curves of `curve` and `nurbs`; `resample` and `smoothing` make polylines of
them; `points`, `vectors`, `measures`, `writhe`, `clearance` and `segments` measure them; `frames` attaches orthonormal
frames; `validate` checks that a rod can take the shape. Rotations of arrays stand in `finite_rotation`, their kernels
for compiled loops in `rotation`. Of the project, this package imports `compiled`, `errors` and `types` only.
"""
