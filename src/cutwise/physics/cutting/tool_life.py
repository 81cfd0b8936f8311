"""How long a tool lasts, and what a part costs with it."""

import math


def life_ratio(
    speed: float, feed: float = 1.0, depth: float = 1.0, *, speed_exponent: float, feed_exponent: float = 0.0,
    depth_exponent: float = 0.0,
) -> float:  # fmt: skip
    r"""Tool life over that of a reference cut.

    .. math:: T / T_0 = (v/v_0)^{-1/n} (f/f_0)^{-q} (a_p/a_0)^{-m}

    Parameters
    ----------
    speed, feed, depth : float
        Cutting speed, feed per tooth and axial depth over those of the reference [1], above 0.
    speed_exponent, feed_exponent, depth_exponent : float
        n, q, m [1].

    Returns
    -------
    float
        [1]

    Notes
    -----
    Valid near the reference, where one kind of wear governs: within about 30 % of its speed and feed.

    Examples
    --------
    A fifth more speed at n = 0.25:

    >>> round(life_ratio(1.2, speed_exponent=0.25), 6)
    0.482253

    References
    ----------
    Taylor 1906, On the Art of Cutting Metals, extended by feed and depth.
    """
    logarithm = -math.log(speed) / speed_exponent - feed_exponent * math.log(feed) - depth_exponent * math.log(depth)
    return math.exp(logarithm)


def cheapest_feed(rate: float, price: float, life: float, feed_exponent: float) -> float:
    r"""Feed of the cheapest cut over that of a reference cut, at one cutting speed.

    .. math:: \frac{f}{f_0} = \left(\frac{r\,T_0}{p\,(q - 1)}\right)^{1/q} \quad\text{least of}\quad
              \frac{1}{f}\left[r + \frac{p}{T_0} \left(\frac{f}{f_0}\right)^q\right]

    Parameters
    ----------
    rate : float
        Of the machine, r [EUR/s].
    price : float
        Of a tool, p [EUR].
    life : float
        How long it lasts at the reference feed, :math:`T_0` [s].
    feed_exponent : float
        q [1].

    Returns
    -------
    float
        [1]; infinite where a quicker feed is always cheaper, :math:`q \le 1`.

    Notes
    -----
    Valid with :func:`life_ratio`, near its reference.

    Examples
    --------
    1 EUR/min, 60 EUR an edge of 15 min, q = 2: half the feed costs 0.033333 EUR/s over half the feed, the least.

    >>> round(cheapest_feed(1 / 60, 60.0, 900.0, 2.0), 9)
    0.5
    >>> cheapest_feed(1 / 60, 60.0, 900.0, 0.36)
    inf

    References
    ----------
    Derived here from :func:`part_cost` and :func:`life_ratio`; for the speed in place of the feed: Altintas 2012, ch. 2.
    """
    if feed_exponent <= 1.0 or price <= 0.0:
        return math.inf
    return float((rate * life / (price * (feed_exponent - 1.0))) ** (1.0 / feed_exponent))


def part_cost(rate: float, time: float, price: float = 0.0, cutting: float = 0.0, life: float = math.inf) -> float:
    r"""Cost of a part: the machine's time, and the share of a tool that is worn.

    .. math:: K = r t + p\, t_c / T

    Parameters
    ----------
    rate : float
        r [EUR/s].
    time, cutting : float
        t of the part, :math:`t_c` of it in the cut [s].
    price, life : float
        p of a tool [EUR], and how long it lasts T [s].

    Returns
    -------
    float
        [EUR]. Valid for tools that are changed when they are worn; changing them, scrap and energy are left out.

    Examples
    --------
    24.478 s at 1 EUR/min, 21.812 s of a tool of 60 EUR that lasts 90 min:

    >>> round(part_cost(1 / 60, 24.478, 60.0, 21.812, 5400.0), 4)
    0.6503

    References
    ----------
    Altintas 2012, Manufacturing Automation, ch. 2 (the economics of machining).
    """
    return rate * time + price * cutting / life
