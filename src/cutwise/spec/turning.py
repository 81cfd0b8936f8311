"""The scenario of turning a shaft that yields, between what holds it and the tool."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from cutwise import units
from cutwise.spec import base
from cutwise.spec.base import Angle, Count, Length, LibrarySpec, Notice, Number, Spec, Usual
from cutwise.spec.cell import REFUSED
from cutwise.spec.faults import Path
from cutwise.spec.material import Material
from cutwise.spec.measures import TURNING
from cutwise.spec.needs import Needs
from cutwise.spec.scenario import MeasureSpec, Scenario
from cutwise.spec.tool import BendingTool

_Feed = Annotated[base.FeedPerRevolution, Usual("0.03 mm/rev", "0.8 mm/rev")]
_Stiffness = Annotated[base.Stiffness, Usual("5 N/um", "500 N/um")]


def _key(description: str, example: Any, **limits: Any) -> Any:
    return Field(description=description, examples=[example], **limits)


def _optional(description: str, example: Any, **limits: Any) -> Any:
    return _key(description, example, **{"default": None, "gt": 0} | limits)


class ShaftSection(Spec):
    """A cylinder of the finished shaft."""

    length: Length = _key("length of the cylinder", "300 mm", gt=0)
    diameter: Length = _key("finished diameter", "30 mm", gt=0)
    feed: _Feed | None = _optional("feed of the last passes here; left out: the operation's", "0.1 mm/rev")


class TurnedPart(Spec):
    """The bar outside of the chuck, and the shaft that is turned from it."""

    stock_diameter: Length = _key("diameter of the bar", "33 mm", gt=0)
    sections: tuple[ShaftSection, ...] = _key(
        "cylinders of the finished shaft, the first at the headstock; one as thick as the bar is not turned",
        "[{length: 300 mm, diameter: 30 mm}]", min_length=1,
    )  # fmt: skip
    youngs_modulus: base.Elasticity = _key("Young's modulus", "210 kN/mm^2", gt=0)
    poisson_ratio: Annotated[Number, Usual(0.2, 0.4)] = _key("Poisson's ratio", 0.3, gt=-1, lt=0.5)
    density: base.Density | None = _optional("density, for chatter", "7850 kg/m^3")
    damping: Annotated[Number, Usual(0.003, 0.1)] | None = _optional("damping ratio, for chatter", 0.02, lt=1)
    runout: base.SmallLength | None = _key("run-out of the bar, full indicator", "200 um", default=None, ge=0)

    def contradictions(self) -> Iterator[Notice]:
        """A shaft that is not in the bar; half of what chatter needs."""
        for place, section in enumerate(self.sections):
            if section.diameter > self.stock_diameter:
                yield Notice(("sections", place, "diameter"), f"is larger than the bar ({_mm(self.stock_diameter)})")
        if all(section.diameter >= self.stock_diameter for section in self.sections):
            yield Notice(("stock_diameter",), "leaves nothing to turn; write a larger bar or a smaller diameter")
        if (self.density is None) != (self.damping is None):
            yield Notice(("density",) if self.density is None else ("damping",), "missing; chatter needs both of them")


class Insert(BendingTool):
    """An insert in its holder, edge without inclination; its axes: x along the feed, y radial."""

    nose_radius: Annotated[Length, Usual("0.1 mm", "2.4 mm")] = _key("nose radius r_ε", "0.8 mm", gt=0)
    lead_angle: Annotated[Angle, Usual("45 deg", "107 deg")] = _key(
        "angle κ_r of the major edge to the feed", "95 deg", ge=math.pi / 6, le=math.pi / 1.5
    )
    trail_angle: Annotated[Angle, Usual("3 deg", "60 deg")] = _key(
        "angle κ_r' of the minor edge to the feed, for roughness", "5 deg", ge=0, le=math.pi / 3
    )


class Lathe(LibrarySpec):
    """How the lathe holds the shaft; a stiffness that is left out is rigid."""

    library_shelf: ClassVar[str] = "lathes"

    headstock: Literal["chuck", "centre"] = _key("a chuck, or a centre, which is free to tilt", "chuck")
    headstock_stiffness: _Stiffness | None = _optional("radial stiffness of spindle and chuck", "150 N/um")
    headstock_angular_stiffness: base.AngularStiffness | None = _optional("the same against tilt", "2e6 N m/rad")
    tailstock: Literal["centre", "none"] = _key("a live centre at the far end, or none", "centre")
    tailstock_stiffness: _Stiffness | None = _optional("radial stiffness of tailstock and centre", "40 N/um")
    steady_position: Length | None = _optional("where a steady rest stands, from the headstock end", "150 mm")
    steady_stiffness: _Stiffness | None = _optional("radial stiffness of the steady rest", "50 N/um")

    def contradictions(self) -> Iterator[Notice]:
        """A shaft that nothing holds."""
        if self.headstock == "centre" and self.tailstock == "none":
            yield Notice(("tailstock",), "none leaves the shaft on one centre; write centre, or headstock: chuck")

    def unused(self) -> Iterator[Notice]:
        """Stiffness of what does not hold the shaft."""
        for key, idle, why in (
            ("tailstock_stiffness", self.tailstock == "none", "there is no tailstock centre (lathe.tailstock)"),
            ("headstock_angular_stiffness", self.headstock == "centre", "a centre is free to tilt (lathe.headstock)"),
            ("steady_stiffness", self.steady_position is None, "there is no steady rest (lathe.steady_position)"),
        ):
            yield from (Notice((key,), why),) if idle else ()


class TurningOperation(Spec):
    """Passes along the shaft, from the bar to the finished diameters."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("cutting_speed",), ("spindle_speed",))

    cutting_speed: Annotated[base.Speed, Usual("20 m/min", "800 m/min")] | None = _optional(
        "cutting speed, kept at every diameter (G96)", "180 m/min"
    )
    spindle_speed: Annotated[base.AngularSpeed, Usual("30 rpm", "6000 rpm")] | None = _optional(
        "spindle speed, instead of a cutting speed (G97)", "1200 rpm"
    )
    feed: _Feed = _key("feed per revolution", "0.25 mm/rev", gt=0)
    passes: Count = _key("passes to size, all but the last equally deep", 2, ge=1, le=100)
    finish_depth: Length | None = _optional("depth of the last of them; left out: all alike", "0.3 mm")
    finish_feed: _Feed | None = _optional("feed of the last and of spring passes; left out: the feed", "0.1 mm/rev")
    spring_passes: Count = _key("passes without new depth, for what bending left", 1, default=0, ge=0, le=20)
    towards: Literal["headstock", "tailstock"] = _key("where the feed goes", "headstock", default="headstock")

    def contradictions(self) -> Iterator[Notice]:
        """One speed."""
        if (self.cutting_speed is None) == (self.spindle_speed is None):
            yield Notice(("cutting_speed",), "write one of cutting_speed and spindle_speed")

    def unused(self) -> Iterator[Notice]:
        """The depth of the last of one pass."""
        if self.passes == 1:
            yield Notice(("finish_depth",), "one pass takes all of the bar (operation.passes)")


