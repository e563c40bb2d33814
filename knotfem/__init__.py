"""knotfem: knots in elastic rods, tied, pulled and read out from one command."""

__version__ = "0.1.0"
