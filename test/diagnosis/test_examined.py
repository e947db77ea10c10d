# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's smooth error is hidden by a large gap, and seen beside what explains that."""

from dataclasses import replace

from diffcal_ros.diagnosis.examined import examined, examined_anew
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patches.noise_model import noise_of
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from support.clamped_anew import rolled
from support.judged_models import refitted_with
from support.scenes import WORLD_FROM_OBJECT

_ROLLS = (0.0, 0.8, -1.3)
# The same in each pose, in the frame of the body [m], [rad].
_SHIFT, _TURN = (0.001, 0.005, -0.004), (0.05, 0.06, -0.1)
_SETTINGS = DiagnosisSettings()


@pytest.fixture(scope='module')
def recorded():
    """A scene, and what was seen of a beam that sits elsewhere in its clamp."""
    sits = []
    for roll in _ROLLS:
        turn = WORLD_FROM_OBJECT[:3, :3] @ rotation_matrix(np.array([roll, 0.0, 0.0]))
        sits.append([*(turn @ _SHIFT), *(turn @ _TURN)])
    return rolled(_ROLLS, sits, (6, 2, 2))


def _read_by(seen, size):
    """Return what a sensor reads whose smooth error is of a size [m], half of it in each pose."""
    random = np.random.default_rng(8)

    def drawn():
        smooth = gaussian_filter(random.normal(size=seen[0].depth.shape), 20.0)
        return smooth / smooth.std()

    standing = drawn()
    errors = [size * np.sqrt(0.5) * (standing + drawn()) for _ in seen]
    return [
        replace(own, depth=(own.depth + error).astype(np.float32))
        for own, error in zip(seen, errors, strict=True)
    ]


def _examined(recorded, size):
    scene, seen = recorded
    return examined(*fit_nominal(scene, _read_by(seen, size), None), _SETTINGS, lambda _: None)


def _beside(judged, identifier):
    return refitted_with((judged.evaluator, judged.nominal, judged.scores), identifier)


@pytest.fixture(scope='module')
def poor(recorded):
    """The nominal fit to what a sensor reads whose smooth error is 1.3 mm."""
    return _examined(recorded, 0.0013)


@pytest.mark.slow
def test_beside_what_explains_a_large_gap_the_error_is_seen(poor):
    assert poor.evaluator.smooth_error < 0.00035, 'no more is believed than of any sensor'
    told = []
    model = _beside(poor, 'clamp_offset')
    again = examined_anew(poor, [model], _SETTINGS, told.append)
    assert again is not None
    assert again.evaluator.smooth_error == pytest.approx(0.0013, rel=0.4)
    assert 'smooth error of' in told[0]
    # Nothing else is new: what may be found once more is found from the same beginning.
    assert again.expected is poor.expected
    assert again.evaluator.left_out == poor.evaluator.left_out
    assert again.disagreement.gap.floor > 2.0 * poor.disagreement.gap.floor
    # By as much there is nothing more to be found.
    assert examined_anew(again, [model], _SETTINGS, told.append) is None


@pytest.mark.slow
def test_what_leaves_the_gap_hides_the_error(poor):
    wrong = _beside(poor, 'added_mass')
    assert examined_anew(poor, [wrong], _SETTINGS, lambda _: None) is None
    assert examined_anew(poor, [], _SETTINGS, lambda _: None) is None


@pytest.mark.slow
def test_a_sensor_as_good_as_is_believed_is_no_reason_to_begin_again(recorded):
    good = _examined(recorded, 0.0002)
    model = _beside(good, 'clamp_offset')
    assert examined_anew(good, [model], _SETTINGS, lambda _: None) is None


@pytest.mark.slow
def test_a_stated_error_is_believed_beside_a_model_too(recorded):
    scene, seen = recorded
    stated = replace(scene, sensor=replace(scene.sensor, smooth_error=0.0005))
    fitted = fit_nominal(stated, _read_by(seen, 0.0009), None)
    judged = examined(*fitted, _SETTINGS, lambda _: None)
    assert noise_of(seen[0], stated.sensor).is_stated
    model = _beside(judged, 'clamp_offset')
    assert examined_anew(judged, [model], _SETTINGS, lambda _: None) is None
