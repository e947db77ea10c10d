# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two different bodies of one material, fitted together."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.joint import JointCalibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth

SHARED = {'youngs_modulus': {'thin': 'youngs_modulus', 'heavy': 'youngs_modulus'}}
HEAVY = np.array([0.0, -14.0, 2.0])
FIT = ('youngs_modulus', 'rigid_offset')
# The truth is on another mesh: found moduli differ by its discretisation error, 2 % here.
_MODULUS_SHARE = 0.04


def _members(random, **settings) -> dict[str, Calibration]:
    asked = CalibrationSettings(with_mesh_error=False, fit=FIT, **settings)
    thin = beam_scene((8, 2, 2), modulus=1.4 * MODULUS)
    heavy = beam_scene((6, 2, 2), modulus=0.7 * MODULUS, gravity=HEAVY)
    depths = [true_depth(), true_depth(gravity=HEAVY)]
    return {
        name: Calibration(scene, [observation(noisy(depth, random))], asked)
        for name, scene, depth in zip(('thin', 'heavy'), (thin, heavy), depths, strict=True)
    }


@pytest.mark.slow
def test_one_modulus_explains_both_and_is_known_better_than_from_the_worse(random) -> None:
    separate = {name: member.run() for name, member in _members(random, search=False).items()}
    joint = JointCalibration(_members(random, search=False), SHARED)
    result = joint.run()
    modulus = result['youngs_modulus']
    assert modulus.value == pytest.approx(MODULUS, rel=_MODULUS_SHARE)
    assert set(result.details['members']) == {'thin', 'heavy'}
    for name, own in separate.items():
        gap = result.details['members'][name]
        assert gap['median_mm'] <= 1e3 * own.gap_end.median + 0.05
        assert result[f'rigid_offset.x ({name})'].std_error > 0.0
    # Not than from the better one: both meshes are coarse in their own way, which is noise here.
    assert modulus.std_error < max(own['youngs_modulus'].std_error for own in separate.values())


def test_cost_and_slope_are_the_sums_of_the_members(random) -> None:
    members = _members(random)
    joint = JointCalibration(members, SHARED)
    at = joint.coordinates.copy()
    own = [at[places] for places in joint.parameters.indices]
    costs = [m.objective.cost(c) for m, c in zip(members.values(), own, strict=True)]
    assert joint.objective.cost(at) == pytest.approx(sum(costs))
    descents = [
        m.objective.linearise(c).negative_gradient
        for m, c in zip(members.values(), own, strict=True)
    ]
    linear = joint.objective.linearise(at)
    assert linear.negative_gradient[0] == pytest.approx(sum(d[0] for d in descents))
    place = joint.parameters.names.index('rigid_offset.y (heavy)')
    assert linear.negative_gradient[place] == pytest.approx(descents[1][2])
    other = joint.parameters.names.index('rigid_offset.y (thin)')
    assert linear.curvature[place, other] == 0.0


def test_priors_of_the_members_stay_their_own(random) -> None:
    joint = JointCalibration(_members(random), SHARED)
    mean, precision = joint.parameters.prior()
    place = joint.parameters.names.index('rigid_offset.x (heavy)')
    assert precision[place, place] == pytest.approx(1.0 / 0.020**2)
    assert mean[place] == 0.0
    assert not precision[0].any()


def test_what_cannot_be_shared_is_refused(random) -> None:
    members = _members(random)
    with pytest.raises(InputError, match="heavy fits no 'density' to be shared: members fit"):
        JointCalibration(members, {'density': {'thin': 'youngs_modulus', 'heavy': 'density'}})
    scene = members['thin'].scene
    known = Quantity(MODULUS, 1e3, 1e7, MODULUS, 0.1 * MODULUS)
    scene = replace(scene, regions=(replace(scene.regions[0], youngs_modulus=known),))
    with_prior = Calibration(scene, members['thin'].model.observations, members['thin'].settings)
    with pytest.raises(InputError, match='thin has a prior on youngs_modulus, which is shared'):
        JointCalibration({**members, 'thin': with_prior}, SHARED)
    image = _members(random, loss='paper')
    with pytest.raises(InputError, match="fit of thin needs the robust loss, not 'paper'"):
        JointCalibration(image, SHARED)
