# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body whose place is stated better than coarse images tell is not placed anew."""

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.search import basins
from diffcal_ros.calibration.search.basins import Placing
from diffcal_ros.calibration.search.posed_shapes import CoarseObjective, PosedShapes
from diffcal_ros.calibration.search.shapes import make_shapes
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

_FIT = ('youngs_modulus', 'rigid_offset')


def _placing(position: float, rotation: float, fit=('youngs_modulus',)) -> Placing:
    """Prepare a beam whose camera's pose is stated with a correlation."""
    scene = beam_scene((4, 2, 2), fit=fit)
    covariance = np.diag([position**2] * 3 + [rotation**2] * 3)
    covariance[0, 4] = covariance[4, 0] = -0.5 * position * rotation
    parameters = make_parameters(scene, pose_covariances=[covariance])
    model = PosedShapes(scene, [observation(true_depth())], parameters)
    shapes = make_shapes(model, parameters.start(), None)
    return Placing(model, CoarseObjective(model, 1, device='cpu'), shapes)


def _spread(placing: Placing, random: np.random.Generator) -> float:
    """Return how far places drawn from what is stated are apart, of the point with most [m]."""
    parameters, world = placing.model.parameters, placing.shapes[0].world[0]
    mean, precision = parameters.prior()
    stated = np.flatnonzero(np.diagonal(precision))
    covariance = np.linalg.inv(precision[np.ix_(stated, stated)])
    points = []
    for _ in range(400):
        drawn = mean.copy()
        drawn[stated] = random.multivariate_normal(mean[stated], covariance)
        points.append(placing.model.cameras.points(0, world, drawn))
    variances = np.var(points, axis=0).sum(axis=1)
    return float(np.sqrt(variances.max()))


@pytest.mark.parametrize(('position', 'rotation'), [(0.0008, 1e-6), (1e-6, 0.004), (0.001, 0.003)])
def test_what_a_stated_pose_leaves_open_is_what_drawn_poses_differ_by(position, rotation, random):
    placing = _placing(position, rotation)
    told = placing.doubt
    assert told > 0.0005
    assert told == pytest.approx(_spread(placing, random), rel=0.15)


def test_only_a_place_that_is_stated_loosely_is_looked_for(monkeypatch) -> None:
    asked = []

    def minimise(objective, start, *rest, **more):
        asked.append(start)
        raise basins.NotSimulatedError('nothing is asked for here')

    monkeypatch.setattr(basins, 'minimise', minimise)
    firm, loose = _placing(0.0003, 0.0005), _placing(0.003, 0.01, _FIT)
    start = firm.model.parameters.start()
    found = firm.place(2, start)
    assert found is not None
    np.testing.assert_array_equal(found.coordinates[1:], start[1:])
    assert not asked
    assert firm.place(2, start, leeway=30.0) is None
    assert loose.place(2, loose.model.parameters.start()) is None
    assert len(asked) == 2
