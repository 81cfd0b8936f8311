"""Specific cutting force by Kienzle: one power law of the uncut chip thickness."""

from cutwise.maths.compiled import compiled


@compiled
def specific_cutting_force(kc11: float, exponent: float, thickness: float) -> float:
    r"""Force per uncut chip area.

    .. math:: k_c = k_{c1.1} \, (h / 1\,\mathrm{mm})^{-m_c}, \qquad h \ge 10^{-4}\,\mathrm{mm}

    Parameters
    ----------
    kc11 : float
        :math:`k_{c1.1}` [Pa], the specific force at one millimetre of chip thickness and width.
    exponent : float
        :math:`m_c` [1], 0.1 to 0.4 for metals.
    thickness : float
        Uncut chip thickness :math:`h` [m]. Below :math:`10^{-7}` m the law is held at that thickness: it has no
        meaning there and would grow without bound.

    Returns
    -------
    float
        :math:`k_c` [Pa].

    Notes
    -----
    Valid for the chip thickness, rake and wear for which :math:`k_{c1.1}` was fitted.

    Examples
    --------
    A tenth of a millimetre and an exponent of 1/4: :math:`10^{1/4}` times the force at one millimetre.

    >>> round(specific_cutting_force(1.5e9, 0.25, 1e-4) / 1e6, 3)
    2667.419

    References
    ----------
    Kienzle 1952; tables of :math:`k_{c1.1}` are usually fitted over 0.05 to 0.5 mm.
    """
    return kc11 * (max(thickness, 1e-7) * 1e3) ** (-exponent)
