"""The comparison of integrators: each scheme has its order, each solve is counted, the verdict follows the figures."""

from __future__ import annotations

import importlib.util
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

from motion import contestants, integrators, measure, picture, reference, report
from motion.cloth import MASS, SIDE, release_test
from motion.minimisers import anderson, chebyshev, lbfgs, local_global
from motion.stage import Objective, Stage, _filter, give_back_turn

BENCHMARKS = Path(reference.__file__).parents[1]
MINIMISERS = {
    "local/global": local_global,
    "Chebyshev": chebyshev(0.3),
    "Anderson": anderson(5),
    "L-BFGS": lbfgs(5),
    "L-BFGS kept": lbfgs(5, keep=True),
}


@pytest.fixture
def cloth():
    return release_test(50.0, side=8)


@pytest.fixture
def bent(cloth):
    """Where inertia might lead the cloth, far from rest."""
    away = cloth.start + np.random.default_rng(3).normal(0.0, 0.02, cloth.start.shape)
    away[cloth.pins] = cloth.start[cloth.pins]
    return away


@pytest.fixture(scope="module")
def true_end():
    return after(release_test(50.0, side=8), integrators.sdirk2, 320)


def after(cloth, integrator, steps, seconds=0.2, iterations=25):
    """Positions at the end of so many steps."""
    moving = integrator(cloth, seconds / steps, Stage(cloth, local_global, iterations))
    return next(islice(moving, steps - 1, None))[0]


def test_the_cloth_is_that_of_the_release_test():
    cloth = release_test(200.0)
    along, count = cloth.stiffness, 30
    assert len(cloth.start) == count**2 and np.isclose(cloth.mass * count**2, MASS)
    assert (along == 200.0).sum() == 2 * count * (count - 1) == cloth.thread.sum()
    assert (along == 100.0).sum() == 2 * (count - 1) ** 2 and (along == 2.0).sum() == 2 * count * (count - 2)
    assert np.isclose(np.linalg.norm(np.diff(cloth.start[cloth.pins], axis=0)), SIDE)
    assert np.array_equal(np.sort(cloth.ends[0]), [0, count])


def test_forces_are_the_slope_of_the_energy(cloth, bent):
    direction = np.random.default_rng(4).normal(size=bent.shape)
    slope = (cloth.elastic_energy(bent + 1e-6 * direction) - cloth.elastic_energy(bent - 1e-6 * direction)) / 2e-6
    assert slope == pytest.approx(-(cloth.elastic_force(bent) * direction).sum(), rel=1e-6)


@pytest.mark.parametrize(
    ("integrator", "order"),
    [
        (integrators.implicit_euler, 1),
        (integrators.bdf2, 2),
        (integrators.midpoint, 2),
        (integrators.trapezoidal, 2),
        (integrators.sdirk2, 2),
    ],
)
def test_halving_the_step_shows_the_order(cloth, true_end, integrator, order):
    coarse, fine = (np.linalg.norm(after(cloth, integrator, steps) - true_end) for steps in (40, 80))
    assert 0.8 * 2**order < coarse / fine < 1.25 * 2**order


@pytest.mark.parametrize("name", MINIMISERS)
def test_minimisers_spend_the_solves_they_are_given_and_find_the_minimum(cloth, bent, name):
    tau, solves = 0.002, 0
    w = _filter(cloth, tau, 1.0)

    def counted(right_side):
        nonlocal solves
        solves += 1
        return w(right_side)

    phi = Objective(cloth, tau, bent)
    z = MINIMISERS[name](phi, counted, bent, 30)
    assert solves == 30
    free = np.delete(np.arange(len(bent)), cloth.pins)
    assert np.abs(phi.gradient(z)[free]).max() < 1e-8 * np.abs(phi.gradient(bent)[free]).max()
    assert np.array_equal(z[cloth.pins], cloth.start[cloth.pins])


def test_the_turn_given_back_leaves_no_moment_about_the_pins(cloth, bent):
    z = Stage(cloth, local_global, 1)(bent, 0.004)
    inertial = bent + 0.004**2 * np.array([0.0, 0.0, -9.81])

    def moment(moved):  # about the x axis, through both pins
        return np.cross(z, moved - inertial)[:, 0].sum()

    turned = give_back_turn(cloth, inertial, z)
    assert abs(moment(z)) > 1e-6
    assert abs(moment(turned)) < 1e-10 * abs(moment(z))
    assert np.allclose(turned[cloth.pins], z[cloth.pins], atol=1e-15)
    settled = Stage(cloth, local_global, 200)(bent, 0.004)
    assert np.allclose(give_back_turn(cloth, inertial, settled), settled, atol=1e-12)


def test_the_kept_reference_tells_good_from_bad():
    heights, stretch = reference.read()
    assert all(len(h) == 10 for h in heights.values()) and 1.0 < stretch[2000] < stretch[200] < 1.5
    soft = {200: heights[200]}
    euler, *_, ours = contestants.INTEGRATORS
    assert 0.002 < measure.best_split(ours, 10, soft, hinge=True).error[200] < 0.006
    assert 0.015 < measure.best_split(euler, 10, soft, hinge=True).error[200] < 0.035


def test_a_motion_that_blows_up_is_called_unstable():
    over = next(one for one in contestants.OTHERS if one.tweaks.get("warm") == 0.9)
    score = measure.best_split(over, 10, dict.fromkeys((200, 2000), np.zeros(10)), hinge=False)
    assert score.error == dict.fromkeys((200, 2000), float("inf")) and not report.reaches_bar(a_row(score))
    assert "unstable" in report.report([a_row(score)], {200: 1.3, 2000: 1.1}, 10.0)


def a_row(score, name="midpoint", hinge=True):
    return report.Row(name, hinge, True, dict.fromkeys((10, 20), score), {})


def test_the_verdict_names_bar_and_aim():
    row = a_row(measure.Score(10, 1, {200: 0.0041, 2000: 0.0149}))
    soft, stiff = report.verdicts([row])
    assert soft.endswith("0.0041 m; bar 0.010 reached, aim 0.004 missed")
    assert stiff.endswith("0.0149 m; bar 0.050 reached, aim 0.015 reached")
    assert report.reaches_bar(row)
    assert not report.reaches_bar(a_row(measure.Score(10, 1, {200: 0.001, 2000: 0.051})))


def test_the_picture_is_drawn_or_matplotlib_is_named_missing(tmp_path):
    row = a_row(measure.Score(10, 1, {200: 0.004, 2000: float("inf")}))
    looked_at = report.Row("BDF2", True, False, {10: row.scores[10]}, {})
    drawn = picture.draw([row, looked_at], tmp_path / "motion.svg")
    assert drawn == (importlib.util.find_spec("matplotlib") is not None) == (tmp_path / "motion.svg").exists()


def test_the_command_stands_beside_its_package_of_the_same_name(capsys, monkeypatch):
    spec = importlib.util.spec_from_file_location("motion_command", BENCHMARKS / "motion.py")
    command = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(command)
    monkeypatch.setattr(sys, "argv", ["motion.py", "--help"])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 0 and "--quick" in capsys.readouterr().out
