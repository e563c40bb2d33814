"""Does the knot hold: crossings in contact, travel through them, the locking unit, the verdict, the failure mode."""
