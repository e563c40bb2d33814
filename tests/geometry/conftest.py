from curve_fixtures import random_curve, rigid, shipped

__all__ = ["random_curve", "rigid", "shipped"]
