# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What only stood in for an effect of a pair is held against what may be there in its place."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import swapped_pairs
from diffcal_ros.diagnosis.model_comparison.swapped_pairs import with_swapped
from support.judged_models import refitted_with


def test_the_effect_that_is_there_takes_the_place_of_its_stand_in(screened, pool):
    """A tilted body that was fitted with a bend at rest, beside a bias that is not there."""
    wrong = refitted_with(screened, 'rest_curvature', 'depth_affine')
    found = with_swapped(pool, [wrong], [], screened[2], None)
    assert found[0].identifiers == ('depth_affine', 'gravity_tilt')
    assert found[0].level > wrong.level + 5.0
    assert any(pair is wrong for pair in found)


def test_what_explains_far_less_is_not_tried(screened, pool, monkeypatch):
    right = refitted_with(screened, 'gravity_tilt', 'depth_affine')
    monkeypatch.setattr(swapped_pairs, '_AS_MUCH', 50.0)
    assert with_swapped(pool, [right], [], screened[2], None) == [right]


def test_what_explains_as_much_alone_is_tried_whatever_tangents_promise(
    screened, pool, monkeypatch
):
    right = refitted_with(screened, 'gravity_tilt', 'depth_affine')
    alone, other = (refitted_with(screened, name) for name in ('gravity_tilt', 'clamp_offset'))
    monkeypatch.setattr(swapped_pairs, '_AS_MUCH', 50.0)
    as_good = replace(other, fit=replace(other.fit, log_evidence=alone.level - 2.0))
    found = with_swapped(pool, [right], [alone, as_good], screened[2], None)
    assert {pair.identifiers for pair in found} == {
        ('depth_affine', 'gravity_tilt'),
        ('clamp_offset', 'depth_affine'),
    }
    # Of what is far behind alone nothing is expected.
    far = replace(other, fit=replace(other.fit, log_evidence=alone.level - 80.0))
    assert with_swapped(pool, [right], [alone, far], screened[2], None) == [right]
    # Nor is it asked of the one that was not the best alone.
    assert with_swapped(pool, [right], [as_good, alone], screened[2], None) == [right]


def test_no_pairs_have_none_beside_them(screened, pool):
    assert with_swapped(pool, [], [], screened[2], None) == []
