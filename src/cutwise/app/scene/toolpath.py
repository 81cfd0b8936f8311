"""The path along which a tool is carried, as the scenario says it: where a place along, off and above it is in the part."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cutwise.app.scene.scene import FloatArray
from cutwise.process import carriage, milling_wall
from cutwise.spec.carrier import Standing

if TYPE_CHECKING:
    from cutwise.paths.carried import CarriedPath
    from cutwise.results import Result


class Toolpath(NamedTuple):
    """Stations of a path with its own axes, and the axes in which the process counts; in the frame of the part."""

    at: FloatArray  # [m] of the path, shape (n,)
    point: FloatArray  # [m], shape (n, 3)
    own: FloatArray  # columns: along, off the work, up the tool; shape (n, 3, 3)
    process: FloatArray  # the same unless the tool keeps its attitude on an arc

    def on(self, along: FloatArray, off: FloatArray | float, up: FloatArray | float) -> FloatArray:
        """Places along, off and above the path, shape (k, 3); beyond its ends straight on [m]."""
        axes = _between(self.at, self.own, along)
        point = np.column_stack([np.interp(along, self.at, one) for one in self.point.T])
        past = along - np.clip(along, self.at[0], self.at[-1])
        steps = np.column_stack([past, np.broadcast_to(off, along.shape), np.broadcast_to(up, along.shape)])
        return np.asarray(point + np.einsum("nij,nj->ni", axes, steps))

    def turned(self, along: FloatArray, vectors: FloatArray) -> FloatArray:
        """Vectors in process axes (k, 3) at places along the path, in the part."""
        return np.asarray(np.einsum("nij,nj->ni", _between(self.at, self.process, along), vectors))

    def up(self, along: FloatArray) -> FloatArray:
        """From the tip up the tool, shape (k, 3) or (1, 3) where it stands alike everywhere."""
        axis = _between(self.at, self.own, along)[:, :, 2]
        return axis[:1] if np.ptp(axis, axis=0).max() < 1e-9 else axis

    @property
    def front(self) -> tuple[float, float, float]:
        """Level direction from which the side off the work is seen; from -y where that side is up or down."""
        off = self.own[len(self.own) // 2, :, 1] * (1.0, 1.0, 0.0)
        size = float(np.linalg.norm(off))
        return (0.0, -1.0, 0.0) if size < 0.1 else (float(off[0] / size), float(off[1] / size), 0.0)


def toolpath_of(result: "Result") -> Toolpath | None:
    """The path of a scenario that says where it leads; None where it is only long."""
    scenario: Any = result.scenario
    path = getattr(scenario, "path", None)
    if path is None or (getattr(path, "line", None) is None and getattr(path, "arc", None) is None):
        return None
    if scenario.process == "mill" and scenario.robot is None:
        return _own(milling_wall.stations_of(scenario))
    if getattr(path, "tool_axis", None) is None:
        return None
    if path.arc is not None and not getattr(scenario, "follows", True):
        path = path.model_copy(update={"orientation": "fixed"})
    return _own(carriage.stations_of(scenario, path, Standing()))


def _own(path: "CarriedPath") -> Toolpath:
    """Its own axes from its points, on the same side of the work as those of the process."""
    along = np.gradient(path.point, path.at, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = path.axes[:, :, 2]
    off = np.sign(np.linalg.det(path.axes))[:, None] * np.cross(up, along)
    return Toolpath(path.at, path.point, np.stack([along, off, up], axis=2), path.axes)


def _between(at: FloatArray, axes: FloatArray, along: FloatArray) -> FloatArray:
    """Axes at places along the path, straight between stations and of unit length."""
    rows = np.column_stack([np.interp(along, at, one) for one in axes.reshape(len(at), 9).T])
    found = rows.reshape(-1, 3, 3)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))
