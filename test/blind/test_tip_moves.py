# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that move the body do so by about what their sizes say.

Contacts and laws are told by tests of their own: they ask for a softer body.
"""

import numpy as np
import pytest
from support.blind_rests import tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import Specimen

# By the set that has them first: how far the second and third size may move a tip [mm].
ON_THE_BODY = {
    'tenth': (
        (
            'clamp_offset/dragged',
            'compliant_clamp/play',
            'rest_curvature/trestles',
            'stiffness_contrast/lamp',
            'gravity_tilt/turntable',
        ),
        ((3.0, 8.0), (6.0, 15.0)),
    ),
    'eleventh': (
        (
            'added_mass/loose',
            'rest_curvature/coiled',
            'stiffness_contrast/slanted',
            'gravity_tilt/castors',
        ),
        ((2.5, 9.0), (5.0, 15.0)),
    ),
    'twelfth': (
        (
            'stiffness_contrast/patched',
            'added_mass/drying',
            'clamp_offset/putty',
            'compliant_clamp/preloaded',
        ),
        ((2.5, 9.0), (5.0, 15.0)),
    ),
    'thirteenth': (
        (
            'rest_curvature/recovering',
            'added_mass/pooled',
            'stiffness_contrast/streaky',
            'compliant_clamp/rubbing',
        ),
        ((3.0, 8.0), (7.0, 16.0)),
    ),
    'fourteenth': (
        ('rest_curvature/draped', 'clamp_offset/pinched', 'compliant_clamp/creeping'),
        ((3.0, 8.0), (7.0, 16.0)),
    ),
    'fifteenth': (
        (
            'stiffness_contrast/plugged',
            'added_mass/drained',
            'compliant_clamp/post',
            'clamp_offset/loosening',
            'gravity_tilt/draught',
            'rest_curvature/buckled',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'sixteenth': (
        (
            'stiffness_contrast/pours',
            'compliant_clamp/angle iron',
            'clamp_offset/shaken',
            'gravity_tilt/layer',
            'rest_curvature/folded',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'seventeenth': (
        (
            'added_mass/markers',
            'stiffness_contrast/foil',
            'compliant_clamp/wrist',
            'clamp_offset/bowed',
            'gravity_tilt/extractor',
            'rest_curvature/weighed down',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'eighteenth': (
        (
            'added_mass/tool',
            'stiffness_contrast/settled',
            'gravity_tilt/fan',
            'rest_curvature/overhanging',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'nineteenth': (
        (
            'added_mass/slung',
            'stiffness_contrast/marbled',
            'clamp_offset/rattling',
            'rest_curvature/wavy',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentieth': (
        (
            'added_mass/sponge',
            'stiffness_contrast/overbent',
            'compliant_clamp/taped',
            'clamp_offset/greased',
            'gravity_tilt/floating',
            'rest_curvature/crammed',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentyfirst': (
        (
            'added_mass/oozing',
            'stiffness_contrast/soaked',
            'compliant_clamp/hot glue',
            'clamp_offset/leashed',
            'gravity_tilt/braking',
            'rest_curvature/jumbled',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentysecond': (
        (
            'added_mass/wicking',
            'stiffness_contrast/creased',
            'compliant_clamp/waxed',
            'clamp_offset/runout',
            'gravity_tilt/rocking',
            'rest_curvature/propped',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentythird': (
        (
            'added_mass/hung on',
            'stiffness_contrast/edged',
            'compliant_clamp/gantry',
            'gravity_tilt/deflating',
            'rest_curvature/outweighed',
        ),
        ((2.5, 6.0), (5.5, 16.0)),
    ),
    'twentyfourth': (
        (
            'added_mass/spattered',
            'stiffness_contrast/wedged',
            'compliant_clamp/stand',
            'clamp_offset/clicking',
            'gravity_tilt/opposed',
            'rest_curvature/held by its tip',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentyfifth': (
        (
            'added_mass/cradled',
            'stiffness_contrast/ribbon',
            'compliant_clamp/suction',
            'clamp_offset/misgraded',
            'gravity_tilt/curtain',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentysixth': (
        (
            'added_mass/filling',
            'stiffness_contrast/gated',
            'compliant_clamp/bobbins',
            'clamp_offset/homed',
            'gravity_tilt/hair dryer',
            'rest_curvature/burdened',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentyseventh': (
        (
            'added_mass/sliding',
            'stiffness_contrast/dosed',
            'clamp_offset/backlash',
            'gravity_tilt/louvred',
            'rest_curvature/hammock',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentyeighth': (
        (
            'added_mass/slinky',
            'stiffness_contrast/baked',
            'compliant_clamp/gooseneck',
            'clamp_offset/eccentric',
            'gravity_tilt/lee',
            'rest_curvature/mattress',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'twentyninth': (
        (
            'added_mass/solder',
            'stiffness_contrast/surged',
            'compliant_clamp/coil spring',
            'clamp_offset/universal joint',
            'gravity_tilt/screened',
            'rest_curvature/four-point',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'thirtieth': (
        (
            'added_mass/spray can',
            'stiffness_contrast/seeped',
            'compliant_clamp/hairpin',
            'clamp_offset/tangent arm',
            'gravity_tilt/hub',
            'rest_curvature/slots',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'thirtyfirst': (
        (
            'added_mass/vine',
            'stiffness_contrast/motor heat',
            'compliant_clamp/twisted strap',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'thirtysecond': (
        (
            'added_mass/hourglass',
            'stiffness_contrast/rolled sheets',
            'compliant_clamp/hexapod',
            'clamp_offset/chuck key',
            'rest_curvature/woven',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
    'thirtythird': (
        (
            'added_mass/harness',
            'stiffness_contrast/heat gun',
            'clamp_offset/belt',
            'gravity_tilt/downwash',
            'rest_curvature/wrapped',
        ),
        ((2.5, 6.0), (7.0, 16.0)),
    ),
}
# What tests of their own check of these forms as well.
_SLOW = (
    *('twentyseventh', 'twentyeighth', 'twentyninth', 'thirtieth', 'thirtyfirst'),
    *('thirtysecond', 'thirtythird'),
)
CASES = [
    pytest.param(key, limits, id=key, marks=(pytest.mark.slow,) if name in _SLOW else ())
    for name, (keys, limits) in ON_THE_BODY.items()
    for key in keys
]


@pytest.mark.parametrize(('key', 'limits'), CASES)
def test_the_second_and_third_size_move_a_tip_by_some_4_or_5_and_10_mm(
    setup: Setup, plain: Specimen, key: str, limits: tuple[tuple[float, float], ...]
) -> None:
    at_tip = plain.shares > 0.99
    for size, (least, most) in enumerate(limits, start=1):
        faults = Faults(**BY_KEY[key].draw(size, setup, np.random.default_rng(8)))
        assert least < 1e3 * max(tip_moves(setup, plain, faults, at_tip)) < most
