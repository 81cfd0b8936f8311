"""How spindle, machine and robot yield to that force."""
