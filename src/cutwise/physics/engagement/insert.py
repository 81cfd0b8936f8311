r"""A turning insert on a bar: where its edge cuts, and how thick the chip is there.

In the plane of feed (x) and radius (y, off the work), the lowest point of the edge at the origin: a nose of radius r about
(0, r), with the angle :math:`\beta` from its lowest point towards the feed, and from :math:`\beta = \kappa` on the straight
major edge; outward normal :math:`n = (\sin\beta, -\cos\beta)`. The minor edge counts for the ridges alone.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import compiled, inlined_stepping
from cutwise.maths.curves import FloatArray, segment
from cutwise.stages import displaced, left, met, probed, spatial

SEEN = 4  # columns shown: depth of cut, mean chip thickness, radius left, number of the station
STRETCHES = (16, 16, 4, 12)  # elements of nose and major edge, each before and after the kink of the chip
ELEMENTS = sum(STRETCHES)


class Insert(NamedTuple):
    """An insert that is fed along a bar; y of its pose is the distance from the axis of rotation."""

    nose: float  # r [m]
    lead: float  # kappa [rad]
    feed: FloatArray  # f per revolution at the stations of the bar [m], shape (n,)


class Bar(NamedTuple):
    """The bar as it stands."""

    at: FloatArray  # stations [m] along the feed, rising, shape (n,)
    radius: FloatArray  # [m], shape (n,)


@compiled
def ridge(feed: float, nose: float, trail: float) -> float:
    r"""Height [m] of the ridges that a feed f leaves, :math:`R_t`: of the nose alone, or of nose and minor edge.

    .. math:: r - \sqrt{r^2 - f^2/4} \approx \frac{f^2}{8r} \quad (f \le 2r\sin\kappa'), \qquad
              r(1 - \cos\kappa') + f \sin\kappa'\cos\kappa' - \sqrt{2rf\sin^3\kappa' - f^2\sin^4\kappa'}

    Valid for :math:`f \le r`. Boothroyd and Knight 1989, Fundamentals of Machining and Machine Tools.

    >>> round(1e6 * ridge(0.2e-3, 0.8e-3, math.radians(30.0)), 3)
    6.275
    """
    s, c = math.sin(trail), math.cos(trail)
    if feed <= 2.0 * nose * s:
        return nose - math.sqrt(nose * nose - 0.25 * feed * feed)
    return nose * (1.0 - c) + feed * s * c - math.sqrt(2.0 * nose * feed * s**3 - feed * feed * s**4)


@compiled
def thickness(x: float, y: float, beta: float, feed: float, depth: float, insert: Insert) -> float:
    r"""Chip thickness h [m] at a point of the edge: along :math:`-n` to where the edge passed one revolution before, or
    to the uncut surface at y = depth. On the straight major edge :math:`f \sin\kappa`.

    Valid for feeds up to the nose radius.

    >>> insert = Insert(0.8e-3, math.radians(90.0), None)
    >>> round(1e6 * thickness(0.8e-3, 1.5e-3, insert.lead, 0.2e-3, 2e-3, insert), 6)
    200.0

    References
    ----------
    Derived here.
    """
    s, c = math.sin(beta), math.cos(beta)
    qx, qy = x + feed, y - insert.nose
    normal = qx * s - qy * c
    rest = normal * normal - (qx * qx + qy * qy - insert.nose * insert.nose)
    h = normal - math.sqrt(max(rest, 0.0))
    angle = math.atan2(qx - h * s, -qy - h * c) if rest >= 0.0 else insert.lead
    if angle >= insert.lead:  # the edge was straight there
        h = (qx * math.sin(insert.lead) - qy * math.cos(insert.lead) - insert.nose) / math.cos(beta - insert.lead)
    return max(min(h, (depth - y) / c) if c > 0.0 else h, 0.0)


@inlined_stepping
def _spread(rows, count, elements, beta, along, insert, feed, depth):
    """Rows of one stretch of the edge: angles (from, to) on the nose, way (from, to) along a straight edge [m]."""
    width = (insert.nose * (beta[1] - beta[0]) + along[1] - along[0]) / elements
    for i in range(elements if width > 0.0 else 0):
        share = (i + 0.5) / elements
        b, w = beta[0] + share * (beta[1] - beta[0]), along[0] + share * (along[1] - along[0])
        s, c = math.sin(b), math.cos(b)
        h = thickness(insert.nose * s + w * c, insert.nose * (1.0 - c) + w * s, b, feed, depth, insert)
        if beta[1] > beta[0]:
            h *= (
                1.0 - 0.5 * h / insert.nose
            )  # section per length of edge: the chip narrows towards the middle of the nose
        rows[count, 2], rows[count, 3], rows[count, 4], rows[count, 5] = width, s, c, h
        count += 1
    return count


@compiled
def edge_rows(rows: FloatArray, insert: Insert, feed: float, depth: float) -> int:
    r"""Rows (., ., width, :math:`\sin\beta, \cos\beta`, h) of the edge in a depth of cut [m]; their number.

    By the midpoint rule over stretches that end where the chip has a kink: its section comes out within 1e-3.

    Valid for feeds up to the nose radius.

    >>> import numpy as np
    >>> rows = np.zeros((ELEMENTS, 12))
    >>> count = edge_rows(rows, Insert(0.8e-3, math.radians(95.0), np.zeros(1)), 0.2e-3, 2e-3)
    >>> round(1e6 * float((rows[:, 2] * rows[:, 5]).sum()), 3)  # mm^2, less what the ridges keep
    0.4

    References
    ----------
    Derived here.
    """
    r, lead = insert.nose, insert.lead
    top = r * (1.0 - math.cos(lead))
    highest = math.acos(1.0 - depth / r) if depth < top else lead
    length = max(0.0, depth - top) / math.sin(lead)
    first = -min(math.asin(0.5 * feed / r), math.acos(max(-1.0, 1.0 - depth / r)))
    # the kink is where the uncut surface ended one revolution before, as seen from the nose of now
    x = r * math.sin(highest) + length * math.cos(lead) - feed
    kink = min(highest, max(first, math.atan2(x, r - depth)))
    bend = min(length, max(0.0, length - feed * math.cos(lead)))
    if lead > 0.5 * math.pi and length > 0.0:  # the chip overhangs: its corner counts to the last element
        length = bend = length - 0.5 * feed * math.cos(lead)
    count = _spread(rows, 0, STRETCHES[0], (first, kink), (0.0, 0.0), insert, feed, depth)
    count = _spread(rows, count, STRETCHES[1], (kink, highest), (0.0, 0.0), insert, feed, depth)
    count = _spread(rows, count, STRETCHES[2], (lead, lead), (0.0, bend), insert, feed, depth)
    return _spread(rows, count, STRETCHES[3], (lead, lead), (bend, length), insert, feed, depth)


@spatial.of(Insert)
def _(engagement):
    return True


@probed.of(Insert)
def _(engagement, pose):
    return 0.0, 0.0


@met.of(Insert)
def _(engagement, stock, pose, structure, flexed, contact):
    k = segment(stock.at, pose.along + 1e-9)
    k += int(pose.along + 1e-9 >= stock.at[-1] and k + 1 < stock.at.size)
    tip = displaced(structure, flexed, 0.0, 0.0)
    radius = math.hypot(pose.y + tip.y, tip.z)
    depth, rows, seen = stock.radius[k] - radius, contact.rows, contact.seen
    seen[0], seen[1], seen[2], seen[3] = max(0.0, depth), 0.0, stock.radius[k], k
    if depth <= 0.0:
        return 0
    seen[2] = radius
    count, width = edge_rows(rows, engagement, engagement.feed[k], depth), 0.0
    for i in range(count):
        width += rows[i, 2]
    seen[1] = engagement.feed[k] * depth / width
    return count


@left.of(Insert)
def _(engagement, stock, contact, count):
    if count > 0:
        stock.radius[int(contact.seen[3])] = contact.seen[2]
    return 0
