"""How much a result moves when its step is halved."""

from collections.abc import Mapping


def change_on_halved_step(coarse: Mapping[str, float], fine: Mapping[str, float]) -> dict[str, float]:
    """Change of every measure that both runs have, fine minus coarse, in SI."""
    return {name: fine[name] - value for name, value in coarse.items() if name in fine}
