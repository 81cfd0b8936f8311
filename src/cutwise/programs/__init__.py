"""Programs of CNC machines: G-code read into moves."""
