"""Frames, chains, curves, stepping and contact: knows nothing of machining."""
