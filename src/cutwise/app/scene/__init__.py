"""What the page shows of a run: the scene in millimetres, its colours, its worst places, and the one file that holds it."""
