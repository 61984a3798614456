"""When steps are due: on the grid whatever happens, and in step with a clock that others drive."""

from __future__ import annotations

import threading
import time

import pytest

from cloth_sim_ros.simulation.clock import ClockPace, Rhythm, Slot, WallPace

DT = 5_000_000


def test_slots_of_the_wall_clock_begin_on_the_grid_and_never_before_their_time():
    pace = WallPace(DT, time.time_ns)
    begins = []
    for _ in range(20):
        slot = pace.wait()
        assert time.monotonic_ns() >= slot.begin_ns
        begins.append(slot.begin_ns)
    assert {(later - begins[0]) % DT for later in begins} == {0}
    assert begins == sorted(set(begins))


def test_an_overrun_skips_whole_slots_and_counts_them():
    pace = WallPace(DT, time.time_ns)
    before = pace.wait()
    while time.monotonic_ns() < before.begin_ns + 4 * DT:  # a step that takes at least four slots
        pass
    after = pace.wait()
    passed = (after.begin_ns - before.begin_ns) // DT
    assert (after.begin_ns - before.begin_ns) % DT == 0
    assert passed >= 4
    assert pace.skipped >= passed - 1


def test_stamps_are_ros_time_and_keep_to_the_grid_while_the_clocks_agree():
    start = time.monotonic_ns()
    pace = WallPace(DT, lambda: time.monotonic_ns() - start + 7_000_000_000)
    slots = [pace.wait() for _ in range(10)]
    for slot in slots:
        assert slot.stamp_ns == pytest.approx(slot.begin_ns - start + 7_000_000_000, abs=1_000_000)
    assert {(slot.stamp_ns - slots[0].stamp_ns) % DT for slot in slots} == {0}


def test_stamps_follow_a_ros_clock_that_is_set():
    offset = 0
    pace = WallPace(DT, lambda: time.monotonic_ns() + offset)
    pace.wait()
    offset = 3_600_000_000_000
    stamps = [pace.wait() for _ in range(20)]
    assert any(slot.stamp_ns - slot.begin_ns == pytest.approx(offset, abs=2_000_000) for slot in stamps)


@pytest.mark.parametrize("pace", [WallPace(3_600_000_000_000, time.time_ns), ClockPace(DT)], ids=["wall", "clock"])
def test_waking_ends_the_wait_without_a_slot(pace):
    answers = []
    waiter = threading.Thread(target=lambda: answers.append(pace.wait()))
    waiter.start()
    pace.wake()
    waiter.join(timeout=10.0)
    assert answers == [None]


def due(pace):
    """Stamps of all slots that are due now, and which of them began a new episode."""
    slots = []
    while pace._is_due():
        slots.append(pace.wait())
    return [slot.stamp_ns for slot in slots], [slot.restarted for slot in slots]


def test_under_a_driven_clock_every_due_step_runs_and_none_before():
    pace = ClockPace(DT)
    assert pace.waiting_for_clock
    pace.advance(0)
    assert pace.waiting_for_clock
    pace.advance(1_000_000_000)
    assert not pace.waiting_for_clock
    assert due(pace) == ([], [])
    pace.advance(1_000_000_000 + DT - 1)
    assert due(pace) == ([], [])
    pace.advance(1_000_000_000 + DT)
    assert due(pace) == ([1_000_000_000 + DT], [False])
    pace.advance(1_000_000_000 + 4 * DT)
    assert due(pace)[0] == [1_000_000_000 + k * DT for k in (2, 3, 4)]
    assert pace.skipped == 0


def test_a_driven_clock_that_goes_back_begins_a_new_episode_once():
    pace = ClockPace(DT)
    pace.advance(1_000_000_000)
    pace.advance(1_000_000_000 + 2 * DT)
    assert due(pace)[1] == [False, False]
    pace.advance(500_000_000)
    pace.advance(500_000_000 + 2 * DT)
    assert due(pace) == ([500_000_000 + DT, 500_000_000 + 2 * DT], [True, False])


def test_a_slot_of_the_wall_presses_and_one_of_a_driven_clock_does_not():
    long_ago = Slot(stamp_ns=1, begin_ns=time.monotonic_ns() - 10 * DT, duration_ns=DT)
    assert long_ago.out_of_time(0.8)()
    assert long_ago.is_over()
    far_ahead = Slot(stamp_ns=1, begin_ns=time.monotonic_ns() + 10**12, duration_ns=DT)
    assert not far_ahead.out_of_time(0.8)()
    assert not far_ahead.is_over()
    timeless = Slot(stamp_ns=1, begin_ns=None, duration_ns=DT)
    assert timeless.out_of_time(0.8) is None
    assert not timeless.is_over()


def test_the_rhythm_counts_late_frames_and_knows_percentiles_of_the_step_time():
    rhythm = Rhythm()
    assert (rhythm.rate, rhythm.step_time_ms(50)) == (0.0, 0.0)
    for number in range(101):
        late = number % 10 == 0
        begin = time.monotonic_ns() - (2 * DT if late else 0) + (0 if late else 10**12)
        rhythm.note(Slot(stamp_ns=0, begin_ns=begin, duration_ns=DT), step_seconds=number / 1e3)
    assert rhythm.missed == 11
    assert rhythm.step_time_ms(50) == pytest.approx(50.0)
    assert rhythm.step_time_ms(99) == pytest.approx(99.0)
    assert rhythm.rate > 0.0
    rhythm.forget()
    assert rhythm.rate == 0.0
