"""Co-simulation: another program drives /clock, and the cloth follows it step by step."""

from __future__ import annotations

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

NAMESPACE = "/cosimulated/cloth_sim"
STEP_MS = 20
CORNER = 80


@pytest.fixture(scope="module")
def node(start_node):
    return start_node("-r", "__ns:=/cosimulated", "-p", "use_sim_time:=true")


class Driver:
    """A simulator of a robot: it says what time it is, and waits for the cloth of that time."""

    def __init__(self, peer):
        self.peer = peer
        self.clouds = peer.listen(PointCloud2, f"{NAMESPACE}/cloth/points")
        self.tell = peer.speak(Clock, "/clock")
        self.move = peer.speak(PoseStamped, f"{NAMESPACE}/grasp/hand/pose", 1)
        self.close = peer.speak(Float64, f"{NAMESPACE}/grasp/hand/closure")
        peer.wait_until(lambda: peer.node.count_publishers(f"{NAMESPACE}/cloth/points"), "the node's publisher")
        self.now = 0

    def stamps(self):
        return [round((c.header.stamp.sec * 10**9 + c.header.stamp.nanosec) / 1e6) for c in self.clouds]

    def clock(self, milliseconds):
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(milliseconds * 1_000_000, 10**9)
        self.tell(message)

    def begin(self, milliseconds):
        """A new episode from this time on, earlier than the last, for forward every step that is due would be done.

        Told with steps until the node and we have found each other.
        """
        self.clouds.clear()
        self.now = milliseconds

        def step():
            self.clock(self.now)
            self.now += STEP_MS

        self.peer.wait_until(
            lambda: self.stamps() and self.stamps()[-1] >= milliseconds, "a first step", meanwhile=step
        )
        self.now -= STEP_MS
        self.wait_for(self.now)

    def wait_for(self, milliseconds):
        self.peer.wait_until(
            lambda: self.stamps()[-1:] == [milliseconds],
            f"the step of {milliseconds} ms",
            meanwhile=lambda: self.clock(self.now),
        )

    def hand(self, position):
        message = PoseStamped()
        message.pose.position.x, message.pose.position.y, message.pose.position.z = (float(c) for c in position)
        message.pose.orientation.w = 1.0
        self.move(message)

    def step(self):
        self.now += STEP_MS
        self.clock(self.now)
        self.wait_for(self.now)

    def corner(self):
        return np.frombuffer(bytes(self.clouds[-1].data), "<f4").reshape(-1, 8)[CORNER, :3].astype(float)


@pytest.fixture
def driver(node, peer):
    return Driver(peer)


def test_a_pose_sent_before_a_tick_is_where_the_hand_is_in_its_step(driver, peer):
    driver.begin(9_000_000)
    held = peer.listen(Float64, f"{NAMESPACE}/stats/held")
    at = driver.corner()

    def grip():
        driver.hand(at)
        driver.close(Float64(data=1.0))
        driver.step()

    peer.wait_until(lambda: held and held[-1].data > 1.0, "the hand to hold the corner", meanwhile=grip)
    offset = driver.corner() - at
    late = 0
    for number in range(40):
        at = np.add(at, (0.0, 0.0, 0.004 if number % 2 else -0.003))
        driver.hand(at)
        driver.step()
        late += not np.allclose(driver.corner() - at, offset, atol=1e-5)
    assert late == 0


def test_paused_time_goes_on_without_steps_and_single_steps_are_stamped_with_it(driver, peer):
    driver.begin(8_000_000)
    assert peer.call(SetBool, f"{NAMESPACE}/pause", SetBool.Request(data=True)).success
    count = len(driver.clouds)
    driver.now += 10 * STEP_MS
    for _ in range(5):
        driver.clock(driver.now)
        assert peer.call(Trigger, f"{NAMESPACE}/step", Trigger.Request()).success
    peer.wait_until(lambda: len(driver.clouds) == count + 5, "five clouds")
    assert driver.stamps()[-1] == driver.now
    assert peer.call(SetBool, f"{NAMESPACE}/pause", SetBool.Request(data=False)).success
    driver.step()
    assert len(driver.clouds) == count + 6


def test_a_clock_faster_than_real_time_leaves_no_step_out(driver):
    driver.begin(7_000_000)
    first = driver.now
    for _ in range(25):
        driver.now += 8 * STEP_MS
        driver.clock(driver.now)
        driver.wait_for(driver.now)
    assert driver.stamps()[-200:] == list(range(first + STEP_MS, driver.now + 1, STEP_MS))


def test_a_clock_that_is_set_back_begins_a_new_episode_that_goes_as_the_first_did(driver):
    seen = []
    for start in (5_000_000, 4_000_000):
        driver.begin(start)  # back, and as many steps as it takes to meet
        driver.begin(start - 500_000)
        first = driver.stamps()[0]
        assert first < start
        while driver.stamps()[-1] < first + 20 * STEP_MS:
            driver.step()
        by_stamp = dict(zip(driver.stamps(), driver.clouds, strict=True))
        seen.append([bytes(by_stamp[first + k * STEP_MS].data) for k in range(20)])
    assert seen[0] == seen[1]