class Stations(Spec):
    """Places along the shaft."""

    station: Length = _key("largest step between the places looked at", "5 mm", default=5e-3, gt=0)


class TurningScenario(Scenario):
    """Turning a shaft that yields, between chuck, centre and tool."""

    measures: ClassVar[Mapping[str, MeasureSpec]] = TURNING
    needs: ClassVar[Needs] = {
        "roundness_error_max": ("part.runout",),
        **dict.fromkeys(("stable_depth_min", "depth_margin"), ("part.damping",)),
        **{f"*_{term}{rest}": (need,) for rest in ("", "_m*") for term, need in (
            ("tool", "tool.stiffness or tool.modes"), ("tailstock", "lathe.tailstock_stiffness"),
            ("steady", "lathe.steady_stiffness"),
            ("headstock", "lathe.headstock_stiffness or lathe.headstock_angular_stiffness"))},
    }  # fmt: skip
    starts: ClassVar[Mapping[str, str]] = {
        "material.library": "kienzle_1045", "operation.cutting_speed": "180 m/min", "part.density": "7850 kg/m^3",
        "part.damping": "0.02", "requirements": "{diameter_error_max: {max: 0.02 mm}, depth_margin: {min: 0}}",
    }  # fmt: skip
    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "operation.feed": ("0.05 mm", "0.6 mm"), "operation.passes": ("1", "12"),
        "operation.finish_depth": ("0.05 mm", "3 mm"), "operation.finish_feed": ("0.03 mm", "0.5 mm"),
        "tool.nose_radius": ("0.2 mm", "1.6 mm"),
    }  # fmt: skip
    focus: ClassVar[str] = "diameter_error_max"
    refused: ClassVar[Mapping[str, str]] = {
        "spindle": REFUSED["turn", "pistons"], "robot": REFUSED["turn", "robot"], "machine": REFUSED["turn", "machine"],
    }  # fmt: skip

    process: Literal["turn"] = _key("which operation is simulated", "turn")
    operation: TurningOperation = Field(description="the passes")
    part: TurnedPart = Field(description="the bar and the shaft")
    tool: Insert = Field(description="the insert in its holder")
    material: Material = Field(description="cutting coefficients of the material with this insert")
    lathe: Lathe = Field(description="how the lathe holds the shaft")
    numerics: Stations = Field(default_factory=Stations, description="how the computation is done")

    def contradictions(self) -> Iterator[Notice]:
        """Feeds beyond the nose, depths beyond the bar, a rest beside the shaft."""
        operation, part, nose = self.operation, self.part, self.tool.nose_radius
        fed: dict[Path, float | None] = {("operation", key): getattr(operation, key) for key in ("feed", "finish_feed")}
        fed |= {("part", "sections", place, "feed"): one.feed for place, one in enumerate(part.sections)}
        for path, feed in fed.items():
            if feed is not None and feed > nose:
                yield Notice(path, f"is more than the nose radius ({_mm(nose)}), which no longer shapes the ridges")
        rooms = [0.5 * d for one in part.sections if (d := part.stock_diameter - one.diameter) > 0.0]
        depth = operation.finish_depth or 0.0
        if depth > min(rooms) * (1 + 1e-9) or (operation.passes > 1 and depth > max(rooms) * (1 - 1e-9)):
            yield Notice(
                ("operation", "finish_depth"), f"is all that the bar has over the shaft, or more ({_mm(min(rooms))})"
            )
        if (self.lathe.steady_position or 0.0) >= (length := sum(section.length for section in part.sections)):
            yield Notice(("lathe", "steady_position"), f"is beyond the shaft, {_mm(length)} long")

    def unasked(self) -> int:
        """A shaft of several sections takes a seventh of a second a run."""
        return 40

    def unused(self) -> Iterator[Notice]:
        """A force that such an edge has not; the group of the material."""
        yield from super().unused()
        yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
        for key in ("K_ac", "K_ae", "k_a11", "m_a"):
            yield Notice(("material", key), "an edge without inclination has no force along itself")


def _mm(value: float) -> str:
    return units.show(value, "length")
