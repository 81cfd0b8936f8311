"""Studies of many cases: what varies, the numbers that are drawn, chunks on disk, and what they say together."""
