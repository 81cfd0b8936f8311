"""How the edges of a mill cut, from what the engineer says about material and tool."""

from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.uneven import KIENZLE, LINEAR, Edges, Kienzle
from cutwise.spec.material import KIENZLE as KIENZLE_KEYS
from cutwise.spec.material import LINEAR as LINEAR_KEYS
from cutwise.spec.material import Material
from cutwise.spec.tool import HelicalMill

_FORCE_LAW = {"linear": LINEAR, "kienzle": KIENZLE}


def known_axes(material: Material) -> str:
    """Along which axes the force of the cut is known: along the tool only with axial coefficients."""
    return "xy" if material.K_ac is None and material.k_a11 is None else "xyz"


def linear_coefficients(material: Material) -> EdgeCoefficients:
    """The straight-line law; an unknown axial pair counts as zero, and no axial force is reported then."""
    return EdgeCoefficients(*(getattr(material, key) or 0.0 for key in LINEAR_KEYS))


def edges(material: Material, tool: HelicalMill) -> Edges:
    """How the edges cut; an unknown axial pair counts as zero, and no axial force is reported then."""
    return edges_alike(material)._replace(runout=tool.runout, runout_angle=tool.runout_angle)


def edges_alike(material: Material) -> Edges:
    """The edges of a tool without run-out."""
    kienzle = Kienzle(*(getattr(material, key) or 0.0 for key in KIENZLE_KEYS))
    return Edges(_FORCE_LAW[material.law], linear_coefficients(material), kienzle, 0.0, 0.0)
