# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set-up page, as its server has it: what follows what; see `test_in_browser.py`, too."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.web.arrangement import arrangement_of
from diffcal_ros.web.setup_page import SAVE, STOP, TAKE
from diffcal_ros.web.setup_words import trial_words
from diffcal_ros.web.trial import Trial
import numpy as np
import pytest
from support.recorded_beam import MODULUS

LONG = 300.0  # [s]


def test_the_gap_follows_place_and_modulus(beam):
    trial = Trial(beam.inputs.scene, beam.inputs.observations)
    wrong = arrangement_of(beam.draft)
    right = replace(wrong, world_from_object=beam.place, youngs_modulus=MODULUS)
    far, near = (trial.simulate(own, is_coarse=False) for own in (wrong, right))
    stiff = trial.simulate(replace(right, youngs_modulus=4 * MODULUS), is_coarse=False)
    # The recorder's mesh is finer, and its camera noisy.
    assert near.gap.median < 0.5e-3
    assert far.gap.coverage < near.gap.coverage - 0.05
    assert stiff.gap.coverage < near.gap.coverage - 0.05
    coarse = trial.simulate(right, is_coarse=True)
    assert len(coarse.vertices) == beam.inputs.scene.mesh.vertex_count
    assert np.abs(coarse.vertices - near.vertices[: len(coarse.vertices)]).max() < 0.02


def test_a_body_out_of_view_has_no_gap(beam):
    trial = Trial(beam.inputs.scene, beam.inputs.observations)
    away = arrangement_of(beam.draft).placed([9.0, 0.0, 0.0], np.zeros(3))
    body = trial.simulate(away, is_coarse=True)
    assert body.gap is None
    assert trial_words(body.gap, is_coarse=True).startswith('**Nothing measured')
    with pytest.raises(InputError, match='see'):
        trial.fit(away)


def test_a_fit_is_taken_and_saved(page, beam, tmp_path):
    page.ask_fit()
    assert page.worker.wait(LONG)
    assert page.controls.buttons[TAKE].disabled is False
    assert page.controls.buttons[STOP].disabled is True
    assert 'Young' in page.controls.news.content
    page.take_fitted()
    page.ask_save()
    assert page.worker.wait(LONG)
    scene = load_scene(tmp_path / 'scene.yaml')
    place = scene.observations[0].world_from_object
    assert place == pytest.approx(page.fitted.arrangement.world_from_object, abs=1e-5)
    assert scene.regions[0].youngs_modulus.start == pytest.approx(MODULUS, rel=0.1)
    assert np.linalg.norm(place[:3, 3] - beam.place[:3, 3]) < 3e-3


def test_a_clamp_that_holds_nothing_is_neither_simulated_nor_saved(page, tmp_path):
    page.edit(lambda own: own.held_from(0.5))
    assert page.worker.wait(LONG)
    assert 'holds 0 vertices' in page.controls.news.content
    page.ask_save()
    assert page.worker.wait(LONG)
    assert page.controls.news.content.startswith('**not saved')
    assert not (tmp_path / 'scene.yaml').exists()
    page.controls.buttons[SAVE].remove()


def test_fields_show_what_is_arranged(page, beam):
    page.edit(lambda own: own.placed([0.1, 0.0, -0.02], [0.0, np.deg2rad(30.0), 0.0]))
    controls = page.controls
    assert controls._position.value == (100.0, 0.0, -20.0)
    assert controls._turn.value == pytest.approx((0.0, 30.0, 0.0))
    assert controls._plane.value == 105.0
    assert controls._modulus.value == pytest.approx(1.5e-3 * MODULUS)
    handle = page._handles._place
    pivot = beam.inputs.scene.mesh.rest_positions[beam.draft.held].mean(axis=0)
    there = page.arrangement.world_from_object @ np.append(pivot, 1.0)
    assert np.array(handle.position) == pytest.approx(there[:3], abs=1e-6)
