"""Which force the material puts on the tool."""
