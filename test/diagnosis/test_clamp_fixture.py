# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The blocks around one clamp or several that a blind case states."""

import numpy as np
import pytest
import trimesh

from benchmarks.diagnosis import clamp_fixture

ONE = {'x': [-0.004, 0.02], 'y': [-0.01, 0.01], 'z': [-0.006, 0.006]}
TWO = {**ONE, 'x': [0.1, 0.124]}


def test_one_block_is_a_box() -> None:
    fixture = clamp_fixture({'note': 'a block', 'box': ONE})
    assert fixture.positions.min(axis=0) == pytest.approx([-0.004, -0.01, -0.006])
    assert fixture.positions.max(axis=0) == pytest.approx([0.02, 0.01, 0.006])


def test_two_blocks_are_one_closed_surface() -> None:
    one, both = clamp_fixture({'box': ONE}), clamp_fixture({'boxes': [ONE, TWO]})
    surface = trimesh.Trimesh(both.positions, both.triangles, process=False)
    assert surface.is_watertight
    assert surface.volume == pytest.approx(2.0 * 0.024 * 0.02 * 0.012)
    assert both.positions[: len(one.positions)] == pytest.approx(one.positions)
    assert np.abs(both.positions[:, 0]).max() == pytest.approx(0.124)
    assert both.triangles.dtype == one.triangles.dtype
