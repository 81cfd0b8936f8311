"""Which part of the tool is in the material."""
