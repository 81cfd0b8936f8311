r"""The 21 geometric errors of a three-axis machine, table moving in x and y, head in z, from measured places.

.. math::
    \Delta = -(\delta_X + \varepsilon_X \times r_0) - (\delta_Y + \varepsilon_Y \times r_1 + C_{0Y} \hat z \times y \hat y)
             + \delta_Z + \varepsilon_Z \times r_3 + (A_{0Z}, B_{0Z}, 0) \times z \hat z

with the tool point :math:`r_3 = (0, 0, -L)` below the head's frame, :math:`r_1 = r_3 + (0, -y, z)` and
:math:`r_0 = r_1 + (-x, 0, 0)`: chain w X Y b Z t, linear. Each function is a polynomial in u = command/largest command, of
degrees 1 to 3; straightness 2 and 3, for its slope is the squareness: 51 unknowns. Errors and directions are in the axes of
the part: with the table at +x the tool is at -x. Rows of one ``set`` (and of one tool length) share a zero: at the place of
the row that the column ``zero`` marks, or of the only row without any error; else at no known place.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io import library
from cutwise.io.measurements import WORDS, Channel, Measurement
from cutwise.spec.calibration import MachineVolume
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.arm import folds
from cutwise.study.calibrate.fit import fitted, taken_apart
from cutwise.study.calibrate.posed import Finding, Fit, FloatArray, Posed, Unknown, Value
from cutwise.study.calibrate.told import covariance_block, drawn, plain, poorly_seen, rms, unknown_combinations

AXES = "XYZ"
SQUARENESS = ("C0Y", "A0Z", "B0Z")
LENGTH_SCALE, ANGLE_SCALE = 1e-6, 1e-5  # [m, rad] columns are scaled by these before their rank is judged
PRIOR = (5e-6, 20e-6)  # [m, rad] what such errors are on machines of this class (assumed)
_ALONE = 1e-9
_ERRORS = ("error_x", "error_y", "error_z")


class Term(NamedTuple):
    """An unknown: a power of an error function, or a squareness."""

    function: str  # EXX ... or C0Y ...
    axis: int  # whose command it goes with
    component: int  # 0 ... 2 displacement, 3 ... 5 rotation
    power: int  # 0 for a squareness

    @property
    def name(self) -> str:
        """As it is shown: ``EXX[2]`` is the coefficient of u squared."""
        return self.function + (f"[{self.power}]" if self.power else "")

    @property
    def dimension(self) -> str:
        """Of the coefficient."""
        return "small_length" if self.component < 3 else "small_angle"


def terms() -> tuple[Term, ...]:
    """The 51 unknowns."""
    found = []
    for axis, letter in enumerate(AXES):
        for component, of in enumerate("XYZABC"):
            straight = component < 3 and component != axis
            found += [Term(f"E{of}{letter}", axis, component, power) for power in ((2, 3) if straight else (1, 2, 3))]
    return (*found, Term("C0Y", 1, 5, 0), Term("A0Z", 2, 3, 0), Term("B0Z", 2, 4, 0))


def channels(_settings: MachineVolume | None) -> tuple[Channel, ...]:
    """Columns: commands, tool length, errors by component or along a direction, and which rows share a zero."""
    hint = "is more than 1 mm; is the unit right?"
    return (
        *(Channel(axis, "length", unit="mm") for axis in "xyz"), Channel("tool_length", "length", unit="mm"),
        *(Channel(name, "length", False, 1e-3, hint, "um") for name in _ERRORS),
        *(Channel(f"direction_{axis}", "dimensionless", False) for axis in "xyz"),
        Channel("error", "length", False, 1e-3, hint, "um"), Channel("set", WORDS, False), Channel("zero", "", False),
    )  # fmt: skip


class Equations(NamedTuple):
    """What is measured: equations m, unknowns p, zeros z."""

    matrix: FloatArray  # (m, p)
    zeros: FloatArray  # what the unknown zeros of the sets add (m, z)
    measured: FloatArray  # [m] (m,)
    row: npt.NDArray[np.int64]  # of the data (m,)
    column: npt.NDArray[np.int64]  # (m,)
    columns: tuple[str, ...]


def deviations(commands: FloatArray, tool_length: FloatArray, scales: FloatArray) -> FloatArray:
    """Deviation of the tool point per unit of each unknown (n, 3, 51), at commands (n, 3) [m]."""
    count = len(commands)
    tip = np.column_stack([np.zeros(count), np.zeros(count), -tool_length])
    saddle = tip + np.column_stack([np.zeros(count), -commands[:, 1], commands[:, 2]])
    reach = (saddle - np.column_stack([commands[:, 0], np.zeros(count), np.zeros(count)]), saddle, tip)
    found = []
    for term in terms():
        sign = 1.0 if term.axis == 2 else -1.0
        unit = np.eye(3)[term.component % 3]
        if term.power == 0:
            found.append(sign * np.cross(unit, commands[:, term.axis, None] * np.eye(3)[term.axis]))
            continue
        size = sign * (commands[:, term.axis] / scales[term.axis]) ** term.power
        way = np.tile(unit, (count, 1)) if term.component < 3 else np.cross(unit, reach[term.axis])
        found.append(size[:, None] * way)
    return np.stack(found, axis=2)


def calibrate(data: Measurement, settings: MachineVolume) -> Finding:
    """Fit all functions together; combinations that the data leave free get their smallest norm."""
    _chain_fits(settings)
    commands = data.matrix("xyz")
    scales = np.abs(commands).max(axis=0)
    scales = np.array(settings.data.scale) if settings.data.scale is not None else np.where(scales > 0.0, scales, 1.0)
    equations = _equations(data, commands, scales)
    posed, removed = _posed(equations)
    fit = fitted(posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior)
    share = settings.fit.hold_out
    held = folds(0.2 if share in (None, "leave_one_out") and data.rows > 200 else share, data.rows)
    errors, plainer = _left_out(equations, held)
    better, before = rms(errors), rms(plainer)
    failed: tuple[str, ...] = ()
    if better is not None and before is not None and better >= before:
        failed = (f"the left-out error is not below that without correction, {units.show(before, 'small_length', 4)}",)
    shared = np.sum(fit.null**2, axis=1)
    alone = [name for name, square in zip(posed.names, shared, strict=True) if square < _ALONE]
    left = [name for name in posed.names if name not in alone]
    values = tuple(plain(fit, k) for k in range(len(posed.unknowns)))
    table = () if better is None or before is None else (
        ("model", "left out, rms"), ("zeros alone", units.show(before, "small_length", 4)),
        ("21 functions", units.show(better, "small_length", 4)),
    )  # fmt: skip
    rank = len(posed.unknowns) - fit.null.shape[1]
    open_fit = _left_free(fit, settings)
    return Finding(
        "polynomials", values, {"geometry_errors": _written(open_fit, values, scales, data.rows)},
        {"geometry": covariance_block(open_fit, [_key(term) for term in terms()], [term.dimension for term in terms()])},
        fit.scale, "length", better, "rms of the errors held out", "length", fit, drawn(posed, fit.residual), table,
        (f"{removed} zeros of sets are at no known place and were taken out of the data",) if removed else (),
        (f"{rank} of {len(posed.unknowns)} combinations are known, {len(alone)} parameters alone; the others have the smallest "
         f"norm: {', '.join(left) or 'none'}", "predictions between the measured points; elsewhere they extrapolate", *_why(data),
         *(poorly_seen(fit) if not fit.null.shape[1] else ())),
        (), failed, fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip


_CHAIN = (("X", "part"), ("Y", "part"), ("Z", "tool"))


def _chain_fits(settings: MachineVolume) -> None:
    """Refuse a machine whose axes are not those of the fit: a table in x and y, a head in z."""
    label = settings.machine.library
    if not label:
        return
    chain = (library.labelled("machines", label).values.plain().get("chain") or [])[1:]
    found = tuple((one.get("joint", {}).get("command"), one.get("joint", {}).get("side")) for one in chain)
    if found != _CHAIN:
        shown = ", ".join(f"{command} ({side})" for command, side in found) or "none"
        raise ScenarioFault([Fault(
            ("machine", "library"), f"the axes of {label} from the part on are {shown}; the fit is for X (part), Y (part), Z (tool)"
        )])  # fmt: skip


def _left_free(fit: Fit, settings: MachineVolume) -> Fit:
    """The fit with the scatter of the prior in the combinations that the data leave free: a run has them in its band."""
    length, angle = settings.volumetric.prior
    prior = np.array([length if term.component < 3 else angle for term in terms()])
    free = _scales()[:, None] * (fit.null @ (fit.null.T * (prior / _scales())[None, :]))
    return replace(fit, covariance=fit.covariance + free @ free.T)


def _why(data: Measurement) -> tuple[str, ...]:
    """What a single tool length leaves together."""
    if len(np.unique(data.columns["tool_length"])) > 1:
        return ()
    return (
        "with one tool length EAZ is not told from EYZ and A0Z, EBZ not from EXZ and B0Z: measure with a second one",
    )


def _equations(data: Measurement, commands: FloatArray, scales: FloatArray) -> Equations:
    """Rows of components, of directions, or both, with the zeros of their sets."""
    columns, faults = data.columns, []
    along = [name for name in ("direction_x", "direction_y", "direction_z", "error") if name in columns]
    parts = [name for name in _ERRORS if name in columns]
    if along and len(along) < 4:
        faults.append(data.fault("needs direction_x, direction_y, direction_z and error [um] together"))
    if not along and not parts:
        faults.append(data.fault("needs errors: error_x [um] ..., or direction_x ... and error [um]"))
    if along and parts:
        faults.append(data.fault("has both components and directions; one kind of error in a file"))
    if len(along) == 4:
        sizes = np.linalg.norm(data.matrix(along[:3]), axis=1)
        wrong = np.flatnonzero((sizes < 1e-9) & (columns["error"] != 0.0))
        faults += [data.fault("the direction has no length", int(row)) for row in wrong[:5]]
    if faults:
        raise ScenarioFault(faults)
    length = columns["tool_length"]
    moved = deviations(commands, length, scales)
    label = np.unique(data.labels.get("set", ("",) * data.rows), return_inverse=True)[1]
    _, of_set = np.unique(np.column_stack([label, length]), axis=0, return_inverse=True)
    of_set = of_set.reshape(-1)
    names: tuple[str, ...]
    if along:
        way = data.matrix(along[:3]) / np.maximum(np.linalg.norm(data.matrix(along[:3]), axis=1), 1e-9)[:, None]
        ways, measured, names = way[:, None], columns["error"][:, None], ("error",)
    else:
        ways = np.tile(np.eye(3)[[_ERRORS.index(name) for name in parts]], (data.rows, 1, 1))
        measured, names = data.matrix(parts), tuple(parts)
    each = len(names)
    zeros = np.zeros((data.rows, each, int(of_set.max()) + 1, 3))
    zeros[np.arange(data.rows), :, of_set] = ways
    for one in range(int(of_set.max()) + 1):
        place = _zero(data, np.flatnonzero(of_set == one), measured)
        if place is not None:
            moved[of_set == one] -= moved[place].copy()
            measured[of_set == one] -= measured[place].copy()
            zeros[:, :, one] = 0.0
    return Equations(
        np.einsum("nec,ncp->nep", ways, moved).reshape(data.rows * each, -1), zeros.reshape(data.rows * each, -1),
        measured.reshape(-1), np.repeat(np.arange(data.rows), each), np.tile(np.arange(each), data.rows), names,
    )  # fmt: skip


def _zero(data: Measurement, rows: npt.NDArray[np.integer[Any]], measured: FloatArray) -> int | None:
    """Row at whose place the errors of a set are counted from; None if it is not known."""
    marked = rows[data.columns["zero"][rows] != 0.0] if "zero" in data.columns else rows[:0]
    if len(marked) > 1:
        raise ScenarioFault([data.fault("a set has one zero; this row is marked as well", int(marked[1]))])
    if not len(marked):
        marked = rows[np.all(measured[rows] == 0.0, axis=1)]
    return int(marked[0]) if len(marked) == 1 else None


def _scales() -> FloatArray:
    return np.array([LENGTH_SCALE if term.component < 3 else ANGLE_SCALE for term in terms()])


def _posed(equations: Equations) -> tuple[Posed, int]:
    """The equations less the zeros of their sets."""
    u, s, _ = np.linalg.svd(equations.zeros, full_matrices=False)
    basis = u[:, s > 1e-9 * max(s[0], 1e-300)]
    matrix = equations.matrix - basis @ (basis.T @ equations.matrix)
    matrix = np.where(np.abs(matrix) < 1e-12 * np.abs(equations.matrix).max(axis=0, initial=1e-300), 0.0, matrix)
    unknowns = tuple(
        Unknown(term.name, term.dimension, 0.0, False, PRIOR[0] if term.component < 3 else PRIOR[1]) for term in terms()
    )
    measured = equations.measured - basis @ (basis.T @ equations.measured)
    posed = Posed(
        unknowns, measured, equations.row, equations.column, equations.columns, ("small_length",) * len(equations.columns),
        lambda x: np.asarray(matrix @ x), lambda _: matrix, removed=basis.shape[1], scales=tuple(_scales()),
    )  # fmt: skip
    return posed, basis.shape[1]


def _left_out(equations: Equations, held: list[list[int]]) -> tuple[FloatArray, FloatArray]:
    """Errors of rows that the fit does not know, with the functions and with the zeros alone [m]."""
    corrected, plainer = (np.full(len(equations.measured), np.nan) for _ in range(2))
    for fold in held if len(held) < 60 else [[row for one in held[k::10] for row in one] for k in range(10)]:
        out = np.isin(equations.row, fold)
        kept = Equations(
            equations.matrix[~out], equations.zeros[~out], equations.measured[~out], equations.row[~out],
            equations.column[~out], equations.columns,
        )  # fmt: skip
        posed, _ = _posed(kept)
        apart = taken_apart(posed.jacobian(np.zeros(1)), [u.dimension for u in posed.unknowns], posed.scales)
        x = apart.inverse @ (posed.jacobian(np.zeros(1)).T @ posed.measured)
        for found, solution in ((corrected, x), (plainer, np.zeros_like(x))):
            zero = np.linalg.lstsq(kept.zeros, kept.measured - kept.matrix @ solution, rcond=None)[0]
            found[out] = equations.measured[out] - equations.matrix[out] @ solution - equations.zeros[out] @ zero
    return corrected, plainer


def _key(term: Term) -> str:
    return f"geometry_errors.{term.function}" + (f".polynomial[{term.power}]" if term.power else "")


def _written(fit: Fit, values: tuple[Value, ...], scales: FloatArray, rows: int) -> dict[str, Any]:
    """Functions as polynomials, squarenesses as angles."""
    said = {"status": "measured", "covariance": "geometry", "source": f"{{file}}, {rows} rows"}
    found: dict[str, Any] = {}
    for term, value, se in zip(terms(), values, np.sqrt(np.diagonal(fit.covariance)), strict=True):
        unit = units.DIMENSIONS[term.dimension].si
        if not term.power:
            found[term.function] = {
                "value": f"{value.value!r} {unit}",
                "standard_error": f"{float(se)!r} {unit}",
                **said,
            }
            continue
        if term.function not in found:
            nothing = [f"0.0 {unit}"] * 4
            polynomial = {"polynomial": list(nothing), "scale": units.text(float(scales[term.axis]), "length")}
            found[term.function] = {"value": polynomial, "standard_error": {"polynomial": list(nothing)}, **said}
        found[term.function]["value"]["polynomial"][term.power] = f"{value.value!r} {unit}"
        found[term.function]["standard_error"]["polynomial"][term.power] = f"{float(se)!r} {unit}"
    return found
