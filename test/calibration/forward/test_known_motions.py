# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions and tangents that are asked for twice are found once."""

from dataclasses import replace

from diffcal_ros.calibration.forward.known_motions import fingerprint, KnownMotions
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene

FIT = ('youngs_modulus', 'damping')


@pytest.fixture
def marches(monkeypatch) -> list[str]:
    """What bodies were asked for."""
    asked: list[str] = []
    for name in ('simulate', 'tangents'):
        plain = getattr(MovingBody, name)

        def told(self, *args, _plain=plain, _name=name, **given):
            asked.append(_name)
            return _plain(self, *args, **given)

        monkeypatch.setattr(MovingBody, name, told)
    return asked


def test_models_of_a_body_share_motions_and_tangents(marches) -> None:
    scene = moving_scene((4, 1, 1), fit=FIT)
    model = moving_model(scene, (0.02, 0.06, 0.13))
    start = model.parameters.start()
    there = start + 0.01
    tangents = {name: model.tangents(place) for name, place in (('a', start), ('b', there))}
    assert marches == ['simulate', 'tangents'] * 2
    other = model.with_parameters(scene, model.parameters)
    for name, place in (('a', start), ('b', there), ('a', start)):
        np.testing.assert_array_equal(other.tangents(place), tangents[name])
    assert marches == ['simulate', 'tangents'] * 2
    model.tangents(start + 0.02)
    model.tangents(start + 0.03)
    assert marches == ['simulate', 'tangents'] * 4
    fresh = moving_model(scene, (0.02, 0.06, 0.13)).tangents(start)
    again = model.with_parameters(scene, model.parameters).tangents(start)
    assert marches[8:] == ['simulate', 'tangents'] * 2
    np.testing.assert_allclose(again, fresh, atol=1e-7 * np.abs(fresh).max())


def test_only_tangents_that_are_not_known_are_followed() -> None:
    known, asked = KnownMotions(), []
    one, two, three = (MotionChange(release_time=time) for time in (1.0, 2.0, 3.0))

    def find(changes) -> np.ndarray:
        asked.append([own.release_time for own in changes])
        return np.array([np.full((1, 2, 3), own.release_time) for own in changes])

    known.tangents('here', [one, two], find)
    found = known.tangents('here', [replace(two), three, replace(one)], find)
    np.testing.assert_array_equal(found[:, 0, 0, 0], [2.0, 3.0, 1.0])
    known.tangents('there', [one], find)
    assert asked == [[1.0, 2.0], [3.0], [1.0]]


def test_large_tangents_are_not_kept(monkeypatch) -> None:
    monkeypatch.setattr('diffcal_ros.calibration.forward.known_motions._MOST_BYTES', 100)
    known, asked = KnownMotions(), []

    def find(changes) -> np.ndarray:
        asked.append(len(changes))
        return np.zeros((len(changes), 1, 5, 3))

    for _ in range(2):
        known.tangents('here', [MotionChange()], find)
    assert asked == [1, 1]


@pytest.mark.parametrize(
    'other',
    [
        MotionChange(release_time=2.0),
        MotionChange(youngs_modulus=np.array([1.0, 3.0])),
        MotionChange(youngs_modulus=np.array([[1.0], [2.0]])),
        MotionChange(youngs_modulus=np.array([1.0, 2.0]), conditions=NO_CONDITIONS),
        MotionChange(damping=np.array([1.0, 2.0])),
    ],
)
def test_other_numbers_have_other_fingerprints(other) -> None:
    plain = MotionChange(youngs_modulus=np.array([1.0, 2.0]))
    assert fingerprint(plain) == fingerprint(replace(plain, youngs_modulus=np.array([1.0, 2.0])))
    assert fingerprint(other) != fingerprint(plain)


def test_fingerprints_go_into_effects() -> None:
    one, same, other = (Conditions(forces=np.array([[0.0, 1.0, size]])) for size in (2, 2, 3))
    assert fingerprint((one, [1.0], {'a': 2})) == fingerprint((same, [1.0], {'a': 2}))
    assert fingerprint(one) != fingerprint(other)


def test_what_cannot_be_compared_is_the_same_as_itself_only() -> None:
    one, other = {1.0}, {1.0}
    assert fingerprint((one, 2)) == fingerprint((one, 2))
    assert fingerprint((one, 2)) != fingerprint((other, 2))
    # What was compared stays: a later object may not be taken for it.
    kept = fingerprint([{3.0}])
    assert all(fingerprint([{3.0}]) != kept for _ in range(100))
