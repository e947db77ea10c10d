# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much of another form there is, in words."""

from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.site import SeenPixels
import numpy as np
import pytest


@pytest.mark.parametrize(
    ('effect', 'name', 'amount', 'words'),
    [
        ('depth_affine', 'yyy', -0.95, '-26 mm by yyy at the edge of the picture'),
        ('depth_affine', 'aslant_2', 0.01, '2.5 mm where a surface is met at 60 degrees'),
        ('depth_affine', 'spot_8', 0.003, '3 mm around x / z = -0.45, y / z = -0.15'),
        ('depth_bias_by_region', 'all_7', 0.002, '2 mm at 50% of its length'),
        ('depth_bias_by_region', 'a_1', 0.002, '2 mm at 0% of its length, rising by a'),
        (
            'depth_bias_by_region',
            'facing_b_13',
            -0.004,
            '-4 mm at 100% of its length, where it faces b',
        ),
        ('added_mass', 'mass_2', 0.005, '5 g at 25% of its length'),
        ('stiffness_contrast', 'part_3', 0.7, '0.7 log E at 25% of its length'),
        ('contact_plane', 'rise_3', 0.002, '2 mm at 50% of its length'),
        ('rest_curvature', 'twist', 2.0, '2 1/m of twist'),
        ('rest_curvature', 'b_2', -3.0, '-3 1/m about b, at 25% of its length'),
        ('camera_offset', 'focal', 0.01, 'focal 0.01 1'),
    ],
)
def test_an_amount_says_what_it_does_and_where(effect, name, amount, words):
    assert EFFECTS[effect].component(name).shown(amount) == words


def test_a_power_is_shown_by_what_it_does_at_the_edge(random):
    effect = EFFECTS['depth_affine']
    edge = SeenPixels(
        np.ones(1), np.zeros(1, dtype=bool), np.full((1, 2), 0.3), np.cos(np.deg2rad([60.0]))
    )
    powers = [part for part in effect.forms if not part.name.startswith('spot')]
    for part, amount in zip(powers, random.uniform(0.1, 2.0, len(powers)), strict=True):
        read = amount * effect.depth_error_mode(part.name, edge)[0]
        assert part.shown_factor * amount == pytest.approx(1e3 * read)
