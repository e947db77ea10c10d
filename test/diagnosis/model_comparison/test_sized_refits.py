# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A refitted effect is believed to be of the size that is likeliest for it, and no other."""

from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit, weighed_anew
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched

NAME = 'depth_affine.bias'
BIAS = Candidate('depth_affine', ('bias',))
USUAL = BIAS.parts[0].usual_size


@pytest.fixture(scope='module')
def fitted():
    return fit_nominal(beam_scene((6, 2, 2)), [watched(seed=1, bias=0.6 * USUAL)], None)


def _refitted(fitted: tuple, start: float, evaluations: int = 4):
    (found,) = RefitPool(*fitted).refit_all([RefitRequest((BIAS,), {NAME: start}, evaluations)])
    return found


def _believed(fit: Refit) -> float:
    """Return the standard deviation of the bias beforehand, in usual sizes."""
    parameter = fit.parameters.parameters[fit.parameters.names.index(NAME)]
    assert parameter.quantity.prior_std is not None
    return parameter.quantity.prior_std / USUAL


def test_a_fit_that_begins_far_off_is_weighed_by_where_it_ends(fitted):
    far, near = (_refitted(fitted, start * USUAL, 8) for start in (9.0, 0.0))
    assert (far.added[0].size, _believed(far.fit)) == (1.0, 1.0)
    assert not far.fit.is_converged, 'what is known beforehand is another thing now'
    seen = whiten(far.fit.groups, Part.FIT)
    assert far.fit.chi_square == pytest.approx(seen.chi_square, rel=1e-12), 'it did not move'
    ended = RefitPool(*fitted).finish([far], [-np.inf])[0].fit
    assert ended.log_evidence == pytest.approx(near.fit.log_evidence, abs=0.05)


def test_a_large_effect_is_believed_to_be_large(fitted):
    """One evaluation leaves it where it began."""
    found = _refitted(fitted, 9.0 * USUAL, 1)
    assert (found.added[0].size, _believed(found.fit)) == (10.0, 10.0)
    assert found.fit.values_by_name()[NAME] == pytest.approx(9.0 * USUAL)
    assert found.fit.is_converged, 'as it was asked for'


def test_what_is_known_beforehand_alone_differs_where_a_fit_is_weighed_anew(fitted):
    """By the square of how many sizes it is, and the volume of the prior."""
    large = _refitted(fitted, 9.0 * USUAL, 1)
    (usual,) = RefitPool(*fitted).refit_all([RefitRequest((BIAS,), {}, 1)])
    anew = weighed_anew(large.fit, usual.evaluator)
    np.testing.assert_array_equal(anew.coordinates, large.fit.coordinates)
    assert anew.chi_square == pytest.approx(large.fit.chi_square, rel=1e-12)
    place = large.fit.parameters.names.index(NAME)
    information = np.linalg.inv(large.fit.covariance)
    more = information.copy()
    more[place, place] += (1.0 - 0.01) / USUAL**2
    square = 0.5 * 9.0**2 * (1.0 - 0.01)
    volumes = np.linalg.slogdet(more)[1] - np.linalg.slogdet(information)[1]
    expected = -square - 0.5 * volumes + np.log(10.0)
    assert anew.log_evidence - large.fit.log_evidence == pytest.approx(expected, rel=1e-6)
