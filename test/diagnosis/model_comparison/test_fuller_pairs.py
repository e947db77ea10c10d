# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The best pair is fitted with all amplitudes that its effects may have."""

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.fuller_pairs import with_all_amplitudes

_PLACE = ('x', 'y', 'z')
_TURN = ('rx', 'ry', 'rz')


def _pair(screened, *chosen):
    """Return a fitted pair of candidates with such identifiers and amplitudes."""
    evaluator, nominal, scores = screened
    listed = [score.candidate for score in scores.scores]
    added = [next(c for c in listed if (c.identifier, c.components) == own) for own in chosen]
    return try_effects(evaluator, nominal, added, {})


def test_what_a_second_effect_may_be_besides_is_fitted_from_where_the_pair_is(screened, pool):
    pair = _pair(screened, ('depth_affine', ('bias',)), ('camera_offset', _PLACE))
    found = with_all_amplitudes(pool, [pair], [], screened[2], None)
    fuller = next(model for model in found if model is not pair)
    assert any(model is pair for model in found)
    assert {own.identifier: own.components for own in fuller.added} == {
        'depth_affine': ('scale', 'bias'),
        'camera_offset': (*_PLACE, *_TURN),
    }
    # A body that sags to one side is turned about the camera's axis, too.
    assert fuller.fit.chi_square < 0.9 * pair.fit.chi_square


def test_a_pair_that_has_all_of_them_is_left_as_it_is(screened, pool):
    whole = ('camera_offset', (*_PLACE, *_TURN))
    pair = _pair(screened, ('gravity_tilt', ('a', 'b')), whole)
    assert with_all_amplitudes(pool, [pair], [], screened[2], None) == [pair]
    assert with_all_amplitudes(pool, [], [], screened[2], None) == []
