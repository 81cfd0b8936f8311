"""Sweeps, uncertainty, optimisation and calibration over whole runs."""
