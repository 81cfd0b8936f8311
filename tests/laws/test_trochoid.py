"""Exact arcs of the stock along circles that go along a slot, against the closed form of their contact."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, join, line
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import block_stock, contact_patches, immersion

RADIUS, CIRCLE = 10e-3, 4e-3


def contact(psi: float, step: float) -> float:
    """Arc of contact at an angle of the circle from the slot: the rim of the mill against that on the circle before.

    cos a = (2 r R - s^2 - 2 r s cos psi) / (2 R sqrt(A^2 + B^2)), A = r + s cos psi, B = s sin psi, from
    max(0, -delta - a) to a - delta with delta = atan2(B, A).
    """
    a, b = CIRCLE + step * math.cos(psi), step * math.sin(psi)
    cosine = (2.0 * CIRCLE * RADIUS - step**2 - 2.0 * CIRCLE * step * math.cos(psi)) / (2.0 * RADIUS * math.hypot(a, b))
    half, turn = math.acos(min(1.0, max(-1.0, cosine))), math.atan2(b, a)
    return max(0.0, half - turn - max(0.0, -turn - half))


@pytest.mark.parametrize(("step", "largest"), [(1e-3, 48.509), (2e-3, 69.513), (3e-3, 86.417), (4e-3, 101.537)])
def test_the_largest_contact_is_that_of_the_reference(step, largest):
    found = max(contact(psi, step) for psi in np.linspace(0.0, 2.0 * math.pi, 20_001))
    assert math.degrees(found) == pytest.approx(largest, abs=1e-3)


@pytest.mark.parametrize("step", [1e-3, 2.5e-3, 3.9e-3])
def test_the_stock_leaves_the_contact_of_the_closed_form(step):
    """Two circles counter-clockwise from their right, joined by a straight along the slot; all but the join itself."""
    start, moved = np.array([0.0, -CIRCLE, 0.0]), np.array([step, 0.0, 0.0])
    way = join([
        arc(start, (0.0, 0.0, 0.0), 2.0 * math.pi), line(start, start + moved), arc(start + moved, moved, 2.0 * math.pi)
    ])  # fmt: skip
    psi = np.linspace(-0.5 * math.pi, 1.5 * math.pi, 203)[1:-1]
    at = np.column_stack([step + CIRCLE * np.cos(psi), CIRCLE * np.sin(psi), np.zeros(psi.size)])
    done = (2.0 * math.pi + psi + 0.5 * math.pi) * CIRCLE + step
    swept, block = swept_path(way, RADIUS), block_stock((-1.0, 1.0), (-1.0, 1.0), 5e-3, -1e-3)
    found = immersion(contact_patches(at, psi + 0.5 * math.pi, done, swept, block))
    ahead = np.cos(psi) > 0.0  # behind, the straight of the join has been there too
    assert found[ahead] == pytest.approx([contact(one, step) for one in psi[ahead]], abs=1e-6)
    assert found[ahead].max() > 0.5
