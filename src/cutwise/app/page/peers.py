"""Who is at the other end of a connection: other users of this machine see its ports too."""

import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

_TABLES = ("/proc/net/tcp", "/proc/net/tcp6")
_MAPPED = "0000000000000000FFFF0000"  # an IPv4 address in the table of IPv6
_ROOT = 0


def known() -> bool:
    """Whether this system tells the user at the far end of a local connection."""
    return sys.platform == "linux" and os.access(_TABLES[0], os.R_OK)


def same_user(client: tuple[str, int], server: tuple[str, int]) -> bool:
    """Whether a local connection was opened by the user of this process, or by root.

    Parameters
    ----------
    client, server : tuple
        Address and port of the far and of the near end (IPv4).

    Notes
    -----
    A connection whose process has let go of it has no owner any more (inode 0) and counts as that of a stranger.
    """
    return any(uid in (os.getuid(), _ROOT) for uid in _owners(_written(*client), _written(*server)))


def _owners(near: str, far: str, tables: tuple[str, ...] = _TABLES) -> Iterator[int]:
    """Users of the sockets between two ends, as the tables of the kernel write them."""
    for table in tables:
        try:
            lines = Path(table).read_text(encoding="ascii").splitlines()[1:]
        except OSError:
            continue
        for line in lines:
            fields = line.split()
            ends = [end.removeprefix(_MAPPED) for end in fields[1:3]]
            if ends == [near, far] and fields[9] != "0":
                yield int(fields[7])


def _written(address: str, port: int) -> str:
    """An end as ``/proc/net/tcp`` writes it: ``127.0.0.1``, 80 is ``0100007F:0050`` on most machines."""
    return f"{int.from_bytes(socket.inet_aton(address), sys.byteorder):08X}:{port:04X}"
