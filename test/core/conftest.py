"""What the tests of the solver share."""

from __future__ import annotations

import sys
from pathlib import Path

import hypothesis

# Tests are imported one by one, so that their folder is on no path; the twins are theirs in common.
sys.path.insert(0, str(Path(__file__).parents[1]))

# A loaded machine is slow, not wrong; and a failure must come back in the next run.
hypothesis.settings.register_profile("core", deadline=None, derandomize=True, database=None, max_examples=60)
hypothesis.settings.load_profile("core")
