# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The CAD of a clamp tells which end of a body is held, and from where."""

from diffcal_ros.proposal.fixture_hold import fixture_hold
from diffcal_ros.scene.model import Fixture
import numpy as np
import pytest

from benchmarks import rigid_parts

HALF = np.array([0.02, 0.025])


def around(part: Fixture, end: float, *, sign: float) -> Fixture:
    """Put a part around a beam's end at x = `end`; it runs away from the beam."""
    positions = part.positions * [sign, 1.0, 1.0]
    triangles = part.triangles if sign > 0.0 else part.triangles[:, ::-1]
    return Fixture(positions + np.array([end, 0.0, 0.0]), triangles)


@pytest.mark.parametrize(('end', 'sign'), [(-0.07, 1.0), (0.07, -1.0)])
@pytest.mark.parametrize('name', ['block', 'bracket'])
def test_the_end_in_the_fixture_is_held_up_to_its_front(make_beam, end, sign, name):
    mesh = make_beam((16, 2, 3), (0.2, 0.02, 0.035))
    part = around(getattr(rigid_parts, name)(HALF, 0.05), end, sign=sign)
    hold = fixture_hold(mesh, part)
    np.testing.assert_allclose(hold.direction, [-sign, 0.0, 0.0], atol=1e-12)
    assert hold.plane == pytest.approx(-sign * end, abs=1e-9)


def test_a_far_foot_of_the_clamp_does_not_hold(make_beam):
    mesh = make_beam((16, 2, 3), (0.2, 0.02, 0.035))
    near = around(rigid_parts.block(HALF, 0.05), -0.07, sign=1.0)
    foot = rigid_parts.blocks([((-0.12, 0.05), (-0.2, -0.18), (0.0, 0.04))])
    both = Fixture(
        np.vstack([near.positions, foot.positions]),
        np.vstack([near.triangles, foot.triangles + len(near.positions)]).astype(np.int32),
    )
    hold = fixture_hold(mesh, both)
    assert hold.plane == pytest.approx(0.07, abs=1e-9)
