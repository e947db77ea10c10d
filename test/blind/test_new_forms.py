# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the later sets are of some size, and not the library's; so are causes outside it."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.blind_rests import rest_of

from benchmarks.blind.amplitudes import LIBRARY
from benchmarks.blind.eighteenth_forms import EIGHTEENTH_FORMS
from benchmarks.blind.eighteenth_outside import EIGHTEENTH_OUTSIDE
from benchmarks.blind.eighth_forms import EIGHTH_FORMS
from benchmarks.blind.eighth_outside import EIGHTH_OUTSIDE
from benchmarks.blind.eleventh_forms import ELEVENTH_FORMS
from benchmarks.blind.eleventh_outside import ELEVENTH_OUTSIDE
from benchmarks.blind.faults import Faults
from benchmarks.blind.fifteenth_forms import FIFTEENTH_FORMS
from benchmarks.blind.fifteenth_outside import FIFTEENTH_OUTSIDE
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.fourteenth_forms import FOURTEENTH_FORMS
from benchmarks.blind.fourteenth_outside import FOURTEENTH_OUTSIDE
from benchmarks.blind.nineteenth_forms import NINETEENTH_FORMS
from benchmarks.blind.nineteenth_outside import NINETEENTH_OUTSIDE
from benchmarks.blind.ninth_forms import NINTH_FORMS
from benchmarks.blind.ninth_outside import NINTH_OUTSIDE
from benchmarks.blind.setups import Setup
from benchmarks.blind.seventeenth_forms import SEVENTEENTH_FORMS
from benchmarks.blind.seventeenth_outside import SEVENTEENTH_OUTSIDE
from benchmarks.blind.seventh_forms import SEVENTH_FORMS
from benchmarks.blind.seventh_outside import SEVENTH_OUTSIDE
from benchmarks.blind.sixteenth_forms import SIXTEENTH_FORMS
from benchmarks.blind.sixteenth_outside import SIXTEENTH_OUTSIDE
from benchmarks.blind.tenth_forms import TENTH_FORMS
from benchmarks.blind.tenth_outside import TENTH_OUTSIDE
from benchmarks.blind.thirteenth_forms import THIRTEENTH_FORMS
from benchmarks.blind.thirteenth_outside import THIRTEENTH_OUTSIDE
from benchmarks.blind.thirtieth_forms import THIRTIETH_FORMS
from benchmarks.blind.thirtieth_outside import THIRTIETH_OUTSIDE
from benchmarks.blind.thirtyfirst_forms import THIRTYFIRST_FORMS
from benchmarks.blind.thirtyfirst_outside import THIRTYFIRST_OUTSIDE
from benchmarks.blind.thirtysecond_forms import THIRTYSECOND_FORMS
from benchmarks.blind.thirtysecond_outside import THIRTYSECOND_OUTSIDE
from benchmarks.blind.thirtythird_forms import THIRTYTHIRD_FORMS
from benchmarks.blind.thirtythird_outside import THIRTYTHIRD_OUTSIDE
from benchmarks.blind.twelfth_forms import TWELFTH_FORMS
from benchmarks.blind.twelfth_outside import TWELFTH_OUTSIDE
from benchmarks.blind.twentieth_forms import TWENTIETH_FORMS
from benchmarks.blind.twentieth_outside import TWENTIETH_OUTSIDE
from benchmarks.blind.twentyeighth_forms import TWENTYEIGHTH_FORMS
from benchmarks.blind.twentyeighth_outside import TWENTYEIGHTH_OUTSIDE
from benchmarks.blind.twentyfifth_forms import TWENTYFIFTH_FORMS
from benchmarks.blind.twentyfifth_outside import TWENTYFIFTH_OUTSIDE
from benchmarks.blind.twentyfirst_forms import TWENTYFIRST_FORMS
from benchmarks.blind.twentyfirst_outside import TWENTYFIRST_OUTSIDE
from benchmarks.blind.twentyfourth_forms import TWENTYFOURTH_FORMS
from benchmarks.blind.twentyfourth_outside import TWENTYFOURTH_OUTSIDE
from benchmarks.blind.twentyninth_forms import TWENTYNINTH_FORMS
from benchmarks.blind.twentyninth_outside import TWENTYNINTH_OUTSIDE
from benchmarks.blind.twentysecond_forms import TWENTYSECOND_FORMS
from benchmarks.blind.twentysecond_outside import TWENTYSECOND_OUTSIDE
from benchmarks.blind.twentyseventh_forms import TWENTYSEVENTH_FORMS
from benchmarks.blind.twentyseventh_outside import TWENTYSEVENTH_OUTSIDE
from benchmarks.blind.twentysixth_forms import TWENTYSIXTH_FORMS
from benchmarks.blind.twentysixth_outside import TWENTYSIXTH_OUTSIDE
from benchmarks.blind.twentythird_forms import TWENTYTHIRD_FORMS
from benchmarks.blind.twentythird_outside import TWENTYTHIRD_OUTSIDE

