# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit that came by small steps to where no single one leads is compared with others."""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.errors import NotSimulatedError
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

BENT = 60.0  # Curvature at rest [1/m], which takes steps.


def _objective() -> tuple[RobustObjective, np.ndarray]:
    scene = beam_scene((4, 1, 1))
    parameters = make_parameters(scene, ('youngs_modulus', 'rest_curvature'), with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    return RobustObjective(model), parameters.start()


@pytest.mark.slow
def test_figures_of_a_far_state_are_those_of_the_way_there() -> None:
    objective, start = _objective()
    straight = objective.misfit(start)
    there = start + np.array([0.0, BENT, 0.0])
    with pytest.raises(NotSimulatedError):
        objective.cost(there)
    found = objective.misfit(there)
    other, _ = _objective()
    for bend in np.linspace(0.0, BENT, 13):
        other.cost(start + np.array([0.0, bend, 0.0]))
    assert found.above_absence == pytest.approx(other.misfit(there).above_absence, rel=1e-6)
    assert found.above_absence > straight.above_absence, 'the beam is straight'
