"""Parameters from measurements: one fit and one set of statistics for every kind; a kind is a row of :mod:`kinds`."""