Depths = Callable[[Faults, int], np.ndarray]
# What makes each form the library's again; contacts, laws and another mesh have their own tests.
ON_THE_BODY: dict[str, dict[str, Any]] = {
    'clamp_offset/slips by load': {'clamp_by_load': False},
    'compliant_clamp/one-sided': {'clamp_form': 'turn'},
    'rest_curvature/helix': {'curvature_form': 'arc'},
    'stiffness_contrast/three pours': {'contrast_mode': 'split'},
    'added_mass/arm': {'mass_form': 'hat'},
    'gravity_tilt/middle_push': {'tilt_form': 'tilt'},
    'clamp_offset/clamped twice': {'clamp_scatter': ()},
    'compliant_clamp/lined': {'clamp_form': 'turn'},
    'rest_curvature/set': {'curvature_form': 'arc'},
    'stiffness_contrast/sleeve': {'contrast_mode': 'split'},
    'added_mass/cable': {'mass_form': 'hat'},
    'compliant_clamp/flexure': {'clamp_form': 'turn'},
    'rest_curvature/kink': {'curvature_form': 'arc'},
    'stiffness_contrast/decaying': {'contrast_mode': 'split'},
    'added_mass/trailing': {'mass_form': 'hat'},
    'gravity_tilt/thread': {'tilt_form': 'tilt'},
    'compliant_clamp/play': {'clamp_form': 'turn', 'clamp_compliance': 0.0},
    'rest_curvature/trestles': {'curvature_form': 'arc'},
    'stiffness_contrast/lamp': {'contrast_mode': 'split'},
    'gravity_tilt/turntable': {'tilt_form': 'tilt'},
    'rest_curvature/coiled': {'curvature_form': 'arc'},
    'stiffness_contrast/slanted': {'contrast_mode': 'split'},
    'added_mass/loose': {'mass_form': 'hat'},
    'gravity_tilt/castors': {'tilt_form': 'tilt'},
    'stiffness_contrast/patched': {'contrast_mode': 'split'},
    'added_mass/drying': {'mass_shares': (1.0,) * 4},
    'clamp_offset/putty': {'clamp_scatter': ()},
    'compliant_clamp/preloaded': {'clamp_form': 'turn'},
    'rest_curvature/recovering': {'curvature_shares': (0.6,) * 4},
    'gravity_tilt/blower': {'tilt_form': 'tilt'},
    'added_mass/pooled': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/streaky': {'contrast_mode': 'split'},
    'compliant_clamp/rubbing': {'clamp_form': 'turn'},
    'rest_curvature/draped': {'curvature_form': 'arc'},
    'compliant_clamp/creeping': {'clamp_form': 'turn'},
    'stiffness_contrast/plugged': {'contrast_mode': 'split'},
    'added_mass/drained': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'compliant_clamp/post': {'clamp_form': 'turn'},
    'clamp_offset/loosening': {'clamp_growth': 0.0},
    'gravity_tilt/draught': {'tilt_form': 'tilt'},
    'rest_curvature/buckled': {'curvature_form': 'arc'},
    'stiffness_contrast/pours': {'contrast_mode': 'split'},
    'compliant_clamp/angle iron': {'clamp_form': 'turn'},
    'clamp_offset/shaken': {'clamp_scatter': ()},
    'gravity_tilt/layer': {'tilt_form': 'tilt'},
    'rest_curvature/folded': {'curvature_form': 'arc'},
    'added_mass/markers': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/foil': {'contrast_mode': 'split'},
    'compliant_clamp/wrist': {'clamp_form': 'turn'},
    'gravity_tilt/extractor': {'tilt_form': 'tilt'},
    'rest_curvature/weighed down': {'curvature_form': 'arc'},
    'added_mass/tool': {'mass_form': 'hat'},
    'stiffness_contrast/settled': {'contrast_mode': 'split'},
    'gravity_tilt/fan': {'tilt_form': 'tilt'},
    'rest_curvature/overhanging': {'curvature_form': 'arc'},
    'added_mass/slung': {'mass_form': 'hat'},
    'stiffness_contrast/marbled': {'contrast_mode': 'split'},
    'clamp_offset/rattling': {'clamp_scatter': ()},
    'rest_curvature/wavy': {'curvature_form': 'arc'},
    'added_mass/sponge': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/overbent': {'contrast_mode': 'split'},
    'compliant_clamp/taped': {'clamp_form': 'turn'},
    'clamp_offset/greased': {'clamp_scatter': ()},
    'gravity_tilt/floating': {'tilt_form': 'tilt'},
    'rest_curvature/crammed': {'curvature_form': 'arc'},
    'added_mass/oozing': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/soaked': {'contrast_mode': 'split'},
    'compliant_clamp/hot glue': {'clamp_shares': ()},
    'clamp_offset/leashed': {'clamp_scatter': ()},
    'gravity_tilt/braking': {'tilt_form': 'tilt'},
    'rest_curvature/jumbled': {'curvature_form': 'arc'},
    'added_mass/wicking': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/creased': {'contrast_mode': 'split'},
    'compliant_clamp/waxed': {'clamp_form': 'turn'},
    'clamp_offset/runout': {'clamp_scatter': ()},
    'gravity_tilt/rocking': {'tilt_form': 'tilt'},
    'rest_curvature/propped': {'curvature_form': 'arc'},
    'added_mass/hung on': {'mass_form': 'hat'},
    'stiffness_contrast/edged': {'contrast_mode': 'split'},
    'compliant_clamp/gantry': {'clamp_form': 'turn'},
    'gravity_tilt/deflating': {'tilt_form': 'tilt'},
    'rest_curvature/outweighed': {'curvature_form': 'arc'},
    'added_mass/spattered': {'mass_form': 'hat'},
    'stiffness_contrast/wedged': {'contrast_mode': 'split'},
    'compliant_clamp/stand': {'clamp_form': 'turn'},
    'clamp_offset/clicking': {'clamp_scatter': ()},
    'gravity_tilt/opposed': {'tilt_form': 'tilt'},
    'rest_curvature/held by its tip': {'curvature_form': 'arc'},
    'added_mass/cradled': {'mass_form': 'hat'},
    'stiffness_contrast/ribbon': {'contrast_mode': 'split'},
    'compliant_clamp/suction': {'clamp_form': 'turn'},
    'clamp_offset/misgraded': {'clamp_scatter': ()},
    'gravity_tilt/curtain': {'tilt_form': 'tilt'},
    'added_mass/filling': {'mass_form': 'hat'},
    'stiffness_contrast/gated': {'contrast_mode': 'split'},
    'compliant_clamp/bobbins': {'clamp_form': 'turn'},
    'clamp_offset/homed': {'clamp_scatter': ()},
    'gravity_tilt/hair dryer': {'tilt_form': 'tilt'},
    'rest_curvature/burdened': {'curvature_form': 'arc'},
    'added_mass/sliding': {'mass_form': 'hat'},
    'stiffness_contrast/dosed': {'contrast_mode': 'split'},
    'clamp_offset/backlash': {'clamp_scatter': ()},
    'gravity_tilt/louvred': {'tilt_form': 'tilt'},
    'rest_curvature/hammock': {'curvature_form': 'arc'},
    'added_mass/slinky': {'mass_form': 'hat'},
    'stiffness_contrast/baked': {'contrast_mode': 'split'},
    'compliant_clamp/gooseneck': {'clamp_form': 'turn'},
    'clamp_offset/eccentric': {'clamp_scatter': ()},
    'gravity_tilt/lee': {'tilt_form': 'tilt'},
    'rest_curvature/mattress': {'curvature_form': 'arc'},
    'added_mass/solder': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/surged': {'contrast_mode': 'split'},
    'compliant_clamp/coil spring': {'clamp_form': 'turn'},
    'clamp_offset/universal joint': {'clamp_scatter': ()},
    'gravity_tilt/screened': {'tilt_form': 'tilt'},
    'rest_curvature/four-point': {'curvature_form': 'arc'},
    'added_mass/spray can': {'mass_form': 'hat'},
    'stiffness_contrast/seeped': {'contrast_mode': 'split'},
    'compliant_clamp/hairpin': {'clamp_form': 'turn'},
    'clamp_offset/tangent arm': {'clamp_scatter': ()},
    'gravity_tilt/hub': {'tilt_form': 'tilt'},
    'rest_curvature/slots': {'curvature_form': 'arc'},
    'added_mass/vine': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/motor heat': {'contrast_mode': 'split'},
    'compliant_clamp/twisted strap': {'clamp_form': 'turn'},
    'gravity_tilt/eddy': {'tilt_form': 'tilt'},
    'rest_curvature/over a rod': {'curvature_form': 'arc'},
    'added_mass/hourglass': {'mass_form': 'hat', 'added_mass_at': 0.7},
    'stiffness_contrast/rolled sheets': {'contrast_mode': 'split'},
    'compliant_clamp/hexapod': {'clamp_form': 'turn'},
    'clamp_offset/chuck key': {'clamp_scatter': ()},
    'gravity_tilt/wall jet': {'tilt_form': 'tilt'},
    'rest_curvature/woven': {'curvature_form': 'arc'},
    'added_mass/harness': {'mass_form': 'hat', 'added_mass_at': 0.5},
    'stiffness_contrast/heat gun': {'contrast_mode': 'split'},
    'clamp_offset/belt': {'clamp_scatter': ()},
    'gravity_tilt/downwash': {'tilt_form': 'tilt'},
    'rest_curvature/wrapped': {'curvature_form': 'arc'},
}
ON_THE_SENSOR: dict[str, dict[str, Any]] = {
    'camera_offset/knocked': {'camera_from': 0},
    'depth_affine/incidence': {'depth_form': 'affine'},
    'depth_bias_by_region/oblique border': {'region_slant': 0.0},
    'camera_offset/sagging': {'camera_sags': False, 'camera_foot': None},
    'depth_affine/near field': {'depth_form': 'affine'},
    'depth_bias_by_region/sticker': {
        'region_from': 0.5,
        'region_until': 1.0,
        'region_ramp': 0.0,
    },
    'camera_offset/decentred': {'tangential': (0.0, 0.0), 'radial_distortion': 0.0},
    'depth_affine/walk': {'depth_form': 'affine'},
    'depth_bias_by_region/sprayed': {'region_above': False},
    'camera_offset/refocused': {'focus_shares': ()},
    'depth_affine/upper rows': {'depth_form': 'affine'},
    'camera_offset/jostled': {'camera_scatter': ()},
    'depth_bias_by_region/glossy': {'region_gloss': 0.0},
    'depth_affine/entry': {'depth_form': 'affine'},
    'camera_offset/in turn': {'camera_scatter': ()},
    'depth_bias_by_region/receding': {'region_places': ()},
    'depth_affine/veil': {'depth_form': 'affine'},
    'depth_bias_by_region/banded': {'region_bands': (0.0, 0.0)},
    'depth_affine/toed': {'depth_form': 'affine'},
    'camera_offset/tilted imager': {'imager_tilt': (0.0, 0.0)},
    'depth_affine/smudge': {'depth_form': 'affine'},
    'depth_bias_by_region/wound': {'region_bands': (0.0, 0.0)},
    'camera_offset/swayed': {'camera_scatter': ()},
    'depth_affine/saturated': {'depth_form': 'affine'},
    'depth_bias_by_region/speckled': {'region_dot': 0.0},
    'camera_offset/leaned on': {'camera_scatter': ()},
    'depth_affine/bounced': {'depth_form': 'affine'},
    'depth_bias_by_region/lengthwise': {'region_strip': 0.0},
    'camera_offset/put back': {'camera_scatter': ()},
    'depth_affine/exposed': {'depth_form': 'affine'},
    'depth_bias_by_region/soiled': {'region_decay': 0.0},
    'camera_offset/framed': {'center_scatter': ()},
    'depth_affine/sunbeam': {'depth_form': 'affine'},
    'depth_bias_by_region/bleached': {'region_sun': (0.0, 0.0)},
    'camera_offset/tugged': {'camera_scatter': ()},
    'depth_affine/flared': {'depth_form': 'affine'},
    'depth_bias_by_region/two-tone': {'region_second': 0.0},
    'camera_offset/hunting': {'camera_scatter': ()},
    'depth_affine/warped': {'depth_form': 'affine'},
    'depth_bias_by_region/luminous': {'region_shares': ()},
    'depth_affine/restarted': {'depth_form': 'affine'},
    'depth_bias_by_region/brushed': {'region_strokes': ()},
    'camera_offset/slider': {'camera_scatter': ()},
    'depth_affine/peeling': {'depth_form': 'affine'},
    'depth_bias_by_region/dipped': {'region_dips': ()},
    'camera_offset/orbiting': {'camera_scatter': ()},
    'depth_affine/two gains': {'depth_form': 'affine'},
    'depth_bias_by_region/checkered': {'region_board': 0.0},
    'camera_offset/desk lamp': {'camera_scatter': ()},
    'depth_affine/splash guard': {'depth_form': 'affine'},
    'depth_bias_by_region/stickers': {'region_stickers': (0.0, 0.0)},
    'camera_offset/rolled': {'camera_scatter': ()},
    'depth_affine/two taps': {'depth_form': 'affine'},
    'depth_bias_by_region/netted': {'region_net': (0.0, 0.0)},
    'camera_offset/mirror': {'camera_scatter': ()},
    'depth_affine/shifted bar': {'depth_form': 'affine'},
    'depth_bias_by_region/polished': {'region_bell': (0.0, 0.0)},
    'camera_offset/wedge': {'camera_scatter': ()},
    'depth_bias_by_region/tongues': {'region_tongue': 0.0},
    'camera_offset/twisting': {'camera_scatter': ()},
    'depth_affine/glued window': {'depth_form': 'affine'},
    'depth_bias_by_region/worn edges': {'region_edges': 0.0},
    'camera_offset/gas spring': {'camera_scatter': ()},
    'depth_affine/wiped': {'depth_form': 'affine'},
    'camera_offset/carpet': {'camera_scatter': ()},
    'depth_affine/breath': {'depth_form': 'affine'},
    'depth_bias_by_region/flaking': {'region_flakes': 0.0},
    'camera_offset/sunlit post': {'camera_scatter': ()},
    'depth_affine/sealed window': {'depth_form': 'affine'},
    'depth_bias_by_region/barcode': {'region_bars': ()},
}
OTHERS = {
    'clamp_offset/bowed',
    'clamp_offset/dragged',
    'clamp_offset/pinched',
    'clamp_offset/slid out',
    'compliant_clamp/gaping',
    'compliant_clamp/glued',
    'contact_plane/rig',
    'camera_offset/pane',
    'contact_plane/brush',
    'contact_plane/corrugated',
    'contact_plane/crate',
    'contact_plane/cushion',
    'contact_plane/dish',
    'contact_plane/felt',
    'contact_plane/flap',
    'contact_plane/gel pad',
    'contact_plane/hovering',
    'contact_plane/jack',
    'contact_plane/knob',
    'contact_plane/mat',
    'contact_plane/packing',
    'contact_plane/pan',
    'contact_plane/pipe',
    'contact_plane/rack',
    'contact_plane/rim',
    'contact_plane/roll',
    'contact_plane/rope',
    'contact_plane/rubber balls',
    'contact_plane/saddle',
    'contact_plane/step',
    'contact_plane/tent',
    'contact_plane/vee',
    'stiffness_contrast/cored',
    'strain_stiffening/beaded',
    'strain_stiffening/braided',
    'strain_stiffening/coils',
    'strain_stiffening/corded',
    'strain_stiffening/foam strip',
    'strain_stiffening/hart_smith',
    'strain_stiffening/interlocked',
    'strain_stiffening/knitted',
    'strain_stiffening/leads',
    'strain_stiffening/recruited',
    'strain_stiffening/rovings',
    'strain_stiffening/ruffled',
    'strain_stiffening/threaded',
    'strain_stiffening/veronda_westmann',
    'strain_stiffening/vertebrae',
}
CAUSES = {
    **SEVENTH_OUTSIDE,
    **EIGHTH_OUTSIDE,
    **NINTH_OUTSIDE,
    **TENTH_OUTSIDE,
    **ELEVENTH_OUTSIDE,
    **TWELFTH_OUTSIDE,
    **THIRTEENTH_OUTSIDE,
    **FOURTEENTH_OUTSIDE,
    **FIFTEENTH_OUTSIDE,
    **SIXTEENTH_OUTSIDE,
    **SEVENTEENTH_OUTSIDE,
    **EIGHTEENTH_OUTSIDE,
    **NINETEENTH_OUTSIDE,
    **TWENTIETH_OUTSIDE,
    **TWENTYFIRST_OUTSIDE,
    **TWENTYSECOND_OUTSIDE,
    **TWENTYTHIRD_OUTSIDE,
    **TWENTYFOURTH_OUTSIDE,
    **TWENTYFIFTH_OUTSIDE,
    **TWENTYSIXTH_OUTSIDE,
    **TWENTYSEVENTH_OUTSIDE,
    **TWENTYEIGHTH_OUTSIDE,
    **TWENTYNINTH_OUTSIDE,
    **THIRTIETH_OUTSIDE,
    **THIRTYFIRST_OUTSIDE,
    **THIRTYSECOND_OUTSIDE,
    **THIRTYTHIRD_OUTSIDE,
}


