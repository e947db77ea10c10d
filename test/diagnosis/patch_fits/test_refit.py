# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits of patches are held against one another by densities of the same patches."""

from dataclasses import replace

from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.judged_models import refitted_with

_BIAS = 0.012


def _fitted() -> tuple[Refit, Refit]:
    """Fit a beam that a camera reads too far, without its bias and with it."""
    scene, seen = beam_in_two_poses(6)
    scene = replace(scene, sensor=replace(scene.sensor, smooth_error=0.0012))
    read = [replace(own, depth=(own.depth + _BIAS).astype(np.float32)) for own in seen]
    evaluator, nominal = fit_nominal(scene, read, None)
    listed = [own for own in candidates(scene) if own.identifier == 'depth_affine']
    scores = screen(evaluator, nominal.coordinates, listed)
    return nominal, refitted_with((evaluator, nominal, scores), 'depth_affine').fit


@pytest.mark.slow
def test_what_is_far_off_as_a_whole_is_not_the_likelier_model():
    """Patches that are all far off count less: what they have in common is told by more noise."""
    without, beside = _fitted()
    left = [patch_gap(fit.groups, Part.FIT).rms for fit in (without, beside)]
    assert left[1] < 0.2 * left[0]
    # By its squares alone it would be the likelier one all the same.
    seen = [whiten(fit.groups, Part.FIT) for fit in (without, beside)]
    assert seen[0].chi_square + seen[0].volume < seen[1].chi_square + seen[1].volume
    assert beside.log_evidence > without.log_evidence + 50.0
