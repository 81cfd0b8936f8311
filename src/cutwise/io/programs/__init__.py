"""Programs for machines and robots."""
