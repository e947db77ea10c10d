# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is true of a case."""

from dataclasses import asdict, fields
import json
from pathlib import Path
from typing import Any

from benchmarks.blind.amplitudes import Effect, OUTSIDE_CLASS
from benchmarks.blind.cases import Case
from benchmarks.blind.faults import Faults
from benchmarks.blind.later_faults import LaterFaults
from benchmarks.blind.recent_faults import RecentFaults
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.swing_faults import SwingFaults
from benchmarks.blind.timing import Timing
from benchmarks.blind.uniaxial import modulus_along

# Faults that came after labels had been sealed: a label tells of them only where they are any,
# so that those of before come out the same.
_ANEW = ('aspect', 'clamp_late')
_MOTION_FORMS = ('stamps_form', 'drag_form', 'creep_form')
_LAST_SEALED = 'creep_form'
# Sets of motions whose labels tell how stiff a body is along its length, fibres included.
_ALONG = ('swings_four', 'swings_five')


def label_of(
    case: Case,
    setup: Setup,
    effects: tuple[Effect, ...],
    faults: Faults,
    camera_center: FloatArray,
    timing: Timing | None = None,
) -> dict[str, Any]:
    """Return a case's label.

    Args:
        case: whose label.
        setup: the rig.
        effects: that there are.
        faults: the same in numbers.
        camera_center: what a wrong camera turns about [m], shape (3,).
        timing: of a motion whose label tells its damping; None: it does not, or it is none.
    """
    return {
        'id': case.id,
        'set': case.set_name,
        'kind': case.kind,
        'poses': [observation.name for observation in setup.observations],
        'family': case.family,
        'sizes': [size for _, size in case.effects],
        'effects': [_effect(effect, faults) for effect in effects],
        'without': case.without,
        'outside_class': next(
            (OUTSIDE_CLASS[e.identifier] for e in effects if e.identifier in OUTSIDE_CLASS), None
        ),
        'parameters': {
            'youngs_modulus': setup.youngs_modulus,
            'poissons_ratio': setup.poissons_ratio,
            'density': setup.density,
            **({} if timing is None or timing.is_slow else {'damping': timing.damping}),
            **(_along(setup) if case.set_name in _ALONG else {}),
        },
        'start_modulus': setup.start_modulus,
        'sensor': setup.sensor.kind,
        'camera_center': [round(float(value), 6) for value in camera_center],
        'faults': told(faults, case.set_name, is_moving=case.is_moving),
        **({} if case.law is None else _world(setup)),
    }


def _along(setup: Setup) -> dict[str, float]:
    """Return how stiff a body is along its length, whatever its law."""
    along = modulus_along(setup.rubber, setup.youngs_modulus, setup.poissons_ratio)
    return {'youngs_modulus_along': along}


def told(faults: Faults, set_name: str, *, is_moving: bool) -> dict[str, Any]:
    """Return what a label tells of faults.

    Args:
        faults: of the case.
        set_name: its set.
        is_moving: whether its body is filmed after its release.
    """
    names = [field.name for field in fields(Faults)]
    since = (*fields(LaterFaults), *fields(SwingFaults), *fields(RecentFaults))
    later = {*names[names.index(_LAST_SEALED) + 1 :], *(each.name for each in since)}
    if not is_moving:
        later |= set(_MOTION_FORMS)
        if set_name in ('development', 'sealed'):
            later |= set(_ANEW)
    nothing = Faults()
    return {
        name: value
        for name, value in asdict(faults).items()
        if name not in later or getattr(faults, name) != getattr(nothing, name)
    }


def _world(setup: Setup) -> dict[str, Any]:
    """Return what is true of a world whose law and fixture are not as stated."""
    return {
        'rubber': setup.rubber.label(),
        'fixture_shift_mm': [round(1e3 * value, 6) for value in setup.fixture_shift],
    }


def _effect(effect: Effect, faults: Faults) -> dict[str, Any]:
    label = effect.label()
    if effect.identifier == 'contact_plane':
        normal = dict(
            zip(('normal_x', 'normal_y', 'normal_z'), faults.contact_normal, strict=True)
        )
        label['amplitude'] = {**label['amplitude'], 'height': faults.contact_height, **normal}
    return label


def write_json(path: Path, content: Any) -> None:
    """Write JSON in one stroke."""
    fresh = path.with_name(f'.{path.name}.part')
    fresh.write_text(json.dumps(content, indent=2, sort_keys=True) + '\n')
    fresh.rename(path)
