# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How right an answer about an effect in another form is."""

from benchmarks.blind.amplitudes import OUTSIDE_CLASS
from benchmarks.blind.answers import Answer

# A name from this confidence on is taken for one.
SAID = 0.6
# Which part of the world an effect belongs to.
CLASS = {
    'camera_offset': 'sensor',
    'depth_affine': 'sensor',
    'depth_bias_by_region': 'sensor',
    'gravity_tilt': 'load',
    'added_mass': 'load',
    'contact_plane': 'load',
    'clamp_offset': 'boundary',
    'compliant_clamp': 'boundary',
    'rest_curvature': 'shape',
    'stiffness_contrast': 'material',
    'strain_stiffening': 'material',
    'time_offset': 'sensor',
    'air_drag': 'load',
    'creep': 'material',
    **OUTSIDE_CLASS,
}


def said_names(answer: Answer) -> set[str]:
    """Return the effects that are named with some confidence."""
    effects = answer.verdict.get('effects') or ()
    return {e['identifier'] for e in effects if float(e['confidence']) >= SAID}


def wrong_names(answer: Answer) -> set[str]:
    """Return those of them that are not there."""
    return said_names(answer) - set(answer.truth)


def is_of_class(answer: Answer) -> bool:
    """Tell whether what is missing is called unknown, and of a true effect's class."""
    return answer.verdict.get('unknown_class') in {CLASS[name] for name in answer.truth}


def may_be_of_class(answer: Answer) -> bool:
    """Tell whether a true effect is of one of the classes that an unknown one is told to be of."""
    told = answer.verdict.get('unknown_classes') or [answer.verdict.get('unknown_class')]
    return not {CLASS[name] for name in answer.truth}.isdisjoint(told)


def outcome(answer: Answer) -> str:
    """Say how right an answer is, in a few words."""
    names, truth = said_names(answer), set(answer.truth)
    if not truth:
        if answer.is_alarm:
            return 'alarm'
        return 'wrong' if names else 'quiet'
    if names:
        return _of_names(names, truth)
    if truth <= answer.reported:
        return 'in the set'
    if answer.verdict.get('unknown_class'):
        return 'unknown, right class' if is_of_class(answer) else 'unknown, other class'
    return 'not seen' if answer.verdict['verdict'] == 'agree' else 'no name'


def _of_names(names: set[str], truth: set[str]) -> str:
    if names == truth:
        return 'right'
    if names > truth:
        return 'right, and another'
    if names < truth:
        return 'one of two'
    return 'one of two, and another' if names & truth else 'wrong'
