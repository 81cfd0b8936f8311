r"""Elastic joints of a serial arm: what the tool yields by, and when the tip of a drill skates.

Tool axes: z along the feed, into the work; twists are displacement first, rotation second.
"""

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.structure.series_compliance import chain_compliance, in_axes, turning_elements


def cartesian_compliance(jacobian: FloatArray, stiffness: FloatArray, axes: FloatArray | None = None) -> FloatArray:
    r"""Compliance at the tool point from joint stiffness.

    .. math:: C = J K_\theta^{-1} J^T, \qquad C_\text{tool} = \mathrm{diag}(R^T, R^T)\, C\, \mathrm{diag}(R, R)

    Parameters
    ----------
    jacobian : array (..., 6, n)
        Geometric, at the tool point [m; 1 per rad].
    stiffness : array (n,)
        :math:`K_\theta` at the joints' output [N m/rad]; infinite for a stiff joint.
    axes : array (..., 3, 3), optional
        Tool axes as columns; without them the compliance stays in the axes of the Jacobian.

    Returns
    -------
    array (..., 6, 6)
        Blocks [m/N, 1/N; rad/N, rad/(N m)].

    Notes
    -----
    Links are rigid and the load is small: the stiffening by the load itself, :func:`geometric_stiffness`, changes the
    result by 5e-4 at 600 N and is left out.

    References
    ----------
    Salisbury 1980, Proc. IEEE CDC, 95-100.
    """
    elements = turning_elements(jacobian, stiffness)
    compliance = chain_compliance(elements, np.zeros((*elements.shape[:-2], 3)))
    return compliance if axes is None else in_axes(compliance, axes)


def geometric_stiffness(jacobian: FloatArray, wrench: FloatArray) -> FloatArray:
    r"""Complementary stiffness of the joints under a load: :math:`K_C = (\partial J^T/\partial q)\,w`.

    .. math::
        \frac{\partial J_i}{\partial q_j} = (\omega_j \times v_i;\; \omega_j \times \omega_i)\ (j \le i), \quad
        (\omega_i \times v_j;\; 0)\ (j > i), \qquad (K_C)_{ij} = \frac{\partial J_i}{\partial q_j}^T w

    The arm then yields by :math:`C = J (K_\theta - K_C)^{-1} J^T`. Not symmetric when a moment acts.

    Parameters
    ----------
    jacobian : array (6, n)
        Of turning joints, in base axes.
    wrench : array (6,)
        Load on the tool, force [N] above moment [N m], constant in base axes.

    Returns
    -------
    array (n, n)
        [N m/rad].

    References
    ----------
    Chen and Kao 2000, conservative congruence transformation.
    """
    v, omega = jacobian[:3].T, jacobian[3:].T
    count = len(v)
    result = np.zeros((count, count))
    for i in range(count):
        for j in range(count):
            if j <= i:
                change = np.concatenate([np.cross(omega[j], v[i]), np.cross(omega[j], omega[i])])
            else:
                change = np.concatenate([np.cross(omega[i], v[j]), np.zeros(3)])
            result[i, j] = change @ wrench
    return result


@compiled
def axial_and_holding(cxx: float, cxy: float, cyy: float, cxz: float, cyz: float) -> tuple[float, float]:
    r"""Lateral force over thrust that keeps the tip in place at a flat entry, :math:`C_l^{-1} c`.

    .. math:: C_l = C_{[x,y;\,x,y]}, \quad c = C_{[x,y;\,z]}

    Thrust pushes the tool aside by :math:`-cT`; a lateral force :math:`C_l^{-1} c\,T` keeps the tip where it is.

    Parameters
    ----------
    cxx, cxy, cyy, cxz, cyz : float
        Translation block of the compliance in tool axes [m/N].

    Returns
    -------
    tuple
        Lateral force x, y over the thrust [1].

    Notes
    -----
    Valid for point contact without moment, quasi-static, drill torque left out (:func:`holding_force` has it); the lateral
    block has to be positive definite, as that of any arm is that yields both ways.

    Examples
    --------
    2 and 4 um/N across, 1 and -1 um/N of coupling to the thrust:

    >>> [round(part, 9) for part in axial_and_holding(2e-6, 0.0, 4e-6, 1e-6, -1e-6)]
    [0.5, -0.25]

    References
    ----------
    Derived here: equilibrium of a tip held by friction. Garnier et al. 2017, sec. 1, name the sliding and leave it open.
    """
    determinant = cxx * cyy - cxy * cxy
    return (cyy * cxz - cxy * cyz) / determinant, (cxx * cyz - cxy * cxz) / determinant


def holding_ratio(compliance: FloatArray) -> FloatArray:
    """Lateral force over thrust of a compliance (6, 6) or (3, 3) in tool axes; see :func:`axial_and_holding`.

    References
    ----------
    Derived here.
    """
    c = compliance
    return np.array(axial_and_holding(c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2]))


def worst_skating(holding: FloatArray, side: FloatArray, turn: FloatArray | float = 0.0) -> FloatArray:
    r"""Skating ratio of a tip held by friction, the worst over the entry.

    .. math:: \rho = \max_h |C_l^{-1} c - R(\sigma)\, F_s(h)/T(h)|

    The lips of a drill that enters a slope do not balance: their side force :math:`F_s`, over the thrust, adds to what
    friction has to hold. On a flat surface it is zero and :math:`\rho = |C_l^{-1} c|` whatever the thrust. With Coulomb
    friction the tip stays in place if and only if :math:`\rho \le \mu`.

    Parameters
    ----------
    holding : array (..., 2)
        :math:`C_l^{-1} c` in tool axes, from :func:`holding_ratio`.
    side : array (h, 2)
        Side force on the tool over thrust while the point enters, axes of the slope; no rows on a flat surface.
    turn : array (...) or float
        :math:`\sigma` [rad]: direction of the slope in tool axes.

    Returns
    -------
    array (...)
        :math:`\rho` [1].

    References
    ----------
    Derived here; Garnier et al. 2017, sec. 1, name the sliding of drills on weak arms.
    """
    if not len(side):
        return np.asarray(np.hypot(holding[..., 0], holding[..., 1]))
    c, s = np.cos(turn)[..., None], np.sin(turn)[..., None]
    x = holding[..., 0, None] - (c * side[:, 0] - s * side[:, 1])
    y = holding[..., 1, None] - (s * side[:, 0] + c * side[:, 1])
    return np.asarray(np.hypot(x, y).max(axis=-1))


def holding_force(compliance: FloatArray, thrust: float, torque: float) -> FloatArray:
    r"""Lateral force that keeps the tip in place, :math:`C_l^{-1}(c\,T + C_{l\psi} M)` [N], shape (2,).

    The tip holds if it is no larger than :math:`\mu T`. ``compliance`` (6, 6) in tool axes.

    Valid for a tip that touches in a point, thrust [N] along z and torque [N m] about it.

    References
    ----------
    Derived here.
    """
    push = compliance[:2, 2] * thrust + compliance[:2, 5] * torque
    return np.asarray(np.linalg.solve(compliance[:2, :2], push))


def axis_tilt(compliance: FloatArray, thrust: float) -> float:
    r"""Tilt of the drill itself under thrust, :math:`|C_{[\varphi_x,\varphi_y;\,z]}|\,T` [rad].

    Valid for a tip that is free to go aside.

    References
    ----------
    Derived here.
    """
    return float(np.hypot(compliance[3, 2], compliance[4, 2]) * thrust)
