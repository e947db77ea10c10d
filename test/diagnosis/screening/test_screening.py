# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scores by projection agree with explicit least squares."""

from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.projection import Projection
from diffcal_ros.diagnosis.screening.screening import largest_cosines
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from support.scenes import beam_scene


def test_projection_gives_the_chi_square_with_nuisances_fitted(random):
    nuisances, target = random.normal(size=(30, 4)), random.normal(size=30)
    precision = np.diag([0.0, 2.0, 0.5, 10.0]) + 1e-6 * np.eye(4)
    project = Projection(nuisances, precision)
    best = np.linalg.solve(nuisances.T @ nuisances + precision, nuisances.T @ target)
    left = target - nuisances @ best
    expected = left @ left + best @ precision @ best
    assert project(target) @ project(target) == pytest.approx(expected, rel=1e-9)


def test_a_score_is_the_fall_of_chi_square_with_one_more_effect(screened):
    """Solve nuisances and tilt together, priors included, and compare with the score's gain."""
    evaluator, fit, result = screened
    score = next(s for s in result.scores if s.candidate.identifier == 'gravity_tilt')
    from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
    from diffcal_ros.calibration.parameters.parameters import ParameterSet

    scene, nominal = evaluator.model.scene, evaluator.model.parameters
    more = make_parameters(scene, ('gravity_tilt',), with_edge_bias=False)
    both = ParameterSet((*nominal.parameters, *more.parameters))
    start = np.concatenate([fit.coordinates, np.zeros(2)])
    wide = evaluator.of(evaluator.model.with_parameters(scene, both))
    seen = whiten(wide.groups(start), Part.FIT)
    _, precision = regularised_prior(nominal)
    scale = EFFECTS['gravity_tilt'].component('a').scale
    prior = np.zeros((len(start), len(start)))
    prior[: len(nominal), : len(nominal)] = precision
    prior[len(nominal) :, len(nominal) :] = np.eye(2) / scale**2

    # Seen from the priors' means: the sensor's width of edges has one, the modulus has none.
    mean, known = nominal.prior()
    beyond = np.where(np.diag(known) > 0.0, fit.coordinates - mean, 0.0)
    assert beyond.any()
    values = seen.values + seen.jacobian[:, : len(nominal)] @ beyond

    def least(columns: list[int]) -> float:
        jacobian, own = seen.jacobian[:, columns], prior[np.ix_(columns, columns)]
        best = np.linalg.solve(jacobian.T @ jacobian + own, jacobian.T @ values)
        left = values - jacobian @ best
        return float(left @ left + best @ own @ best)

    few = list(range(len(nominal)))
    fall = least(few) - least([*few, len(nominal), len(nominal) + 1])
    assert score.plain_gain == pytest.approx(fall, rel=1e-4)


def test_every_effect_has_a_score_and_a_likeness(screened):
    _, _, result = screened
    # One region in the scene: a bias of the second half of it can still be asked for.
    searched = {n for n, e in EFFECTS.items() if e.variants and not e.needs_motion}
    assert {score.candidate.identifier for score in result.scores} == searched
    likeness = largest_cosines(result.scores)
    assert all(0.0 <= value <= 1.0 + 1e-9 for value in likeness.values())


def test_what_is_ruled_out_is_no_candidate():
    scene = beam_scene(fit=('youngs_modulus', 'rigid_offset'))
    names = {candidate.identifier for candidate in candidates(scene, ['added_mass'])}
    assert not names & {'camera_offset', 'added_mass'}
    again = {c.identifier for c in candidates(scene, fit=('youngs_modulus',))}
    assert 'camera_offset' in again


def test_a_plane_is_as_many_times_detectable_as_the_forces_that_stand_in(screened):
    """Of one amplitude the ratio is the root of its gain over that of the smallest one seen."""
    _, _, scores = screened
    by_name = {score.candidate.identifier: score for score in scores.scores}
    alone = by_name['compliant_clamp'], by_name['depth_bias_by_region']
    for score in alone:
        # The prior takes a little off the gain.
        assert score.times_detectable == pytest.approx(
            np.sqrt(score.gain) / 4.0, rel=0.1, abs=0.01
        )
    plane = next(
        score
        for score in scores.scores
        if score.candidate.identifier == 'contact_plane' and score.candidate.at is None
    )
    assert plane.gain > 0.0
    assert plane.times_detectable == pytest.approx(np.sqrt(plane.gain) / 4.0)
