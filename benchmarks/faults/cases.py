# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cases of the campaign, drawn from a seed, and how one is run."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
import json
from pathlib import Path

import numpy as np

from benchmarks.faults.damage import draw_damage, KINDS
from benchmarks.faults.layouts import (
    Layout,
    LAYOUTS,
    Recorded,
    sample_messages,
    write_layout,
    Written,
)
from benchmarks.faults.oracle import judge, Truth, Verdict

SEED, CASES_EACH = 20, 21
_SAMPLE = Path(__file__).resolve().parents[2] / 'bags' / 'sample' / 'bag' / 'bag_0.mcap'


@dataclass(frozen=True)
class Case:
    """One damaged file."""

    layout: Layout
    kind: str
    seed: tuple[int, ...]

    @property
    def name(self) -> str:
        """For messages, and to run it again."""
        return f'{self.layout.name}, {self.kind} {self.seed}'


@dataclass(frozen=True)
class Outcome:
    """One reading of a damaged file."""

    case: Case
    is_tolerant: bool
    verdict: Verdict


def draw_cases(seed: int, each: int) -> Iterator[Case]:
    """List so many cases of each layout and damage."""
    for number in range(each):
        for place, layout in enumerate(LAYOUTS):
            for kind_place, kind in enumerate(KINDS):
                yield Case(layout, kind, (seed, number, place, kind_place))


def run_case(case: Case, folder: Path) -> list[Outcome]:
    """Read a damaged file in both ways."""
    written = _written(case.layout)
    damage = draw_damage(written, case.kind, np.random.default_rng(case.seed))
    if case.layout.is_split:
        file, bag = folder / 'split' / 'bag_1.mcap', folder / 'split'
        first = _first_file(case.layout)
        _write_first_file(bag, first, written)
        beside = first.messages
    else:
        file = bag = folder / 'bag.mcap'
        beside = []
    file.write_bytes(damage.content)
    truth = Truth(written, damage, beside)
    return [
        Outcome(case, tolerant, judge(bag, truth, is_tolerant=tolerant))
        for tolerant in (False, True)
    ]


def _write_first_file(bag: Path, first: Written, second: Written) -> None:
    """Write what stands beside the damaged file of a split bag."""
    bag.mkdir(exist_ok=True)
    (bag / 'bag_0.mcap').write_bytes(first.content)
    counts = Counter(message.topic for message in (*first.messages, *second.messages))
    topics = [
        {'topic_metadata': {'name': topic}, 'message_count': count}
        for topic, count in counts.items()
    ]
    information = {
        'storage_identifier': 'mcap',
        'relative_file_paths': ['bag_0.mcap', 'bag_1.mcap'],
        'topics_with_message_count': topics,
    }
    text = json.dumps({'rosbag2_bagfile_information': information})
    (bag / 'metadata.yaml').write_text(text)


@cache
def _written(layout: Layout) -> Written:
    messages = sample()
    return write_layout(layout, messages[len(messages) // 2 :] if layout.is_split else messages)


@cache
def _first_file(layout: Layout) -> Written:
    messages = sample()
    return write_layout(layout, messages[: len(messages) // 2])


@cache
def sample() -> list[Recorded]:
    """Return what is recorded in the bags of the campaign."""
    return sample_messages(_SAMPLE)
