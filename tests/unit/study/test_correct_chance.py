"""What differs from part to part by chance: the law of its weight, which keys it is, and a run-out whose phase is drawn."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process import milling
from cutwise.spec import fields
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.faults import split_dotted
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct import chance, path, shift
from cutwise.study.correct.uncertain import draws_of

DIAGONAL = "G21 G90 G17 G94 G61\nS900 M3\nG0 Z-5\nG1 X8 Y4.5 F600\nM2\n"


def test_weight_of_a_mean_in_its_scatter():
    mean = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 1.0, -1.0])
    deviation = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0001, 1.0])
    found = chance.weight(mean, deviation)
    assert found[[0, 1, 2, 3, 6]].tolist() == [1.0, 0.0, 0.0, 0.5, 0.5]
    assert found[4] == pytest.approx(0.2)
    assert found[5] == 0.0  # exactly: nothing below 0.2
    assert chance.weight(1e-6 * mean, 1e-6 * deviation) == pytest.approx(found)  # in whichever unit


@pytest.mark.parametrize("n", [1, 3, 9])
def test_no_part_is_expected_to_be_worse_than_uncorrected(n):
    """E e^2 = sigma^2 + (1 - w)^2 mu^2 + w^2 sigma^2/n, by draws: least at n = 1, never above no correction, and at most
    sigma^2/4 above a correction by the mean itself."""
    rng = np.random.default_rng(1)
    for mu in (0.0, 0.3, 0.6, 1.0, 2.0, 5.0):
        part, fitted = mu + rng.standard_normal(20_000), (mu + rng.standard_normal((20_000, n))).mean(axis=1)

        def square(w, part=part, fitted=fitted):
            return float(((part - w * fitted) ** 2).mean())

        w = float(chance.weight(np.array(mu), np.array(1.0)))
        law = 1.0 + (1.0 - w) ** 2 * mu**2 + w**2 / n
        assert square(w) == pytest.approx(law, rel=0.04)
        assert law <= 1.0 + mu**2
        assert law <= 1.0 + 1.0 / n + 0.25
        if n == 1 and w > 0.0:
            grid = np.linspace(0.0, 1.0, 201)
            best = grid[np.argmin(1.0 + (1.0 - grid) ** 2 * mu**2 + grid**2)]
            assert w == pytest.approx(best, abs=0.005)


def test_the_scenario_says_which_keys_differ_by_chance():
    """A rule and no list of names: the seed of a machine's geometry is the same for all parts."""
    for model, key, differs in (
        (MillingScenario, "tool.runout_angle", True),
        (MillingScenario, "tool.runout", False),
        (MillingScenario, "material.K_tc", False),
        (MillingScenario, "machine.x.J", False),
        (DeburringScenario, "part.burr.height.seed", True),
        (DeburringScenario, "part.burr.width.seed", True),
        (DeburringScenario, "operation.path_error.seed", True),
        (DeburringScenario, "part.burr.height.deviation", False),
    ):
        info = fields.field_at(model, split_dotted(key))
        assert info is not None, key
        assert fields.by_chance(info) == differs, key
    drawn = [(key, info) for key, info in fields.keys(MachineScenario) if key[-1] == "seed"]
    assert not any(fields.by_chance(info) for key, info in drawn if "geometry_errors" in key)


def plant_of(examples, tmp_path, vary, *given):
    file = tmp_path / "diagonal.nc"
    file.write_text(DIAGONAL)
    scenario = load(examples / "mill_pocket.yaml", [
        f"program={{file: {file}, start: {{x: 0 mm, y: 0 mm, z: 5 mm}}}}", "requirements=null", "numerics.settling_time=0.05 s",
        "numerics.discs=null", "tool.helix=0 deg", "tool.flutes=6", "tool.runout=100 um", "operation.radial_depth=8 mm",
        f"correct={{change: [path], vary: {vary}, draws: 12, seed: 3}}", *given,
    ])  # fmt: skip
    told = milling.commanded(scenario, scenario.numerics.substeps)
    return shift.Plant(scenario, told)


PHASE = "tool.runout_angle: {uniform: [0 deg, 360 deg]}"
FORCE = "material.K_tc: {normal: {mean: 767 N/mm^2, deviation: 70 N/mm^2}}"


def drawn(plant):
    fitted, judging = draws_of(plant.scenario, plant.scenario.correct)
    return fitted, *([path._drawn(plant, draw) for draw in some] for some in (fitted, judging))


def test_a_wave_whose_phase_nobody_knows_is_not_copied_into_the_part(examples, tmp_path):
    """Run-out of 0.1 mm at 15 Hz moves a part by 2 µm, here or there. Nine draws leave a wave of chance in their mean, which makes
    every other part worse; weighted it is left alone, and what all parts have in common at the start is corrected as before."""
    plant = plant_of(examples, tmp_path, f"{{{PHASE}}}")
    fitted, plants, others = drawn(plant)
    left = chance.left_alone(plant, plants, fitted, path._drawn)
    assert left.keys == ("tool.runout_angle",)
    assert 0.0 < left.weight < 1.0
    assert left.measures()["chance_weight"] == (left.weight, "dimensionless")
    assert "differs from part to part" in next(left.told())
    rule = shift.rule_of(plant.told, plant.scenario.drives.limits.jerk, None, None)
    counts = shift.judged(plant.told)
    steady = counts & (plant.told.place.time > 0.6)

    def squares(kept=None):
        order = plant.told.order
        if kept is not None:
            found = shift.learn(plants, rule, 2, kept=kept)
            order = shift.shifted(plant.told, found.at(plant.told.place.travelled))
        error = shift.seen(others, order).error
        return [float((error[:, some] ** 2).mean()) for some in (counts, steady)]

    none, mean, weighted = squares(), squares(0.0), squares(left.error)
    assert weighted[0] < none[0]
    assert weighted[1] <= 1.0005 * none[1]  # what a window lets through of the start
    assert weighted[1] < mean[1]
    assert mean[1] > none[1]


def test_what_is_the_same_for_all_parts_is_corrected_by_its_mean(examples, tmp_path):
    """A coefficient alone: nothing is left, to the last digit. Beside a phase it is the phase whose scatter counts."""
    plant = plant_of(examples, tmp_path, f"{{{FORCE}}}")
    fitted, plants, _ = drawn(plant)
    assert chance.left_alone(plant, plants, fitted, path._drawn) == chance.Left()
    assert chance.Left().measures() == {}
    assert list(chance.Left().told()) == []
    both = plant_of(examples, tmp_path, f"{{{FORCE}, {PHASE}}}", "tool.runout=0 um")
    fitted, plants, _ = drawn(both)
    left = chance.left_alone(both, plants, fitted, path._drawn)  # without run-out its phase moves nothing
    assert left.weight == pytest.approx(1.0)
    assert np.abs(left.error).max() < 1e-15
