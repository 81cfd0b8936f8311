"""Scenario files, library look-up, tables, CAD, programs and measurements."""
