# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Blind cases as they are drawn, with their labels."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from benchmarks.blind.cases import Case
from benchmarks.blind.generator import draw_case
from benchmarks.blind.labels import label_of
from benchmarks.blind.setups import Setup


def labelled(cases: Iterable[Case]) -> Iterator[tuple[Case, Setup, Any, dict[str, Any]]]:
    """Draw cases; yield each with its set-up, effects and label.

    Those with a contact are left out: drawing them takes a simulation.
    """
    for case in cases:
        if 'contact_plane' not in str(case.effects):
            setup, effects, faults = draw_case(case)
            yield case, setup, effects, label_of(case, setup, effects, faults, np.zeros(3))


def check_label(case: Case, label: dict[str, Any]) -> None:
    """Fail where a label does not tell the law, as many effects, or the class of a case."""
    assert label['rubber']['law'] == case.law
    assert len(label['effects']) == len(case.effects)
    assert (label['outside_class'] is None) == (case.kind != 'outside')
