"""Paths of a ball that leaves a chamfer of constant width: planned, proved, led to and away, round corners."""
