"""What lies open: the text of a scenario, its runs, uploaded files; what is faulty, changed, saved."""

import hashlib
import re
import secrets
import threading
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cutwise.app.inputs import as_yaml
from cutwise.app.page import keys
from cutwise.app.writing import RUN
from cutwise.disk import create_bytes, create_text, file_name, write_bytes
from cutwise.io.edits import edited, with_edits
from cutwise.io.files import as_text, read_bytes
from cutwise.io.scenario import load, loaded, parse
from cutwise.later import later
from cutwise.process.recipes import prepare
from cutwise.results import Result
from cutwise.run_file import DamagedRun, is_netcdf
from cutwise.spec.faults import Fault, ScenarioFault, dotted
from cutwise.spec.scenario import Scenario
from cutwise.spec.texts import visible

if TYPE_CHECKING:
    from cutwise.app.scene import rows, view
else:  # scenes of all processes
    rows, view = later("cutwise.app.scene.rows"), later("cutwise.app.scene.view")

RUNS = Path("cutwise-runs")
_MOST_RUNS = 12  # that were made in the page and are not kept
_NAME = re.compile(r"[^./\\\x00-\x1f\x7f<>:\"|?*][^/\\\x00-\x1f\x7f<>:\"|?*]{0,199}\.yaml")
_DEVICE = re.compile(r"con|prn|aux|nul|(com|lpt)[0-9]", re.IGNORECASE)
_PLACED = 40  # edits whose faults are looked for in the changed text; with more they are told by their keys
_BOM = b"\xef\xbb\xbf"


def _for_any_disk(name: str) -> bool:
    """Whether a name is one on every system: without blanks at its ends, and none that Windows has for devices."""
    stem = name.partition(".")[0]
    return name.strip() == name and stem.strip() != "" and not _DEVICE.fullmatch(stem)


class Refused(Exception):
    """What was asked for cannot be done: a status of HTTP, and why."""

    def __init__(self, status: int, why: str) -> None:
        self.status, self.why = status, why
        super().__init__(why)


class Target(NamedTuple):
    """What a command line names: a file or folder, read once."""

    path: Path
    content: bytes
    kept: bool = False  # not the text of that file: a scenario as something else has kept it

    @property
    def is_run(self) -> bool:
        """Whether it is a run file."""
        return is_netcdf(self.content)


def target(named: Path) -> Target:
    """Read what is named: a scenario, a report, a run file, or the folder of a run.

    Raises
    ------
    ScenarioFault
        It cannot be read, or is nothing of the kind.
    """
    source = named / RUN if named.is_dir() else named
    return Target(source, read_bytes(source, str(source)))


def _readable(given: Target) -> None:
    """Fail at once where a run file is none, or damaged."""
    try:
        Result.from_bytes(given.content, loaded(given.content, given.path))
    except DamagedRun as damage:
        fault = Fault((), f"{damage}; name the {RUN} of a finished run", file=str(given.path))
        raise ScenarioFault([fault]) from None


