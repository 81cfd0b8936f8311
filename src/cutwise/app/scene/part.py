"""The part as a block, the same for every process that has one: seen through, about what is cut from it."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import FloatArray, Scene
from cutwise.app.scene.shapes import box
from cutwise.spec.part_block import PartBlock

if TYPE_CHECKING:
    from cutwise.results import Result


def block_of(result: "Result") -> PartBlock | None:
    """The block that a scenario says the part is; its frame in the middle of its lower face."""
    part = getattr(result.scenario, "part", None)
    found = part if isinstance(part, PartBlock) else getattr(part, "block", None)
    return found if isinstance(found, PartBlock) else None


def with_part(result: "Result", scene: Scene) -> Scene:
    """The scene with the block; the view stays on what is cut, where that is drawn."""
    block = block_of(result)
    if block is None or scene.map is not None:
        return scene
    wide = 0.5 * np.array([block.width_x, block.width_y])
    shown = box("part", np.array([*-wide, 0.0]), np.array([*wide, block.height]), "glass")
    return replace(
        scene, surfaces=(shown, *scene.surfaces), focus=scene.focus or _corners(scene),
        said=tuple(one for one in scene.said if not one.startswith("no part")),
    )  # fmt: skip


def _corners(scene: Scene) -> tuple[FloatArray, FloatArray] | None:
    if not scene.surfaces:
        return None
    points = np.concatenate([one.points for one in scene.surfaces])
    return points.min(axis=0), points.max(axis=0)
