"""A program, its worker and its guard are frozen, suspended or killed: see `.ci/freeze-matrix`."""
