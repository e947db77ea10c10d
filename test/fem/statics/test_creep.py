# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Creep of a held load: the modulus that falls, against the relaxation that it stands for."""

from itertools import pairwise

from diffcal_ros.fem.statics.creep import Creep, CreepChange, NO_CREEP
import numpy as np
import pytest
from support.bodies import GRAVITY, hanging_beam, uniform_material

PAIR = Creep(0.3, 4.0)


def test_a_constant_stress_is_what_the_relaxing_strain_gives() -> None:
    """The strain of the compliance, put into the hereditary integral, is a constant stress."""
    for steps in (400, 800):
        times = np.linspace(0.0, 12.0, steps + 1)
        strains = np.array([1.0 / PAIR.factor(t) for t in times])
        stress, history = strains[0], strains[0]
        step = times[1]
        worst = 0.0
        for before, after in pairwise(strains):
            history = np.exp(-step / PAIR.time) * history
            history += np.exp(-0.5 * step / PAIR.time) * (after - before)
            stress = (1.0 - PAIR.share) * after + PAIR.share * history
            worst = max(worst, abs(stress - 1.0))
        # The midpoint rule errs by the square of the step.
        assert worst < 0.02 * step**2, steps


def test_limits_of_time() -> None:
    assert PAIR.factor(0.0) == PAIR.factor(-3.0) == 1.0
    assert PAIR.factor(1e4) == pytest.approx(1.0 - PAIR.share)
    assert NO_CREEP.factor(5.0) == 1.0


@pytest.mark.parametrize('held', [0.5, 3.0, 20.0])
def test_slopes(held: float) -> None:
    by_share, by_time = PAIR.slopes(held)
    for step in (1e-2, 1e-3, 1e-4):
        more = Creep(PAIR.share + step, PAIR.time).factor(held)
        less = Creep(PAIR.share - step, PAIR.time).factor(held)
        assert (more - less) / (2.0 * step) == pytest.approx(by_share, rel=20.0 * step)
        later = Creep(PAIR.share, PAIR.time + step).factor(held)
        sooner = Creep(PAIR.share, PAIR.time - step).factor(held)
        assert (later - sooner) / (2.0 * step) == pytest.approx(by_time, rel=20.0 * step)
    change = CreepChange(creep=PAIR, share=2.0, time=-0.5)
    assert change.along(held) == pytest.approx(2.0 * by_share - 0.5 * by_time)
    assert PAIR.slopes(-1.0) == (0.0, 0.0)


def test_no_static_gradient_knows_creep() -> None:
    body = hanging_beam()
    body.solve_equilibrium(uniform_material(body.mesh), GRAVITY)
    gradient = body.gradient(np.ones_like(body.state.positions))
    with pytest.raises(NotImplementedError, match='does not know creep: use `tangents`'):
        gradient.along(CreepChange(creep=Creep(0.2, 4.0), share=1.0))
