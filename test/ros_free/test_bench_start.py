"""The benchmark of starts: its processes do what they say, and memory is what the system counts."""

from __future__ import annotations

import mmap
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

from comparison import process
from starting import child, processes

STATUS = "Name:\tpython\nVmPeak:\t  900000 kB\nVmHWM:\t  524288 kB\nVmRSS:\t  262144 kB\nThreads:\t1\n"


def test_memory_is_read_in_binary_megabytes():
    assert child.memory_mb(STATUS) == {"resident_mb": 256.0, "peak_mb": 512.0}


def test_the_status_of_a_process_that_has_ended_is_refused():
    with pytest.raises(ValueError, match="no VmHWM and VmRSS"):
        child.memory_mb("Name:\tpython\nState:\tZ (zombie)\n")


def test_memory_that_is_touched_and_given_back_shows_at_the_peak_alone():
    def now():
        return child.memory_mb(Path("/proc/self/status").read_text())

    with mmap.mmap(-1, 256 << 20) as block:
        for page in range(0, len(block), mmap.PAGESIZE):
            block[page] = 1
        held = now()
    freed = now()
    assert 240.0 <= held["resident_mb"] - freed["resident_mb"] <= 270.0
    assert freed["peak_mb"] >= held["resident_mb"] - 1.0


def test_the_first_frame_has_a_hand_and_a_contact_and_its_times_add_up():
    taken = processes.first_frame(12)
    assert taken["held"] > 2  # the pins are two
    assert taken["contacts"] > 0
    assert taken["python_s"] + taken["import_s"] + taken["step_s"] == pytest.approx(taken["first_frame_s"])
    assert 30.0 < taken["resident_mb"] <= taken["peak_mb"] < 2000.0


@pytest.mark.parametrize("scene", ["hang", "drape"])
def test_memory_is_taken_of_a_cloth_that_does_what_its_name_says(scene):
    taken = processes.child("memory", 12, scene)
    assert (taken["contacts"] > 0) is (scene == "drape")
    assert 30.0 < taken["resident_mb"] <= taken["peak_mb"] < 2000.0


def test_kernels_are_kept_in_the_cache_that_a_child_is_given():
    with processes.empty_cache() as cache:
        assert list(Path(cache).iterdir()) == []
        code = "from cloth_core.kernels import cache_folder; print(cache_folder())"
        environment = processes._environment(cache)
        assert environment["NUMBA_CACHE_DIR"] == cache
        assert environment["NUMBA_NUM_THREADS"] == str(process.CORES)
        done = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
        assert Path(done.stdout.strip()).parent == Path(cache)
