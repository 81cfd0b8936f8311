"""Cutting coefficients of a material, for the tool and the chip thickness they were found with."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cutwise import units
from cutwise.spec.base import EdgeForce, LibrarySpec, Notice, Number, SmallLength, Stress, Usual

LINEAR = ("K_tc", "K_rc", "K_ac", "K_te", "K_re", "K_ae")
KIENZLE = ("k_c11", "m_c", "k_r11", "m_r", "k_a11", "m_a")

Group = Literal["P", "M", "K", "N", "S", "H"]

_CuttingStress = Annotated[Stress, Usual("150 N/mm^2", "8000 N/mm^2")]
_EdgeForce = Annotated[EdgeForce, Usual(None, "120 N/mm")]  # more is most often N/m
_TangentialEdgeForce = Annotated[EdgeForce, Usual("0.5 N/mm", "120 N/mm")]  # none is optimistic
_AXIAL_EDGE = 0.22  # of the tangential edge force: the highest of the published sets in the library has 0.215
_KienzleStress = Annotated[Stress, Usual("150 N/mm^2", "8000 N/mm^2")]
_Exponent = Annotated[Number, Usual(0.1, 0.6)]


class Material(LibrarySpec):
    """Force per length of cutting edge: a straight line ``K_c h + K_e``, or Kienzle's ``k_c1.1 h^(1-m_c)``.

    ``h`` is the chip thickness, in mm for Kienzle's law (so the 1.1 values are stresses at h = 1 mm).
    """

    library_shelf: ClassVar[str] = "materials"
    either: ClassVar[tuple[tuple[str, ...], ...]] = (LINEAR, KIENZLE)

    K_tc: _CuttingStress | None = Field(
        default=None, description="tangential cutting coefficient", examples=["2000 N/mm^2"], gt=0
    )
    K_rc: Stress | None = Field(default=None, description="radial cutting coefficient", examples=["1200 N/mm^2"], ge=0)
    K_ac: Stress | None = Field(
        default=None,
        description="axial cutting coefficient; where it is not known, leave it out: no axial force is reported then",
        examples=["800 N/mm^2"],
    )
    K_te: _TangentialEdgeForce | None = Field(
        default=None, description="tangential edge coefficient", examples=["2.2 N/mm"], ge=0
    )
    K_re: _EdgeForce | None = Field(default=None, description="radial edge coefficient", examples=["2.2 N/mm"], ge=0)
    K_ae: _EdgeForce | None = Field(default=None, description="axial edge coefficient", examples=["0.2 N/mm"])
    k_c11: _KienzleStress | None = Field(
        default=None, description="Kienzle's specific cutting force at h = 1 mm", examples=["800 N/mm^2"], gt=0
    )
    m_c: _Exponent | None = Field(
        default=None, description="Kienzle's exponent of the cutting force", examples=[0.25], ge=0, lt=1
    )
    k_r11: Stress | None = Field(
        default=None, description="specific radial force at h = 1 mm", examples=["240 N/mm^2"], ge=0
    )
    m_r: _Exponent | None = Field(default=None, description="exponent of the radial force", examples=[0.25], ge=0, lt=1)
    k_a11: Stress | None = Field(
        default=None,
        description="specific axial force at h = 1 mm; where it is not known, leave it out",
        examples=["280 N/mm^2"],
    )
    m_a: _Exponent | None = Field(default=None, description="exponent of the axial force", examples=[0.25], ge=0, lt=1)
    chip_thickness_min: SmallLength | None = Field(
        default=None, description="smallest chip thickness that the coefficients hold for", examples=["0.5 um"], ge=0
    )
    chip_thickness_max: SmallLength | None = Field(
        default=None, description="largest chip thickness that the coefficients hold for", examples=["6 um"], gt=0
    )
    group: Group | None = Field(
        default=None,
        description="ISO 513 group: P steel, M stainless, K cast iron, N non-ferrous, S titanium and nickel, H hard",
        examples=["N"],
    )

    @property
    def law(self) -> Literal["linear", "kienzle"]:
        """Which of the two laws the coefficients belong to."""
        return "kienzle" if self.k_c11 is not None else "linear"

    def contradictions(self) -> Iterator[Notice]:
        """One law, complete in the tangential and radial direction, the axial one complete or left out."""
        linear = [key for key in LINEAR if getattr(self, key) is not None]
        kienzle = [key for key in KIENZLE if getattr(self, key) is not None]
        if linear and kienzle:
            yield Notice((), f"has coefficients of two laws ({', '.join(linear + kienzle)}); keep one of them")
            return
        required: tuple[str, ...] = ("k_c11", "m_c", "k_r11", "m_r") if kienzle else ("K_tc", "K_rc", "K_te", "K_re")
        pair = ("k_a11", "m_a") if kienzle else ("K_ac", "K_ae")
        if any(getattr(self, key) is not None for key in pair):
            required += pair
        for key in required:
            if getattr(self, key) is None:
                yield Notice((key,), "missing")
        low, high = self.chip_thickness_min, self.chip_thickness_max
        if low is not None and high is not None and low >= high:
            yield Notice(("chip_thickness_min",), "is not below chip_thickness_max")

    def beyond(self, chip: float, what: str = "feed per tooth") -> str:
        """That the coefficients do not hold for a feed per tooth, or what it is [m]; nothing if they do."""
        low, high = self.chip_thickness_min, self.chip_thickness_max
        if (low is None or chip >= low) and (high is None or chip <= high):
            return ""
        ends = " to ".join(units.show(end, "small_length", 3) for end in (low, high) if end is not None)
        return f"the coefficients hold for chips of {ends}, this {what} is {units.show(chip, 'small_length', 3)}"

    def notices(self) -> Iterator[Notice]:
        """Ratios that are out of what measurements show."""
        if self.K_tc is not None and self.K_rc is not None and not 0.05 <= self.K_rc / self.K_tc <= 1.0:
            ratio = self.K_rc / self.K_tc
            yield Notice(("K_rc",), f"K_rc/K_tc is {ratio:.2g}; usual is 0.05 to 0.7, up to 1 for chips of a few µm")
        if self.K_ae is not None and self.K_te and abs(self.K_ae) > _AXIAL_EDGE * self.K_te:
            yield Notice(("K_ae",), f"is more than {_AXIAL_EDGE:g} K_te; usual is less at a helix up to 45°")
