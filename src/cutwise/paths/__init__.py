"""Tool paths: chamfer, deburr, pocket, drill cycle."""
