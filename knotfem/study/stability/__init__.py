"""Does a knot hold? Verdicts over friction and load: `grid` makes the points, `boundary` finds where the verdict
changes, `diagram` holds the results, `run` is the verb."""
