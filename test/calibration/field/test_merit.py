# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cost of what is found does not leap where an edge is lost, and tells that it was."""

from diffcal_ros.calibration.field.merit import measure_merit
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_loss import robust_cost
from diffcal_ros.calibration.residuals.robust_residual import ResidualKind, Residuals
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth


def _objective(depth: np.ndarray) -> tuple[RobustObjective, np.ndarray]:
    scene = beam_scene((6, 2, 2), modulus=75e3, fit=('youngs_modulus', 'rigid_offset'))
    parameters = make_parameters(scene)
    objective = RobustObjective(ForwardModel(scene, [observation(depth)], parameters))
    start = parameters.start()
    start[1] = 0.004
    while not objective.is_annealed:
        objective.anneal(start)
    return objective, start


def test_it_is_the_cost_of_what_was_found() -> None:
    objective, start = _objective(true_depth())
    merit = measure_merit(objective, start)
    (comparison,) = objective.comparisons(start)
    lost = comparison.depth.missing + comparison.edge.missing
    assert merit.missing.sum() == lost
    assert merit.lost(merit) == 0.0
    # The cost counts outline that is not found as if it were as far off as was looked.
    empty, nowhere = np.zeros(0), np.zeros((0, 2))
    nothing = Residuals(ResidualKind.EDGE, empty, empty, nowhere, nowhere, lost)
    as_far = robust_cost(nothing, objective.scales)
    assert as_far > 0.0
    assert merit.cost(merit) + as_far == pytest.approx(objective.cost(start), rel=1e-12)


def test_a_hole_in_the_image_changes_the_cost_and_hardly_the_merit() -> None:
    depth = true_depth()
    whole, start = _objective(depth)
    columns = np.flatnonzero(np.isfinite(depth).any(axis=0))
    torn = depth.copy()
    # Something far in front hides a quarter of the body: it is rendered there, and not found.
    torn[:, columns[len(columns) // 4] : columns[len(columns) // 2]] = 0.1
    broken, _ = _objective(torn)
    broken.scales = whole.scales
    before, after = measure_merit(whole, start), measure_merit(broken, start)
    leap = broken.cost(start) / whole.cost(start)
    assert leap > 1.3
    assert abs(after.cost(before) / before.cost(before) - 1.0) < 0.4 * (leap - 1.0)
    assert after.lost(before) > 0.1
