"""Where the tool is told to be, and where drives and axes put it."""
