"""Shipped knot centrelines and cross-section meshes, found through `knotfem.shipped`."""
