"""View files read back, as the browser reads them."""

import json

import numpy as np

_KINDS = {"u1": "<u1", "u2": "<u2", "u4": "<u4", "f4": "<f4", "f8": "<f8"}


def header_of(content):
    """The header, and where the arrays begin."""
    assert content[:8] == b"CWVIEW1\n"
    length = int.from_bytes(content[8:12], "little")
    assert (12 + length) % 8 == 0
    return json.loads(content[12 : 12 + length]), 12 + length


def read(content):
    """Header and values of a view file; what is missing is NaN."""
    header, start = header_of(content)
    found = {}
    for name, entry in header["arrays"].items():
        assert entry["offset"] % 8 == 0
        body = content[start + entry["offset"] : start + entry["offset"] + entry["bytes"]]
        if entry["coding"] == "delta":
            half = len(body) // 2
            low, high = (
                np.frombuffer(body[:half], np.uint8).astype(int),
                np.frombuffer(body[half:], np.uint8).astype(int),
            )
            q = np.cumsum(low + 256 * high) % 65536
            values = np.where(q == 65535, np.nan, entry["zero"] + entry["scale"] * q)
        else:
            values = np.frombuffer(body, _KINDS[entry["dtype"]])
        found[name] = values.reshape(entry["shape"])
    return header, found
