"""Command line, report and plots; no physics in here."""