class Desk:
    """The state of a page. Methods may be called from several threads."""

    def __init__(self, given: Target, others: tuple[Target, ...], folder: Path) -> None:
        self.folder = folder  # private and temporary
        self.lock = threading.RLock()
        self.runs: dict[int, Path] = {}
        self.uploads: dict[str, tuple[Path, str]] = {}
        self.shown: list[int] = []
        self._count = 0
        self._made: list[int] = []
        self.path = given.path
        self.name = visible(str(given.path), lines=False)
        self.is_file = not given.kept and not given.is_run and given.path.suffix.lower() not in (".html", ".htm")
        self._begin(given)
        if given.is_run:
            _readable(given)
            self.shown.append(self._adopted(given.content))
        for other in others:
            _readable(other)
            self.shown.append(self._adopted(other.content))
        if not self.shown and not given.kept and (fresh := self._fresh()) is not None:
            self.shown.append(self._adopted(fresh))

    def _begin(self, given: Target) -> None:
        content = given.content
        self.digest = hashlib.sha256(content).digest()
        self.bom = _BOM if content.startswith(_BOM) else b""
        self.text = as_text(content, self.name) if self.is_file or given.kept else as_yaml(loaded(content, self.path))

    @property
    def title(self) -> str:
        """Name of a scenario that says none."""
        return visible(self.path.stem, lines=False)

    def _fresh(self) -> bytes | None:
        """The run of the scenario that lies in ``cutwise-runs``, if it is of this scenario and newer than its files."""
        try:
            scenario = self.scenario({})
            file = RUNS / file_name(scenario.name) / RUN
            newest = max(one.stat().st_mtime for one in (self.path, *map(Path, scenario.files)))
            if file.stat().st_mtime <= newest:
                return None
            content = file.read_bytes()
            return content if loaded(content, file).document() == scenario.document() else None
        except (OSError, ScenarioFault, DamagedRun):
            return None

    # --- runs -------------------------------------------------------------------------------------------------------------
    def _adopted(self, content: bytes) -> int:
        number = self.next_run()
        write_bytes(self.runs[number], content)
        return number

    def next_run(self) -> int:
        """A number for a run, and a place for it."""
        with self.lock:
            self._count += 1
            self.runs[self._count] = self.folder / f"run-{self._count}.nc"
            return self._count

    def made(self, number: int) -> None:
        """Remember a run that the page has made; the oldest of many are forgotten."""
        with self.lock:
            self._made.append(number)
            while len(self._made) > _MOST_RUNS:
                old = self._made.pop(0)
                for file in (self.runs.pop(old), self._view_of(old)):
                    file.unlink(missing_ok=True)

    def run(self, number: int) -> Path:
        """The file of a run; Refused where there is none."""
        with self.lock:
            file = self.runs.get(number)
        if file is None or not file.is_file():
            raise Refused(404, f"there is no run {number}")
        return file

    def _view_of(self, number: int) -> Path:
        return self.folder / f"run-{number}.cwv"

    def view(self, number: int) -> bytes:
        """The view file of a run, deflated."""
        source, kept = self.run(number), self._view_of(number)
        with self.lock:
            if kept.is_file():
                return kept.read_bytes()
            result = Result.from_file(source, load(source))
            packer = zlib.compressobj(6, zlib.DEFLATED, -15)
            try:
                packed = packer.compress(view.view_file(result)) + packer.flush()
            except rows.NothingToSee as missing:
                raise Refused(404, f"there is nothing to be seen in 3D of this run: {missing}") from None
            with suppress(OSError):  # a full disk: it is made again when it is asked for again
                write_bytes(kept, packed)
            return packed

    # --- the scenario -----------------------------------------------------------------------------------------------------
    def scenario(self, edits: Mapping[str, str]) -> Scenario:
        """The scenario with some values changed, as ``--set`` changes them."""
        return parse(self.text, self.name, edits, folder=self.path.parent, title=self.title, named="{}")

    def job(self, edits: Mapping[str, str]) -> dict[str, Any]:
        """What the process that computes has to know."""
        return {
            "kind": "run", "text": self.text, "name": self.name, "folder": str(self.path.parent), "title": self.title,
            "edits": self.placed(edits),
        }  # fmt: skip

    def placed(self, edits: Mapping[str, str]) -> dict[str, str]:
        """The edits with uploaded files where they lie."""
        return {key: str(self.uploads[value][0]) if value in self.uploads else value for key, value in edits.items()}

    def check(self, edits: Mapping[str, str]) -> dict[str, Any]:
        """Every key, and the faults that ``cutwise check`` would find."""
        with self.lock:
            given = self.placed(edits)
            faults, scenario = self._faults(given)
            try:
                shown = scenario or self.scenario({})
                fields, name = keys.of_scenario(shown), shown.name
            except ScenarioFault:
                fields, name = keys.of_text(self.text), self.title
            return {
                "name": name, "fields": fields, "faults": faults, "run": self.shown[0] if self.shown else None,
                "runs": self.shown, "live_below_s": 2.0, "can_save": self.is_file,
            }  # fmt: skip

    def _faults(self, edits: Mapping[str, str]) -> tuple[list[dict[str, str]], Scenario | None]:
        scenario = None
        try:
            scenario = self.scenario(edits)
            prepare(scenario)
        except ScenarioFault as fault:
            places = {(one.path, one.message): str(one) for one in self._in_the_text(edits)}
            return [
                {"key": dotted(one.path) or (one.file if one.file in edits else ""),
                 "text": places.get((one.path, one.message), str(one))}
                for one in fault.faults
            ], scenario  # fmt: skip
        except Exception as error:
            if type(error).__name__ not in ("CadFault", "Infeasible", "SolverFailure"):
                raise
            return [{"key": "", "text": str(error)}], scenario
        return [], scenario

    def _in_the_text(self, edits: Mapping[str, str]) -> tuple[Fault, ...]:
        """The faults as they would stand in the changed file, with line and column; none where it cannot be changed so."""
        if len(edits) > _PLACED:
            return ()
        try:
            tree_model = type(self.scenario({}))
            text = edited(self.text, edits, tree_model, is_json=self.name.lower().endswith(".json"))
            prepare(parse(text, self.name, folder=self.path.parent, title=self.title))
        except ScenarioFault as fault:
            return fault.faults
        return ()

    # --- files ------------------------------------------------------------------------------------------------------------
    def save(self, edits: Mapping[str, str], name: str | None) -> str:
        """Write the changed text: to the opened file, or to a new one in its folder; the name of the file."""
        with self.lock:
            if name is not None and not (_NAME.fullmatch(name) and len(name.encode()) <= 240 and _for_any_disk(name)):
                raise Refused(
                    400, "a name of its own is needed, ending in .yaml, without folders and without a dot before it"
                )
            if name is None and not self.is_file:
                raise Refused(409, f"{self.path.name} is no scenario file; save as another one")
            brought = self._brought(edits)
            named = {key: self.uploads[value][1] if value in self.uploads else value for key, value in edits.items()}
            if name is None and hashlib.sha256(self._on_disk()).digest() != self.digest:
                raise Refused(
                    409, f"{self.path.name} was changed on disk since it was opened; save as another file, or reload"
                )
            if name is not None and (self.path.parent / name).exists():
                raise Refused(409, f"{name} is there already; name another file")
            made: list[Path] = []
            try:
                for place, content in brought.items():
                    if self._laid(place, content):
                        made.append(place)
                return self._written(self._changed(named), name)
            except BaseException:  # nothing is left of what was not saved
                for place in made:
                    place.unlink(missing_ok=True)
                raise

    @staticmethod
    def _laid(place: Path, content: bytes) -> bool:
        """Write a brought file where none is; False where the same stands there already."""
        try:
            create_bytes(place, content)
        except FileExistsError:  # there before, or made by somebody else a moment ago
            if place.is_file() and place.read_bytes() == content:
                return False
            raise Refused(
                409, f"{place.name} is there already beside the scenario; rename the file and bring it again"
            ) from None
        return True

    def _brought(self, edits: Mapping[str, str]) -> dict[Path, bytes]:
        """Uploaded files that are to stand beside the scenario."""
        found: dict[Path, bytes] = {}
        for file, bare in {self.uploads[value] for value in edits.values() if value in self.uploads}:
            place, content = self.path.parent / bare, file.read_bytes()
            if found.setdefault(place, content) != content:
                raise Refused(409, f"two files named {bare} are used; rename one of them and bring it again")
        return found

    def _on_disk(self) -> bytes:
        try:
            return self.path.read_bytes()
        except OSError:
            raise Refused(409, f"{self.path.name} is no longer there; save as another file") from None

    def _changed(self, edits: Mapping[str, str]) -> str:
        if not edits:
            return self.text
        try:
            return with_edits(self.text, self.name, edits, folder=self.path.parent, title=self.title)
        except ScenarioFault as fault:
            raise Refused(400, str(fault)) from None

    def _written(self, text: str, name: str | None) -> str:
        if name is not None:
            try:
                create_text(self.path.parent / name, text)
            except FileExistsError:
                raise Refused(409, f"{name} is there already; name another file") from None
            return name
        content = self.bom + text.encode()
        write_bytes(self.path, content)
        self.text, self.digest = text, hashlib.sha256(content).digest()
        return self.path.name

    def upload_place(self, name: str) -> Path:
        """Where an uploaded file is written to: a name of chance in the private folder."""
        suffix = Path(name).suffix.lower()
        bare = name == Path(name).name and "\\" not in name and not name.startswith(".") and _for_any_disk(name)
        if not bare or suffix not in keys.UPLOADS or len(name) > 200 or visible(name, lines=False) != name:
            raise Refused(400, f"a bare file name is needed, one of {', '.join(keys.UPLOADS)}")
        self.folder.mkdir(mode=0o700, exist_ok=True)  # somebody may have tidied up
        return self.folder / f"{secrets.token_hex(16)}{suffix}"

    def uploaded(self, file: Path, name: str) -> str:
        """The word by which an edit names an uploaded file."""
        with self.lock:
            word = f"upload:{len(self.uploads) + 1}"
            self.uploads[word] = (file, name)
            return word