def _drawn(key: str, setup: Setup) -> Faults:
    return Faults(**BY_KEY[key].draw(2, setup, np.random.default_rng(8)))


def _params(keys: Iterable[str]) -> list[Any]:
    """Return keys of forms as parameters; of what tests of its own check as well, slow ones."""
    slow = {form.key for form in (*TWENTYSEVENTH_FORMS, *TWENTYEIGHTH_FORMS, *TWENTYNINTH_FORMS)}
    slow |= {form.key for form in (*THIRTIETH_FORMS, *THIRTYFIRST_FORMS, *THIRTYSECOND_FORMS)}
    slow |= {form.key for form in THIRTYTHIRD_FORMS}
    return [
        pytest.param(key, marks=(pytest.mark.slow,) if key in slow else ()) for key in sorted(keys)
    ]


def test_every_form_is_checked_here() -> None:
    earlier = (*SEVENTH_FORMS, *EIGHTH_FORMS, *NINTH_FORMS, *TENTH_FORMS)
    later = (*ELEVENTH_FORMS, *TWELFTH_FORMS, *THIRTEENTH_FORMS, *FOURTEENTH_FORMS)
    last = (*FIFTEENTH_FORMS, *SIXTEENTH_FORMS, *SEVENTEENTH_FORMS, *EIGHTEENTH_FORMS)
    newest = (*NINETEENTH_FORMS, *TWENTIETH_FORMS, *TWENTYFIRST_FORMS, *TWENTYSECOND_FORMS)
    newest = (*newest, *TWENTYTHIRD_FORMS, *TWENTYFOURTH_FORMS, *TWENTYFIFTH_FORMS)
    newest = (*newest, *TWENTYSIXTH_FORMS, *TWENTYSEVENTH_FORMS, *TWENTYEIGHTH_FORMS)
    newest = (*newest, *TWENTYNINTH_FORMS, *THIRTIETH_FORMS, *THIRTYFIRST_FORMS)
    newest = (*newest, *THIRTYSECOND_FORMS, *THIRTYTHIRD_FORMS)
    keys = {form.key for form in (*earlier, *later, *last, *newest)}
    assert keys == {*ON_THE_BODY, *ON_THE_SENSOR, *OTHERS}
    for forms, lacking in (
        (SEVENTH_FORMS, {'strain_stiffening'}),
        (EIGHTH_FORMS, {'gravity_tilt'}),
        (NINTH_FORMS, {'strain_stiffening'}),
        (TENTH_FORMS, {'strain_stiffening', 'added_mass', 'depth_bias_by_region'}),
        (ELEVENTH_FORMS, {'clamp_offset', 'compliant_clamp', 'depth_affine'}),
        (TWELFTH_FORMS, {'rest_curvature', 'gravity_tilt', 'depth_bias_by_region'}),
        (THIRTEENTH_FORMS, {'strain_stiffening', 'clamp_offset', 'depth_affine'}),
        (FOURTEENTH_FORMS, {'gravity_tilt', 'added_mass', 'camera_offset'}),
        (FIFTEENTH_FORMS, {'depth_bias_by_region'}),
        (SIXTEENTH_FORMS, {'added_mass'}),
        (SEVENTEENTH_FORMS, {'strain_stiffening'}),
        (EIGHTEENTH_FORMS, {'clamp_offset'}),
        (NINETEENTH_FORMS, {'gravity_tilt'}),
        (TWENTIETH_FORMS, {'strain_stiffening'}),
        (TWENTYFIRST_FORMS, {'strain_stiffening'}),
        (TWENTYSECOND_FORMS, {'camera_offset'}),
        (TWENTYTHIRD_FORMS, {'clamp_offset'}),
        (TWENTYFOURTH_FORMS, {'strain_stiffening'}),
        (TWENTYFIFTH_FORMS, {'rest_curvature'}),
        (TWENTYSIXTH_FORMS, {'contact_plane'}),
        (TWENTYSEVENTH_FORMS, {'compliant_clamp'}),
        (TWENTYEIGHTH_FORMS, {'strain_stiffening'}),
        (TWENTYNINTH_FORMS, {'depth_affine'}),
        (THIRTIETH_FORMS, {'strain_stiffening'}),
        (THIRTYFIRST_FORMS, {'strain_stiffening', 'clamp_offset', 'depth_bias_by_region'}),
        (THIRTYSECOND_FORMS, {'contact_plane'}),
        (THIRTYTHIRD_FORMS, {'strain_stiffening', 'compliant_clamp', 'camera_offset'}),
    ):
        assert len(forms) == len(LIBRARY) - len(lacking)
        assert {form.truth for form in forms} == set(LIBRARY) - lacking


