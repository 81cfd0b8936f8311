"""The edge of a turning insert in a material: force of each element of the edge on its own chip thickness."""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.uneven import Edges, force_per_length, tangent_coefficients
from cutwise.stages import cut


class InsertEdge(NamedTuple):
    """An edge without inclination: no force along it."""

    edges: Edges  # force law and coefficients


@cut.of(InsertEdge)
def _(cutting, contact, count, time, pivot, load):
    r""":math:`dF = (-\sin\beta\,f_r,\ \cos\beta\,f_r,\ f_t)\,db` along the feed, off the work, along the cutting speed."""
    rows, total = contact.rows, load.total
    for i in range(count):
        ft, fr, _ = force_per_length(cutting.edges, rows[i, 5])
        total[0] -= rows[i, 2] * rows[i, 3] * fr
        total[1] += rows[i, 2] * rows[i, 4] * fr
        total[2] += rows[i, 2] * ft
    total[3] = total[2]
    for axis in range(3):
        load.layer[0, axis] = total[axis]
    return 0


def chip_slopes(rows: FloatArray, edges: Edges) -> FloatArray:
    r"""Change of force for a displacement of the tool in the plane of feed and radius [N/m], shape (3, 2).

    .. math:: \sum_i b_i\,(-\sin\beta_i k_r,\ \cos\beta_i k_r,\ k_t)^T (\sin\beta_i,\ -\cos\beta_i), \qquad k = df/dh|_{h_i}

    over rows of contact (n, 12); of one element it gives the orthogonal limit of a turning tool (Altintas 2012, ch. 4).
    """
    total = np.zeros((3, 2))
    for _, _, width, s, c, h, *_ in rows[rows[:, 5] > 0.0]:
        k = tangent_coefficients(edges, h)
        total += width * np.outer([-s * k.K_rc, c * k.K_rc, k.K_tc], [s, -c])
    return total
