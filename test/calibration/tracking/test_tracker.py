# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body is followed from frame to frame: steps, slow changes, hands and darkness."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.current_view import CurrentView
from diffcal_ros.calibration.tracking.tracked import TrackerSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.errors import InputError
import numpy as np
import pytest
from support.followed import ALONE, calibration, exact, Film, fitted, modulus, START
from support.scenes import beam_scene, MODULUS, observation

STEP = 1.3
# The frame rate is 30 Hz, and a step must be followed within two seconds.
TWO_SECONDS = 60


def test_at_rest_it_finds_the_truth_with_honest_errors():
    offs = []
    for seed in range(12):
        last = Film(seed, fit=ALONE).shoot([exact()] * 20)[-1]
        error = next(p for p in last.parameters if p.name == 'youngs_modulus').std_error
        offs.append((modulus(last) - MODULUS) / error)
        assert last.is_taken
        assert last.is_found
        assert last.change is None
    # Chi-square of 12 is less in 99.9 % of cases. It may be far less: a part of the error is that
    # of the pixel grid at the outline, the same in every frame and here in the fit too.
    assert np.sum(np.square(offs)) < 33.0


def test_frames_average_until_the_memory_is_full():
    film = Film(settings=TrackerSettings(memory=0.3), fit=ALONE)
    told = film.shoot([exact()] * 45)
    errors = [t.parameters[0].std_error for t in told]
    assert errors[-1] < errors[0]
    # A share of 1 - exp(-1/9) a frame is worth (2 - a) / a frames.
    assert told[-1].frames_worth == pytest.approx(18.0, rel=0.02)


@pytest.mark.slow
def test_a_step_is_followed_and_told_once():
    film = Film()
    film.shoot([exact()] * 20)
    told = film.shoot([exact(STEP)] * TWO_SECONDS)
    moduli = np.array([modulus(t) for t in told])
    assert not told[0].is_taken
    followed = np.flatnonzero(np.abs(moduli / (STEP * MODULUS) - 1.0) < 0.05)
    assert len(followed), moduli
    assert followed[0] < 10
    assert np.all(np.diff(followed) == 1)
    changes = [t.change for t in told if t.change is not None]
    assert len(changes) == 1
    (change,) = changes
    assert change.is_sudden
    assert change.before['youngs_modulus'] == pytest.approx(MODULUS, rel=0.02)
    assert change.after['youngs_modulus'] == pytest.approx(STEP * MODULUS, rel=0.02)
    # Not an average of before and after.
    assert moduli[-1] == pytest.approx(STEP * MODULUS, rel=0.01)


@pytest.mark.slow
def test_a_slow_change_is_followed_without_a_search():
    film = Film(fit=ALONE)
    film.shoot([exact()] * 20)
    factors = np.round(np.linspace(1.0, 0.88, 60) * 250) / 250
    told = film.shoot([exact(float(factor)) for factor in factors])
    off = np.array([modulus(t) for t in told]) / (factors * MODULUS) - 1.0
    assert np.abs(off).max() < 0.01
    assert film.tracker.search_count == 0
    changes = [t.change for t in told if t.change is not None]
    assert [change.is_sudden for change in changes] == [False] * len(changes)
    assert len(changes) == 2  # 5 % each.


@pytest.mark.slow
def test_a_hand_that_passes_changes_nothing():
    film = Film()
    before = film.shoot([exact()] * 20)[-1]
    hand = exact().copy()
    hand[60:200, 40:240] = 0.15
    during = film.shoot([hand] * 5)
    assert not any(t.is_taken for t in during)
    assert all(modulus(t) == modulus(before) for t in during)
    after = film.shoot([exact()] * 5)
    assert all(t.is_taken for t in after)
    assert film.tracker.search_count == 0
    assert modulus(after[-1]) == pytest.approx(MODULUS, rel=0.01)


def test_after_a_step_it_is_as_sure_as_before():
    film = Film()
    before = film.shoot([exact()] * 30)[-1]
    after = film.shoot([exact(STEP)] * 40)[-1]
    shares = [t.parameters[0].std_error / t.parameters[0].value for t in (before, after)]
    # A stiffer body sags less, and tells less of its modulus in that proportion.
    assert shares[1] < 1.4 * STEP * shares[0]


@pytest.mark.slow
def test_a_body_that_is_gone_is_missed_and_found_again():
    film = Film()
    film.shoot([exact()] * 20)
    nothing = np.full_like(exact(), np.nan)
    told = film.shoot([nothing] * 40)
    assert not told[-1].is_found
    # Once after it was believed, then once a second.
    assert film.tracker.search_count == 2
    back = film.shoot([exact(STEP)] * 45)
    assert back[-1].is_found
    assert modulus(back[-1]) == pytest.approx(STEP * MODULUS, rel=0.01)


def test_a_payload_that_no_parameter_follows_opens_the_gap_and_is_told():
    film = Film()
    film.shoot([exact()] * 20)
    # A bump on the surface is no modulus and no offset.
    columns = np.arange(exact().shape[1])
    payload = exact() - 0.006 * (np.sin(columns / 7.0) > 0.0) * (exact() < 0.5)
    told = film.shoot([payload] * 30)
    changes = [t.change for t in told if t.change is not None]
    assert changes
    assert changes[0].gap_after > 2.0 * changes[0].gap_before


def test_another_stretch_of_the_stream_begins_with_what_was_known():
    film = Film()
    film.shoot([exact()] * 20)
    film.stamp_ns = START - 100_000_000_000
    film.tracker.forget()
    told = film.shoot([exact()] * 2)
    assert told[0].frames_worth == 1.0
    assert modulus(told[-1]) == pytest.approx(MODULUS, rel=0.01)


@pytest.mark.slow
def test_what_cannot_be_followed_is_refused():
    scene = beam_scene((8, 2, 2))
    two = [observation(exact())] * 2
    settings = CalibrationSettings(with_mesh_error=False)
    with pytest.raises(InputError, match='2 observations cannot be followed'):
        Tracker(Calibration(scene, two, settings), fitted().parameters)
    with pytest.raises(InputError, match='give positive numbers'):
        TrackerSettings(memory=0.0)
    with pytest.raises(RuntimeError, match='call follow first'):
        _ = Tracker(calibration(), fitted().parameters).view


def test_a_bias_of_edges_alone_is_no_reason_to_search():
    film = Film()
    # One frame blurs outlines otherwise than many fused.
    (bias,) = film.tracker._parameters.find(Kind.EDGE_BIAS)
    film.tracker.coordinates[bias] += 0.5
    told = film.shoot([exact()] * 20)
    assert told[0].is_taken
    assert film.tracker.search_count == 0
    assert film.tracker.coordinates[bias] == pytest.approx(0.0, abs=0.2)
    assert modulus(told[-1]) == pytest.approx(MODULUS, rel=0.01)


def test_noise_within_its_own_error_is_no_reason_to_render_anew(monkeypatch):
    rendered = []
    render = CurrentView.render
    monkeypatch.setattr(CurrentView, 'render', lambda *given: (rendered.append(1), render(*given)))
    film = Film(settings=TrackerSettings(memory=0.03))
    random = np.random.default_rng(5)
    shaken = [exact() + random.normal(scale=0.004, size=exact().shape) for _ in range(60)]
    told = film.shoot(shaken)
    assert modulus(told[-1]) == pytest.approx(MODULUS, rel=0.03)
    # At the start, and when what one frame shows is weighed once more.
    assert len(rendered) <= 5
