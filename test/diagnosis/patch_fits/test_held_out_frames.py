# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What scatters from frame to frame is told by half of a held-out frame's patches, or is not."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.form_parameters import knot_parameter
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.patch_fits.held_out_frames import told_frame_by_frame
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.time_knot import TimeKnot
import numpy as np
import pytest
from support.filmed import filmed_scene

COUNT, NOISE, LATE = 40, 1e-4, 0.007
# A fitted frame and two held out: the first and the last are late on their own.
TIMES, HELD_OUT = (0.1, 0.2, 0.3), (False, True, True)
SLOPES = np.random.default_rng(3).normal(size=(3, COUNT)) * 0.3


def _group(view: int, values: np.ndarray, width: int) -> PatchGroup:
    jacobian = np.zeros((COUNT, width))
    jacobian[:, -3 + view] = SLOPES[view]
    rows, columns = np.divmod(np.arange(COUNT), 8)
    patches = Patches(
        values=values,
        jacobian=jacobian,
        covariance=NOISE**2 * np.eye(COUNT),
        centers=np.zeros((COUNT, 2)),
        cells=100_000 * rows + columns,
        weights=np.ones(COUNT),
        common=CommonError(np.zeros(COUNT), 1.0),
    )
    is_report = np.full(COUNT, HELD_OUT[view])
    return PatchGroup(view, 'depth', 0, patches, np.zeros(COUNT), is_report)


def _fit(left: np.ndarray, size: float = 1.0) -> SimpleNamespace:
    """Make a fit of stamps that may be others in each frame, and what it leaves, (3, n)."""
    parameters = make_parameters(filmed_scene(is_small=True), ('time_offset.late',))
    late = next(own for own in parameters if own.effect)
    more = tuple(knot_parameter(late, TimeKnot(time, 0.01), size) for time in TIMES)
    whole = ParameterSet((*parameters.parameters, *more))
    groups = [_group(view, left[view], len(whole)) for view in range(3)]
    return SimpleNamespace(parameters=whole, coordinates=whole.start(), groups=groups)


def _noise(random) -> np.ndarray:
    return NOISE * random.normal(size=(3, COUNT))


def test_the_other_half_of_a_late_frame_is_explained(random) -> None:
    noise = _noise(random)
    fit = _fit(noise + LATE * SLOPES)
    told = told_frame_by_frame(fit.groups, fit)
    # The fitted frame is as it was, with all its patches.
    np.testing.assert_array_equal(told[0].patches.values, fit.groups[0].patches.values)
    for view in (1, 2):
        rows, columns = np.divmod(fit.groups[view].patches.cells, 100_000)
        kept = (rows + columns) % 2 == 1
        np.testing.assert_array_equal(
            told[view].patches.cells, fit.groups[view].patches.cells[kept]
        )
        assert told[view].is_report.all()
        off = told[view].patches.values - noise[view, kept]
        assert np.abs(off).max() < 3.0 * NOISE * np.abs(SLOPES[view]).max() / 0.3 / 4.0
    assert patch_gap(fit.groups, Part.REPORT).rms > 10.0 * NOISE
    assert patch_gap(told, Part.REPORT).rms < 1.5 * NOISE


def test_what_is_no_lateness_is_not_explained(random) -> None:
    other = 1e-3 * random.permuted(SLOPES / 0.3, axis=1)
    fit = _fit(_noise(random) + other)
    before, after = (
        patch_gap(groups, Part.REPORT).rms
        for groups in (fit.groups, told_frame_by_frame(fit.groups, fit))
    )
    assert after > 0.7 * before


def test_by_a_prior_that_allows_nothing_nothing_is_found(random) -> None:
    fit = _fit(_noise(random) + LATE * SLOPES, size=1e-6)
    told = told_frame_by_frame(fit.groups, fit)
    assert patch_gap(told, Part.REPORT).rms == pytest.approx(
        patch_gap(fit.groups, Part.REPORT).rms, rel=0.4
    )


def test_without_anything_of_single_frames_all_patches_stay(random) -> None:
    fit = _fit(_noise(random))
    always = tuple(replace(own, knot=None) for own in fit.parameters)
    fit.parameters = ParameterSet(always)
    assert told_frame_by_frame(fit.groups, fit) == fit.groups
