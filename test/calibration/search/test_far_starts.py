# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One answer from any start: modulus a factor 30 off, placement 25 mm and 8 degrees off."""

from dataclasses import replace
from itertools import pairwise

from diffcal_ros.calibration.calibrate import calibrate, Calibration
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import IterationRecord
from diffcal_ros.calibration.search.global_search import GlobalSearch
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest
from support.scenes import (
    beam_scene,
    DEPTH_FROM_WORLD,
    MODULUS,
    noisy,
    observation,
    true_depth,
)

_QUICK = CalibrationSettings(with_mesh_error=False)
_FIT = ('youngs_modulus', 'rigid_offset')


def _far(start: float):
    """A scene that starts far off, and data whose placement is off by more than its prior."""
    wrong = transform(
        rotation_matrix(np.array([0.06, -0.05, 0.08])), np.array([0.018, -0.012, 0.012])
    )
    seen = noisy(true_depth(), np.random.default_rng(7))
    return beam_scene(modulus=start, fit=_FIT), [observation(seen, pose=DEPTH_FROM_WORLD @ wrong)]


@pytest.mark.parametrize(
    'start', [3e3, *(pytest.param(far, marks=pytest.mark.slow) for far in (12e3, 400e3, 2e6))]
)
def test_far_starts_end_at_the_truth(start) -> None:
    result = calibrate(*_far(start), _QUICK)
    assert result.outcome is Outcome.CONVERGED
    assert result['youngs_modulus'].value == pytest.approx(MODULUS, rel=0.04)
    assert result.gap_end.explained > 0.97
    assert result.gap_end.median < 0.3e-3


@pytest.mark.slow
def test_an_offset_to_start_from_does_not_decide() -> None:
    scene, seen = _far(MODULUS)
    values = []
    for shift in ((0.0, 0.0, 0.0), (0.02, -0.015, 0.01), (-0.02, 0.02, 0.02)):
        calibration = Calibration(scene, seen, _QUICK)
        places = [calibration.parameters.names.index(f'rigid_offset.{axis}') for axis in 'xyz']
        calibration.coordinates[places] = shift
        values.append(calibration.run()['youngs_modulus'].value)
    assert np.ptp(values) < 0.01 * MODULUS


@pytest.fixture(scope='module')
def told():
    """What a fit from far tells on its way."""
    records: list[IterationRecord] = []
    scene, seen = _far(300e3)
    calibrate(scene, seen, _QUICK, on_iteration=lambda record: not records.append(record))
    return records


def test_what_is_told_falls(told) -> None:
    losses = [record.loss for record in told]
    # Rough by a few per cent, as pixels join and leave, and never by more.
    assert all(after < 1.06 * before for before, after in pairwise(losses))
    assert losses[-1] < 0.1 * losses[0]


def test_the_start_is_told_first(told) -> None:
    assert told[0].values['youngs_modulus'] == pytest.approx(300e3)
    assert [record.number for record in told] == list(range(len(told)))


def test_without_the_search_a_far_start_is_not_called_converged() -> None:
    result = calibrate(*_far(3e3), replace(_QUICK, search=False))
    modulus = result['youngs_modulus'].value
    is_right = abs(modulus - MODULUS) < 0.05 * MODULUS
    assert is_right or result.outcome is not Outcome.CONVERGED


@pytest.mark.slow
def test_shapes_of_linear_elements_stand_for_the_bodys_own() -> None:
    scene, seen = _far(MODULUS)
    calibration = Calibration(scene, seen, _QUICK)
    search = GlobalSearch(calibration.model, calibration.coordinates)
    best = search.basins()[0].coordinates
    place = calibration.parameters.names.index('youngs_modulus')
    # Neighbouring shapes are a factor 1.6 apart.
    assert abs(best[place] - np.log(MODULUS)) < 0.5
