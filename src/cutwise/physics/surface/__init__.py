"""What the tool leaves behind."""
