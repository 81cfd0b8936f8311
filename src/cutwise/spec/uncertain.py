"""How sure input values are: their covariances, what they were fitted to, and how a band of the result is made of it."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, create_model

from cutwise import units
from cutwise.spec.base import Count, Notice, Spec

As = Literal["value", "reciprocal", "log"]
BAND_ENDS = ("band_sd", "band_low", "band_high")


class Band(Spec):
    """How the scatter of measured values is carried through to the result."""

    method: Literal["linear", "sampled", "none"] = Field(
        default="linear",
        description="central differences with the covariance; draws, where the result bends; or no band",
        examples=["sampled"],
    )
    samples: Annotated[Count, Field(ge=50, le=1_000_000)] = Field(
        default=1000, description="draws of a sampled band, a run each", examples=[1000]
    )
    seed: Annotated[Count, Field(ge=0, le=2**32 - 1)] = Field(
        default=1, description="of the draws: the same seed, the same band", examples=[1]
    )

    def unused(self) -> Iterator[Notice]:
        """Draws where none are made."""
        if self.method != "sampled":
            yield Notice(("samples",), "the band is not sampled (band.method)")
        if self.method == "none":
            yield Notice(("seed",), "no band is made (band.method)")


class _Covariance(Spec):
    """Covariance of several values, in SI."""

    listed: ClassVar[bool] = False

    @property
    def kinds(self) -> tuple[As, ...]:
        """In which quantity the errors of each value are normal."""
        said = self.__dict__["as"]
        return (said,) * len(self.of) if isinstance(said, str) else said  # type: ignore[attr-defined, no-any-return]


# "as" is a word of Python, and the word for it all the same.
Covariance: Any = create_model(  # type: ignore[call-overload]
    "Covariance",
    __base__=_Covariance,
    __doc__="Covariance of several values.",
    **{
        "of": (tuple[str, ...], Field(description="keys of the values", examples=["[material.K_tc, material.K_te]"])),
        "as": (
            As | tuple[As, ...],
            Field(default="value", description="in which quantity the errors are normal", examples=["reciprocal"]),
        ),
        "degrees_of_freedom": (
            float | None,
            Field(default=None, description="of the fit; left out: very many", examples=[123], gt=0),
        ),
        "matrix": (tuple[tuple[float, ...], ...], Field(description="covariance in SI", examples=["[[4e12]]"])),
        "library": (str, Field(default="", description="entry that gave it", examples=["fanuc_r2000ic"])),
        "alone": (
            bool,
            Field(default=False, description="a standard error without covariance to others", examples=[True]),
        ),
        "undetermined": (
            tuple[str, ...],
            Field(default=(), description="those that the data do not tell", examples=["[material.K_ae]"]),
        ),
    },
)


class Fitted(Spec):
    """What a calibration said about the values of an entry."""

    listed: ClassVar[bool] = False

    library: str = Field(default="", description="entry that says so", examples=["fanuc_r2000ic"])
    kind: str = Field(default="", description="kind of calibration", examples=["robot-stiffness"])
    residual: str | float | None = Field(default=None, description="scatter that the fit leaves", examples=["0.22 mm"])
    range: dict[str, tuple[str | float, str | float]] = Field(
        default_factory=dict,
        description="least and largest value of each column",
        examples=["{joint1: [-1 rad, 1 rad]}"],
    )

    def ends(self, column: str, dimension: str) -> tuple[float, float] | None:
        """Least and largest value of a column that was measured [SI]; None where that is not said."""
        try:
            low, high = (units.parse(end, dimension) for end in self.range[column])
        except (KeyError, units.UnitFault):
            return None
        return low, high


def stem(name: str) -> tuple[str, str] | None:
    """A measure and which end of its band a name stands for: ``width_min_band_high`` is (``width_min``, ``high``)."""
    for end in BAND_ENDS:
        if name.endswith(f"_{end}"):
            return name[: -len(end) - 1], end.removeprefix("band_")
    return None


def covered(blocks: Iterable[Any]) -> frozenset[str]:
    """Keys of the values that have a covariance."""
    return frozenset(name for block in blocks for name in block.of)
