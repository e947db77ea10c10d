# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A field tells two halves apart, says how sure it is, and refuses what it cannot do."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import check_field, fit_field
from diffcal_ros.calibration.field.layout import FieldKind
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
import numpy as np
import pytest
from support.fields import (
    area_under_curve,
    FIT,
    fitted_halves,
    log_truth,
    QUICK,
    STIFF,
    two_halves_depth,
)
from support.scenes import beam_scene, observation, true_depth


@pytest.mark.parametrize('spacing', [None, 0.015], ids=['tets', 'grid'])
@pytest.mark.slow
def test_two_halves_are_told_apart(spacing) -> None:
    calibration, field = fitted_halves(spacing)
    truth = log_truth(calibration)
    is_stiff = truth == np.log(STIFF)
    assert area_under_curve(field.youngs_modulus, is_stiff) >= 0.95
    # Smoothness draws the contrast too small, but not away.
    found = np.log(field.youngs_modulus)
    contrast = found[is_stiff].mean() - found[~is_stiff].mean()
    assert 0.4 * np.log(3.0) < contrast < 1.1 * np.log(3.0)


@pytest.mark.slow
def test_the_gap_falls_to_the_noise() -> None:
    _, field = fitted_halves()
    assert field.weights.reason.startswith('the residuals reach')
    assert field.result.gap_end.rms < 0.5 * field.uniform.gap_end.rms
    assert field.result.outcome is Outcome.CONVERGED
    numbers = [record.number for record in field.result.history]
    assert numbers == sorted(numbers)
    assert len(numbers) > len(field.uniform.history)


def test_region_modulus_is_the_mean_of_the_field() -> None:
    calibration, field = fitted_halves()
    volumes = calibration.scene.mesh.volumes
    mean = np.exp(np.average(np.log(field.youngs_modulus), weights=volumes))
    # A mean in the field weighs a thousandfold: it is small, not zero.
    assert mean == pytest.approx(field.result['youngs_modulus'].value, rel=2e-3)


def test_errors_are_of_the_size_of_what_is_wrong() -> None:
    calibration, field = fitted_halves()
    assert (field.log_std > 0.0).all()
    # Not at the sharp border, which a smooth field never has.
    along = calibration.scene.mesh.centroids[:, 0]
    away = np.abs(along - 0.06) > 0.02
    off = np.abs(np.log(field.youngs_modulus) - log_truth(calibration))[away]
    assert 0.2 < np.sqrt(np.mean((off / field.log_std[away]) ** 2)) < 4.0
    # The clamped end bends most and the free end hardly: it is known less well.
    assert field.log_std[along > 0.10].mean() > field.log_std[along < 0.04].mean()


def test_a_given_weight_is_taken() -> None:
    calibration, field = fitted_halves()
    again = Calibration(calibration.scene, calibration.model.observations, QUICK)
    told = []

    def tell(record) -> bool:
        told.append(record)
        return True

    rough = fit_field(again, again.run(), fraction=1e-3, on_iteration=tell)
    assert rough.weights.reason == 'given'
    assert rough.as_dict()['weight'] == 1e-3
    assert len(told) == 1
    assert rough.weights.trials[0].roughness > 2.0 * field.weights.trials[0].roughness


def test_telling_it_to_stop_stops_it() -> None:
    scene = beam_scene((4, 2, 2), modulus=80e3, fit=FIT)
    calibration = Calibration(scene, [observation(two_halves_depth())], QUICK)
    field = fit_field(calibration, calibration.run(), on_iteration=lambda _: False)
    assert len(field.weights.trials) == 1
    assert field.weights.is_stopped
    assert field.result.outcome is Outcome.INTERRUPTED


@pytest.mark.parametrize(
    ('kind', 'share', 'words'),
    [
        (FieldKind(0.5), None, 'control grid has a spacing of 0.5 m'),
        (FieldKind(), 0.0, 'weight of the roughness is 0'),
        (FieldKind(), 2.0, 'weight of the roughness is 2'),
    ],
)
def test_what_makes_no_field_is_refused(kind, share, words) -> None:
    with pytest.raises(InputError, match=words):
        check_field(beam_scene((4, 2, 2)), kind, share)


def test_a_whole_image_loss_is_refused() -> None:
    settings = CalibrationSettings(loss='l1', with_mesh_error=False, max_iterations=1)
    calibration = Calibration(beam_scene((4, 2, 2)), [observation(true_depth())], settings)
    with pytest.raises(InputError, match='needs the robust loss'):
        fit_field(calibration, calibration.run())


def test_too_few_pixels_are_refused() -> None:
    depth = true_depth()
    _, columns = np.nonzero(np.isfinite(depth))
    scene = beam_scene((4, 2, 2))
    middle = int(np.median(columns))
    boxes = ((0, 0, middle - 5, depth.shape[0]), (middle + 5, 0, depth.shape[1], depth.shape[0]))
    masked = replace(scene, masks=replace(scene.masks, boxes=boxes))
    calibration = Calibration(masked, [observation(depth)], QUICK)
    with pytest.raises(InputError, match='pixels on the body: it takes at least 1000'):
        fit_field(calibration, calibration.run())


def test_a_fit_that_leads_nowhere_is_no_start() -> None:
    calibration, field = fitted_halves()
    lost = replace(field.uniform, outcome=Outcome.DIVERGED)
    with pytest.raises(InputError, match='starts from a fit without one'):
        fit_field(calibration, lost)
