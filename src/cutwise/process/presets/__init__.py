"""One file a process: the methods by which it is run, and their readings."""
