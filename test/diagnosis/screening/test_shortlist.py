# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.diagnosis.screening.shortlist import shortlist
import numpy as np

SHIFT, TURN = ('x', 'y', 'z'), ('rx', 'ry', 'rz')


def score(identifier, components, log_evidence, gain, gain_by_pose=None):
    nothing = np.zeros(len(components))
    column = np.zeros((1, len(components)))
    return Score(
        candidate=Candidate(identifier, components),
        gain=gain,
        plain_gain=gain,
        gain_by_pose=gain if gain_by_pose is None else gain_by_pose,
        log_evidence=log_evidence,
        amplitudes=nothing,
        detectable=nothing + 1.0,
        direction=np.zeros(1),
        columns=column,
        plain_columns=column,
        plain_residual=np.zeros(1),
        follows=np.zeros((1, len(components))),
    )


def listed(*scores):
    ordered = tuple(sorted(scores, key=lambda s: -s.log_evidence))
    screen = Screen(ordered, 250.0, 1.0, 54, lambda patches: patches)
    found = shortlist(screen, is_measured=True)
    models = {(s.candidate.identifier, s.candidate.components) for s in found}
    assert len(models) == len(found)
    return models


def test_twins_are_refitted_with_all_amplitudes_or_none_is():
    # The scores of a camera that is turned, too: tangents price its turn by six, its twin's by
    # five, and the one with more amplitudes would have won by their number.
    found = listed(
        score('clamp_offset', SHIFT, 35.0, 89.8),
        score('clamp_offset', SHIFT + TURN, 30.5, 93.1),
        score('clamp_offset', TURN, 18.4, 52.8),
        score('camera_offset', SHIFT, 31.0, 90.0),
        score('camera_offset', SHIFT + TURN, 24.98, 93.4),
    )
    assert ('clamp_offset', SHIFT + TURN) in found
    assert ('camera_offset', SHIFT + TURN) in found
    assert ('camera_offset', SHIFT) in found


def test_amplitudes_that_no_twin_has_are_not_added():
    found = listed(
        score('clamp_offset', SHIFT, 35.0, 89.8),
        score('clamp_offset', SHIFT + TURN, 24.5, 90.1),
        score('camera_offset', SHIFT, 31.0, 90.0),
        score('camera_offset', SHIFT + TURN, 20.98, 90.4),
    )
    assert found == {('clamp_offset', SHIFT), ('camera_offset', SHIFT)}


def test_an_effect_with_fewer_amplitudes_than_its_twin_is_refitted_once():
    found = listed(
        score('camera_offset', SHIFT + TURN, 35.0, 93.1),
        score('depth_affine', ('scale', 'bias'), 31.0, 90.0),
    )
    assert found == {('camera_offset', SHIFT + TURN), ('depth_affine', ('scale', 'bias'))}


def test_what_is_another_one_in_each_pose_is_looked_at_too():
    """A clamp that slips once, of which one offset for all poses explains next to nothing."""
    stiffer = score('stiffness_contrast', ('contrast',), 100.0, 210.0)
    slips = score('clamp_offset', SHIFT + TURN, 5.0, 20.0, 400.0)
    still = score('camera_offset', SHIFT + TURN, 4.0, 20.0, 60.0)
    found = listed(stiffer, slips, still)
    assert ('clamp_offset', SHIFT + TURN) in found
    assert ('camera_offset', SHIFT + TURN) not in found


def test_a_twin_is_looked_at_by_what_it_explains_pose_by_pose():
    """A camera that is bumped before the last pose, of which a clamp's offset explains some."""
    clamp = score('clamp_offset', SHIFT, 36.2, 93.7)
    bumped = score('camera_offset', SHIFT, -4.9, 19.4, 75.5)
    others = [
        score(name, ('one',), -1.0 - number, 2.0)
        for number, name in enumerate(('added_mass', 'stiffness_contrast', 'gravity_tilt'))
    ]
    # No twin of any of the first four, it would have to explain as much as the best twice over.
    far = score('depth_bias_by_region', ('bias',), -6.0, 19.4, 75.5)
    found = listed(clamp, bumped, far, *others)
    assert found == {('clamp_offset', SHIFT), ('camera_offset', SHIFT)}