@pytest.mark.parametrize('key', _params(ON_THE_BODY))
def test_a_form_moves_the_body_and_not_as_the_library_does(
    setup: Setup, rests: list[np.ndarray], key: str
) -> None:
    faults = _drawn(key, setup)
    library = replace(faults, **ON_THE_BODY[key])
    moves, apart = [], []
    for pose, rest in enumerate(rests):
        found = rest_of(setup, faults, pose)
        moves.append(np.linalg.norm(found - rest, axis=1).max())
        apart.append(np.linalg.norm(found - rest_of(setup, library, pose), axis=1).max())
    assert 0.002 < max(moves) < 0.03
    assert max(apart) > 0.0005


@pytest.mark.parametrize('key', _params(ON_THE_SENSOR))
def test_a_form_changes_what_is_seen_and_not_as_the_library_does(
    setup: Setup, depths: Depths, key: str
) -> None:
    faults = _drawn(key, setup)
    library = replace(faults, **ON_THE_SENSOR[key])

    def differ(one: Faults, other: Faults) -> bool:
        return any(not np.array_equal(depths(one, pose), depths(other, pose)) for pose in (0, 3))

    assert differ(faults, Faults())
    assert differ(faults, library)


@pytest.mark.parametrize('name', sorted(CAUSES))
def test_a_cause_outside_is_larger_in_a_larger_size(setup: Setup, name: str) -> None:
    sizes = [
        abs(CAUSES[name](size, setup, np.random.default_rng(8)).changes[name]) for size in range(3)
    ]
    assert sizes[0] < sizes[1] < sizes[2]
