"""What the engineer says: frozen pydantic models, unknown keys refused, units required."""
