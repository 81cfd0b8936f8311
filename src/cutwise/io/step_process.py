"""Reading STEP files in a process of their own: one for the whole run, begun again after a file that ended it."""

import atexit
import json
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

from cutwise.io.occ import CadFault, occ
from cutwise.io.step_reader import allowed

_COMMAND = "from cutwise.io.step_reader import serve; serve()"
_ENDED = "reading it ended the reader of OpenCascade: the file is damaged; export it again (AP203, AP214 or AP242)"


class Reader:
    """A process that reads STEP files, started when it is first needed and kept: its start costs 0.6 CPU s."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._owner = 0
        self._lock = threading.Lock()

    def start(self) -> None:
        """Start the process, if it does not run; returns at once."""
        if self._owner == os.getpid() and self._process is not None and self._process.poll() is None:
            return
        paths = os.pathsep.join(path for path in sys.path if path)
        self._process = subprocess.Popen(
            [sys.executable, "-c", _COMMAND], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True, encoding="utf-8", env={**os.environ, "PYTHONPATH": paths},
            start_new_session=True,  # an interrupt is for the run, which ends its reader itself
        )  # fmt: skip
        if not self._owner:
            atexit.register(self.stop)
        self._owner = os.getpid()

    def stop(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        process.communicate()

    def ask(self, request: dict[str, Any], size: int) -> dict[str, Any]:
        """Have a file of some bytes read.

        Raises
        ------
        CadFault
            The process ended over it.
        """
        with self._lock:
            self.start()
            process = self._process
            assert process is not None
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                process.stdin.write(json.dumps(request) + "\n")
                process.stdin.flush()
                line = process.stdout.readline()
            except BrokenPipeError:
                line = ""
            except BaseException:  # interrupted: what it would still answer belongs to no one
                self.stop()
                raise
            if line:
                return dict(json.loads(line))
            code = process.wait()
            self.stop()
            raise CadFault(_why_ended(code, size))


READER = Reader()


def _why_ended(code: int, size: int) -> str:
    if os.name == "posix":
        import signal

        if code == -signal.SIGPROF:
            return f"reading it took more than {allowed(size):.0f} s of computing: the file is damaged or far too large"
    return _ENDED


def shape_of(file: Path, places: list[int]) -> tuple[Any, list[tuple[int, str]]]:
    """The shape of a STEP file, and the parameters that are of a wrong type; one of both.

    Parameters
    ----------
    file : Path
        The file.
    places : list of int
        Instances of the data section, counted from 0, that the shapes are made of.

    Raises
    ------
    CadFault
        It cannot be read or translated; the message does not name the file.
    """
    with tempfile.TemporaryDirectory(prefix="cutwise-step-") as folder:
        handed = Path(folder) / "shape"
        request = {"file": str(file.absolute()), "shape": str(handed), "places": places}
        answer = READER.ask(request, file.stat().st_size)
        if "fault" in answer:
            raise CadFault(answer["fault"])
        if "types" in answer:
            return None, [(place, said) for place, said in answer["types"]]
        shape = occ("TopoDS").TopoDS_Shape()
        if not occ("BinTools").BinTools.Read_s(shape, str(handed)) or shape.IsNull():
            raise CadFault("its shape could not be handed over (is the disk for temporary files full?)")
        return shape, []
