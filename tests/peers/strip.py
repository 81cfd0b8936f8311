"""One strip of columns cut by a mill circle, through the stages that the loop calls."""

import numpy as np

from cutwise.physics.cutting.flutes import ChipFlutes
from cutwise.physics.engagement.swept import meet_strip
from cutwise.process.loops import round_tool
from cutwise.records import CONTACT, Contact, Load
from cutwise.stages import cut


def strip_force(edges, cutter, columns, number, x, y, width, dt, top, force):
    """Cut one strip down to the mill circle and add x, y, z and tangential force to ``force``, shape (4,)."""
    contact = Contact(np.zeros((columns.height.shape[1], CONTACT)), np.zeros(0))
    count = meet_strip(round_tool(cutter), columns, number, 0, x, y, 0.0, width, dt, top, contact.rows, 0)
    load = Load(np.zeros((1, 3)), np.zeros(6))
    cut(ChipFlutes(cutter.mill, edges, cutter.up_milling), contact, count, 0.0, 0.0, load)
    for strip, column, height in contact.rows[:count, 7:10]:
        columns.height[int(strip), int(column)] = height
    force[:3] += load.layer[0]
    force[3] += load.total[3]
