"""Programs of machines: G-code read into moves, and tool paths written as G-code, APT and robot poses."""
