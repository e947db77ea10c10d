# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Upper limits: the same as from one explicit least-squares fit."""

from dataclasses import replace

from diffcal_ros.diagnosis.detection.limits import upper_limits
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest


def _tilt(screen):
    return next(s for s in screen.scores if s.candidate.identifier == 'gravity_tilt')


def test_a_limit_is_the_estimate_and_two_standard_errors(screened):
    screen = screened[2]
    score = _tilt(screen)
    normal = score.plain_columns.T @ score.plain_columns
    estimate = np.linalg.solve(normal, score.plain_columns.T @ score.plain_residual)
    spread = np.sqrt(screen.noise_scale * np.diag(np.linalg.inv(normal)))
    factor = EFFECTS['gravity_tilt'].component('a').shown_factor
    limits = upper_limits(screen)['gravity_tilt']
    expected = factor * (np.abs(estimate) + 1.96 * spread)
    assert [limits['a'], limits['b']] == pytest.approx(expected.tolist(), rel=1e-6)


def test_what_is_there_is_not_below_its_limit(screened):
    limits = upper_limits(screened[2])['gravity_tilt']
    assert max(limits['a'], limits['b']) > np.rad2deg(0.06)


def test_what_cannot_be_seen_has_no_limit(screened):
    screen = screened[2]
    score = _tilt(screen)
    blind = score.plain_columns.copy()
    blind[:, 1] = blind[:, 0]
    limits = upper_limits(replace(screen, scores=(replace(score, plain_columns=blind),)))
    assert limits['gravity_tilt'] == {'a': np.inf, 'b': np.inf}


def test_effects_beyond_tangents_have_none(screened):
    assert not {'contact_plane', 'strain_stiffening'} & set(upper_limits(screened[2]))
