"""Constants that are the same everywhere."""

GRAVITY = 9.80665  # [m/s^2] standard acceleration of free fall
