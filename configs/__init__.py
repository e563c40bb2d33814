"""Shipped scenes, found through `knotfem.shipped`."""
