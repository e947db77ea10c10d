# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cases of the campaign, drawn from a seed, and how one is run."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.faults.damage import draw_damage, KINDS
from benchmarks.faults.layouts import Layout, LAYOUTS, sample_messages, write_layout, Written
from benchmarks.faults.oracle import judge, Verdict

SEED, CASES_EACH = 20, 15
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
    return [
        Outcome(case, tolerant, judge(folder / 'bag.mcap', written, damage, is_tolerant=tolerant))
        for tolerant in (False, True)
    ]


@cache
def _written(layout: Layout) -> Written:
    return write_layout(layout, sample_messages(_SAMPLE))
