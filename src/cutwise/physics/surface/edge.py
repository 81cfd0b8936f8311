"""The edge that a mill leaves behind: the lower envelope of all its circles along the path."""

import math

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray, Polyline
from cutwise.records import Surface

_AXIS_PITCH = 8e-6  # [m] axis positions closer than this add nothing to the envelope


@compiled
def cut_envelope(
    position: FloatArray, centre_x: FloatArray, centre_y: FloatArray, radius: float, ceiling: float
) -> FloatArray:
    r"""Lower envelope of mill circles over a grid of positions.

    .. math:: h(w) = \min_t \left[ y(t) - \sqrt{R^2 - (w - x(t))^2} \right]

    Parameters
    ----------
    position : array
        Even grid w along the edge [m], shape (m,), m at least 2.
    centre_x, centre_y : array
        Mill axis along the edge and above it [m], shape (n,), any order.
    radius : float
        Mill radius R [m].
    ceiling : float
        Height above which nothing stands [m]; uncut places keep it.

    Returns
    -------
    array
        Height of the envelope above the nominal edge [m], shape (m,).

    Notes
    -----
    Valid for axis positions :math:`\Delta x` apart that are close: between two of them the envelope is high by
    :math:`\Delta x^2 / 8R`.

    Examples
    --------
    A mill of 5 mm that touches the edge stands 1 mm over it 3 mm to either side:

    >>> position, zero = np.linspace(-3e-3, 3e-3, 3), np.zeros(1)
    >>> (1e3 * cut_envelope(position, zero, zero + 5e-3, 5e-3, 2e-3)).round(9).tolist()
    [1.0, 0.0, 1.0]

    References
    ----------
    Derived here; Berselli et al. 2016, sec. 3.1, takes the lowest point of the mill, :math:`h_{pci} = y_A - D/2`.
    """
    m = position.size
    height = np.full(m, ceiling)
    pitch = position[1] - position[0]
    for k in range(centre_x.size):
        depth = ceiling - (centre_y[k] - radius)
        if depth <= 0.0:
            continue
        reach = radius if depth >= radius else math.sqrt(depth * (2.0 * radius - depth))
        first = max(0, math.ceil((centre_x[k] - reach - position[0]) / pitch))
        last = min(m - 1, math.floor((centre_x[k] + reach - position[0]) / pitch))
        for i in range(first, last + 1):
            d = position[i] - centre_x[k]
            h = centre_y[k] - math.sqrt(max(0.0, radius * radius - d * d))
            height[i] = min(height[i], h)
    return height


@compiled
def sorted_envelope(
    position: FloatArray, centre_x: FloatArray, centre_y: FloatArray, radius: float, ceiling: float
) -> FloatArray:
    r"""As :func:`cut_envelope`, for a mill that never goes back: :math:`x(t)` rises.

    Two circles of one radius cross at most once, the later one being the lower one behind it. So the circle that is
    lowest at w never comes before that of a smaller w, and it is enough to look between those of two neighbours:
    :math:`(m + n) \log m` heights in place of m times the circles within reach.

    Parameters
    ----------
    position, centre_x, centre_y, radius, ceiling
        As there; ``centre_x`` rising.

    Returns
    -------
    array
        Height of the envelope above the nominal edge [m], shape (m,).

    Notes
    -----
    Valid as :func:`cut_envelope`; not asked whether ``centre_x`` rises.

    Examples
    --------
    The mill of :func:`cut_envelope`, gone on to 3 mm:

    >>> position, x = np.linspace(-3e-3, 3e-3, 3), np.array([0.0, 3e-3])
    >>> (1e3 * sorted_envelope(position, x, np.full(2, 5e-3), 5e-3, 2e-3)).round(9).tolist()
    [1.0, 0.0, 0.0]

    References
    ----------
    Derived here.
    """
    m, n = position.size, centre_x.size
    height = np.full(m, ceiling)
    lowest = np.zeros(m, np.int64)
    stride = 1
    while stride < m:
        stride *= 2
    while stride >= 1:
        for i in range(stride - 1, m, 2 * stride):
            left, right = i - stride, i + stride
            first = lowest[left] if left >= 0 else 0
            last = lowest[right] if right < m else n - 1
            best, where = math.inf, first
            for k in range(first, last + 1):
                d = position[i] - centre_x[k]
                if d > radius:
                    where = k if best == math.inf else where
                elif d >= -radius:
                    h = centre_y[k] - math.sqrt(max(0.0, radius * radius - d * d))
                    if h < best:
                        best, where = h, k
                else:
                    break
            lowest[i] = where
            height[i] = min(ceiling, best)
        stride //= 2
    return height


def machined_profile(
    centre_x: FloatArray, centre_y: FloatArray, radius: float, burr: Polyline, points: int = 4000
) -> Surface:
    r"""Edge error along the work after the pass, :math:`e(w) = \min(h(w), h_b(w))`.

    Positive: burr left (partial deburring); negative: cut into the work (excessive).

    Parameters
    ----------
    centre_x, centre_y : array
        Mill axis at the height of the burr, over time [m], shape (n,).
    radius : float
        Mill radius [m].
    burr : Polyline
        Burr height along the edge [m].
    points : int
        Points of the profile.

    Notes
    -----
    Between two axis positions :math:`\Delta x` apart the envelope is high by :math:`\Delta x^2 / 8R`: 2 nm at
    8 µm and R = 4 mm.

    Examples
    --------
    A mill of 4 mm that runs 10 µm deep in the work, under a burr of 1 mm:

    >>> x, burr = np.linspace(0.0, 1e-3, 200), Polyline(np.zeros(1), np.array([1e-3]))
    >>> round(1e6 * float(machined_profile(x, np.full(200, 4e-3 - 1e-5), 4e-3, burr, 5).error[2]), 2)
    -10.0

    References
    ----------
    Berselli et al. 2016, Eq. (12), which takes the lowest point of the mill instead of the envelope.
    """
    position = np.linspace(centre_x[0], centre_x[-1], points)
    burr_height = np.interp(position, burr.at, burr.value)
    ceiling = float(max(burr.value.max(), 0.0)) + 1e-12
    step = max(1, int(_AXIS_PITCH * centre_x.size / max(abs(centre_x[-1] - centre_x[0]), _AXIS_PITCH)))
    at, above = centre_x[::step], centre_y[::step]
    envelope = sorted_envelope if bool(np.all(np.diff(at) >= 0.0)) else cut_envelope
    height = envelope(position, at, above, radius, ceiling)
    return Surface(position, height, np.minimum(height, burr_height), burr_height)
