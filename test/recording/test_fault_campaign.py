# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sample of the campaign in benchmarks/faults: no traceback, no silent loss."""

from pathlib import Path
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))
from benchmarks.faults.cases import draw_cases, run_case  # noqa: E402
from benchmarks.faults.damage import KINDS  # noqa: E402
from benchmarks.faults.layouts import LAYOUTS  # noqa: E402
from benchmarks.faults.oracle import FAULTS  # noqa: E402

# Another seed than the campaign's own.
CASES = list(draw_cases(seed=4, each=1))


@pytest.mark.parametrize('layout', LAYOUTS, ids=lambda layout: layout.name)
def test_damage_is_refused_or_told(tmp_path, layout):
    outcomes = [
        outcome for case in CASES if case.layout == layout for outcome in run_case(case, tmp_path)
    ]
    assert len(outcomes) == 2 * len(KINDS)
    assert [one for one in outcomes if one.verdict.outcome in FAULTS] == []


def test_the_oracle_notices_a_loss(tmp_path, monkeypatch):
    """The judge is worth something: a reader that drops the last image is found out."""
    from diffcal_ros.recording.bag.mcap_messages import McapMessages

    whole = McapMessages.entries
    monkeypatch.setattr(McapMessages, 'entries', lambda self, topic: whole(self, topic)[:-1])
    cases = [case for case in CASES if case.layout.name == 'rosbag2 fastwrite']
    found = {one.verdict.outcome for case in cases for one in run_case(case, tmp_path)}
    assert 'silent loss' in found
