"""A force that is known beforehand at the servo instants of the drives: that of a cut which is computed elsewhere."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.stages import cut

FloatArray = npt.NDArray[np.float64]


class Prescribed(NamedTuple):
    """A mean force on the tool, in the axes of the machine."""

    force: FloatArray  # at the servo instants [N], shape (n, 3)
    clock: npt.NDArray[np.int64]  # servo step of now, shape (2,): that of the drives, which change it


@cut.of(Prescribed)
def _(cutting, contact, count, time, pivot, load):
    """The force of this servo step, whatever is met."""
    k = cutting.clock[0]
    for i in range(3):
        load.total[i] += cutting.force[k, i]
