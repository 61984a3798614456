"""What hands feel: the weight of what they hold, in their own axes, and a hum that changes make."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cloth_core import Pose
from cloth_core.scene import Scene
from cloth_sim_ros.simulation.haptics import CAUGHT, SLIPPED, Haptics
from cloth_sim_ros.simulation.simulation import Simulation

SCENE = """
cloth: {grid: {width: 0.3, height: 0.3, columns: 9, rows: 9}, position: [0.0, 0.0, 1.0]}
material: {areal_density: 0.4, damping: 4.0}
grasps: {hand: {radius: 0.05, slip_distance: 0.0}}
"""
WEIGHT = 0.4 * 0.09 * 9.81  # N
DT, FULL = 0.02, 5.0


class Hand:
    """A hand that holds a corner of a cloth in the air."""

    def __init__(self, turn=(0.0, 0.0, 0.0, 1.0)):
        self.simulation = Simulation(Scene.parse(SCENE))
        self.haptics = Haptics()
        self.pose = Pose((0.15, 0.15, 1.0), turn)
        self.hums = []

    def steps(self, count, closure=1.0):
        for _ in range(count):
            self.simulation.set_grasp_pose("hand", self.pose, 0.0)
            self.simulation.set_closure("hand", closure)
            self.frame = self.simulation.tick(0.0)
            self.hums.append(self.haptics.rumble(self.frame, DT, FULL)["hand"])


def test_a_hand_feels_the_weight_that_hangs_from_it_along_its_own_axes():
    turned = Hand((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))  # its y axis is the world's z
    turned.steps(400)
    wrench = turned.haptics.wrenches(turned.frame)["hand"]
    assert wrench.force == pytest.approx((0.0, -WEIGHT, 0.0), abs=0.01 * WEIGHT)
    mass = turned.simulation.solver.mesh.vertex_mass(turned.simulation.solver.material)
    lever = mass @ turned.frame.position / mass.sum() - turned.pose.position
    torque = turned.pose.rotation.T @ np.cross(lever, (0.0, 0.0, -WEIGHT))
    assert np.linalg.norm(torque) > 0.01 * WEIGHT  # the fingers hold a patch, from whose edge it hangs
    assert wrench.torque == pytest.approx(tuple(torque), abs=0.002 * WEIGHT)


def test_an_empty_hand_feels_nothing():
    hand = Hand()
    hand.steps(3, closure=0.0)
    assert hand.haptics.wrenches(hand.frame)["hand"].force == (0.0, 0.0, 0.0)
    assert hand.hums == [0.0, 0.0, 0.0]


def test_catching_hums_for_a_moment_and_a_weight_that_hangs_still_does_not():
    hand = Hand()
    hand.steps(2, closure=0.0)
    hand.steps(400)
    assert hand.hums[2] >= CAUGHT[0]
    assert max(hand.hums[-20:]) < 0.05
    before = len(hand.hums)
    hand.pose = Pose((0.15, 0.15, 1.4))  # a pull upwards
    hand.steps(10)
    assert max(hand.hums[before:]) > 0.2
    assert max(hand.hums) <= 1.0


def test_losing_the_cloth_hums_fully():
    hand = Hand()
    hand.simulation.solver.pin(hand.simulation.solver.mesh.group("bottom_left"))
    hand.steps(20)
    hand.pose = Pose((3.0, 3.0, 1.0))
    hand.steps(60)
    assert hand.frame.state.grips["hand"].vertex.tolist() == []
    assert hand.hums.count(SLIPPED[0]) >= round(SLIPPED[1] / DT)


def test_a_frame_that_does_not_follow_the_last_begins_anew():
    hand = Hand()
    hand.steps(50)
    assert hand.hums[-1] < CAUGHT[0]
    assert hand.haptics.rumble(hand.frame, DT, FULL)["hand"] >= CAUGHT[0]
