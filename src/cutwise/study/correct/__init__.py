"""Tolerance in, program out: what to change of a program and its settings, proved by another simulation.

* ``table.py``: which function corrects what, the one table (process, change) -> function. **To add a correction, write a
  module beside these with one function and add its row there.**
* ``outcome.py``: what goes into such a function (:class:`~cutwise.study.correct.outcome.Task`), what comes out of it
  (:class:`~cutwise.study.correct.outcome.Proposal`), and what the user gets
  (:class:`~cutwise.study.correct.outcome.Corrected`).
* ``entry.py``: :func:`cutwise.correct`: refuses what is not there, runs before, asks the functions one after the other in
  the order of the table, each with what the last has left, runs after, and judges.
* ``objective.py``: what is made least (time, cost, error within a time); ``front.py``: programs of several budgets;
  ``told.py``: what is said of a schedule, and what it misses.
* ``limits.py``: what a run is held to, from ``correct.limits`` and the requirements.
"""
