r"""The view file: a header in JSON and arrays behind it, small enough to travel inside a page.

``CWVIEW1\n``, the length H of the header (uint32, little endian), the header in UTF-8, padded with blanks so that 12 + H is
a multiple of 8, then the arrays, each at a multiple of 8 from there. The same run gives the same bytes.
"""

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

MAGIC = b"CWVIEW1\n"
MISSING = 65535  # of a quantised history
_STEPS = 65534


class Quantised(NamedTuple):
    """A history in 16 bits: value = zero + scale * q; 65535 where there is no value."""

    q: npt.NDArray[np.uint16]
    zero: float
    scale: float


class Array(NamedTuple):
    """An array of the view file, and what it says to people; a history is quantised, everything else is kept as it is."""

    values: npt.NDArray[Any]
    dtype: str = "u2"  # u2: quantised; u1, u4, f4, f8: as it is
    title: str = ""
    unit: str = ""
    factor: float = 1.0  # value times factor is what people read, in the unit


def quantised(values: npt.ArrayLike) -> Quantised:
    """Values in 65,535 steps between the least and the largest.

    Parameters
    ----------
    values : array
        Numbers in any unit; what is not finite is missing.

    Returns
    -------
    Quantised
        Off by at most half a step, 7.63e-6 of the range.

    Examples
    --------
    >>> quantised([0.0, 1.0, 2.5, float("nan"), 1.0]).q.tolist()
    [0, 26214, 65534, 65535, 26214]
    """
    given = np.asarray(values, float)
    known = np.isfinite(given)
    q = np.full(given.shape, MISSING, np.uint16)
    if not known.any():
        return Quantised(q, 0.0, 0.0)
    low, high = float(given[known].min()), float(given[known].max())
    scale = (high - low) / _STEPS
    if scale > 0.0:
        q[known] = np.clip(np.rint((given[known] - low) / scale), 0, _STEPS).astype(np.uint16)
    else:
        q[known], scale = 0, 0.0
    return Quantised(q, low, scale)


def delta_bytes(q: npt.NDArray[np.uint16]) -> bytes:
    """The first number and the differences modulo 2**16: all low bytes, then all high bytes.

    Examples
    --------
    >>> delta_bytes(np.array([0, 26214, 65534, 65535, 26214], np.uint16)).hex()
    '00669801670066990066'
    """
    flat = np.ascontiguousarray(q, np.uint16).reshape(-1)
    steps = np.diff(flat, prepend=np.uint16(0)).astype("<u2")  # differences of uint16 are taken modulo 2**16
    return (steps & 0xFF).astype(np.uint8).tobytes() + (steps >> 8).astype(np.uint8).tobytes()


def pack(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """The view file of a header without its arrays, and the arrays by name."""
    bodies, told, offset = [], {}, 0
    for name, array in arrays.items():
        body, entry = _coded(array)
        told[name] = {"offset": offset, "bytes": len(body), **entry, "title": array.title}
        told[name] |= {"unit": array.unit, "factor": array.factor}
        bodies.append(body + bytes(-len(body) % 8))
        offset += len(bodies[-1])
    text = json.dumps({**header, "arrays": told}, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    head = text.encode("utf-8", errors="replace")
    head += b" " * (-(12 + len(head)) % 8)
    return b"".join([MAGIC, len(head).to_bytes(4, "little"), head, *bodies])


def _coded(array: Array) -> tuple[bytes, dict[str, Any]]:
    shape = list(np.shape(array.values))
    if array.dtype == "u2":
        found = quantised(array.values)
        entry = {"zero": found.zero, "scale": found.scale, "coding": "delta"}
        return delta_bytes(found.q), {"dtype": "u2", "shape": shape, **entry}
    body = np.ascontiguousarray(array.values).astype(f"<{array.dtype}", casting="unsafe").tobytes()
    return body, {"dtype": array.dtype, "shape": shape, "zero": 0.0, "scale": 1.0, "coding": "plain"}


def deflated(content: bytes) -> bytes:
    """A view file as it travels: raw deflate, which a browser inflates by itself."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    return packer.compress(content) + packer.flush()


def as_text(content: bytes) -> str:
    """A view file as text for a page: base64 of its deflated bytes, so that no text of a user can end the element."""
    return base64.b64encode(deflated(content)).decode("ascii")
