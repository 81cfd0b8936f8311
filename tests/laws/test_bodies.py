"""Balance laws of a chain of yielding bodies, on random machines with rotary axes."""

import numpy as np
import pytest

from cutwise.maths import chains, frames
from cutwise.physics.structure import bodies, pads

GROUND, COUNT = 2, 5


@pytest.fixture(params=[0, 1, 2])
def machine(request):
    rng = np.random.default_rng(request.param)
    rotations = frames.exp_twists(rng.normal(size=(COUNT, 6)))[0]
    chain = chains.chain([2, 1, 1, 2, 0], rng.normal(size=(COUNT, 3)), rng.normal(size=(COUNT, 3)), rotations=rotations)
    at = chains.frames(chain, rng.normal(size=(4, COUNT)))
    tip = np.array([0.02, -0.05, 0.1])
    joints = np.array([1, 2, 3, 3, 4, 5])
    root = rng.normal(size=(6, 6, 6)) * 1e-4
    compliance = root @ np.swapaxes(root, -1, -2) + 1e-9 * np.eye(6)
    points, turned = bodies.place(at, joints, rng.normal(size=(6, 3)), compliance)
    tool = chains.tool_point(at, tip)
    force = rng.normal(size=(4, 3)) * 1e3
    others = rng.normal(size=(4, 4, 3)) * 1e2
    body = np.array([5, 0, 0, 1, 2, 4])
    loads = bodies.Loads(
        body,
        np.concatenate([force[:, None], -force[:, None], others], axis=1),
        np.concatenate([tool[:, None], tool[:, None], rng.normal(size=(4, 4, 3))], axis=1),
    )
    return at, tip, tool, bodies.Elements(joints, GROUND, points, turned), loads


def test_work_of_all_loads_is_twice_the_strain_energy(machine):
    *_, elements, loads = machine
    wrenches = bodies.element_wrenches(elements, loads)
    twists = bodies.element_twists(elements, wrenches)
    outside = bodies.external_work(loads, bodies.load_displacements(elements, twists, loads))
    inside = bodies.strain_work(wrenches, twists)
    assert bodies.energy_residual(outside, inside).max() < 1e-12
    assert (inside > 0.0).all()


def test_chain_sum_is_the_relative_displacement_of_tool_and_part(machine):
    at, tip, tool, elements, loads = machine
    twists = bodies.element_twists(elements, bodies.element_wrenches(elements, loads))
    moved = bodies.load_displacements(elements, twists, loads)
    by_chain = chains.linear_error(at, bodies.chain_twists(elements, twists, at), tip)
    assert by_chain == pytest.approx(moved[:, 0] - moved[:, 1], rel=1e-9, abs=1e-12 * np.abs(moved).max())
    assert bodies.contributions(elements, twists, tool).sum(axis=1) == pytest.approx(by_chain, rel=1e-9)


def test_maxwell_displacements_are_reciprocal(machine):
    *_, elements, loads = machine

    def displaced(load: int) -> np.ndarray:
        only = loads.force * (np.arange(len(loads.body)) == load)[:, None]
        twists = bodies.element_twists(elements, bodies.element_wrenches(elements, loads._replace(force=only)))
        return bodies.load_displacements(elements, twists, loads)

    for one, other in ((0, 3), (2, 4), (0, 5)):
        there = np.einsum("mi,mi->m", loads.force[:, other], displaced(one)[:, other])
        back = np.einsum("mi,mi->m", loads.force[:, one], displaced(other)[:, one])
        assert there == pytest.approx(back, rel=1e-9, abs=1e-15)


def test_an_element_far_from_the_tool_axis_does_not_care_where_its_point_is(machine):
    """Moving the point of a compliance, and the compliance with it, changes nothing."""
    *_, elements, loads = machine
    shift = np.array([0.3, -0.2, 0.5])
    turned = np.eye(6)
    turned[:3, 3:] = -frames.skew(shift)  # twist at c + s from twist at c
    moved = elements._replace(point=elements.point + shift, compliance=turned @ elements.compliance @ turned.T)
    results = []
    for given in (elements, moved):
        twists = bodies.element_twists(given, bodies.element_wrenches(given, loads))
        results.append(bodies.load_displacements(given, twists, loads))
    assert results[0] == pytest.approx(results[1], rel=1e-9)


def test_work_of_proportional_loads_is_convex_along_straight_travel():
    """One guide whose load arm grows with x: F . Delta is a parabola opening upward."""
    x = np.linspace(-0.2, 0.2, 21)
    compliance = pads.pad_compliance([[0.1, 0.1, 0], [-0.1, 0.1, 0], [0.1, -0.1, 0], [-0.1, -0.1, 0]], [1e8, 2e8, 3e8])
    force = np.array([300.0, -500.0, 800.0])
    points = np.zeros((21, 1, 3))
    elements = bodies.Elements(np.array([1]), 1, points, np.tile(compliance, (21, 1, 1, 1)))
    at_tool = np.column_stack([x, np.zeros(21), np.full(21, 0.3)])[:, None, :]
    loads = bodies.Loads(np.array([0]), np.tile(-force, (21, 1, 1)), at_tool)
    twists = bodies.element_twists(elements, bodies.element_wrenches(elements, loads))
    error = bodies.contributions(elements, twists, at_tool[:, 0])[:, 0]
    assert bodies.least_convexity(x, error @ force) > 0.0
    assert bodies.least_convexity(x, -(error @ force)) < 0.0
    uneven = np.unique(np.concatenate([x, [0.001, 0.0373]]))
    assert bodies.least_convexity(uneven, 3.0 * uneven**2) == pytest.approx(6.0 * 0.4**2 / 0.12)  # L^2 w''/max w
