# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole procedure on small beams: clean data agree, hidden effects are reported."""

import json

from diffcal_ros.diagnosis.answers import Evidence, Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.diagnosis.verdict.verdict import save_verdict
from diffcal_ros.report.tables.verdict_text import verdict_lines
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS
from support.watched import watched


@pytest.mark.parametrize(
    'seed', [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))]
)
def test_clean_data_from_another_mesh_agree(seed):
    trace = diagnose(beam_scene((8, 2, 2)), [watched(seed=seed)])
    diagnosis = trace.diagnosis
    assert diagnosis.verdict is Verdict.AGREE
    assert diagnosis.effects == ()
    assert diagnosis.evidence is Evidence.CONFIRMED
    gap = diagnosis.gap_mm
    assert gap.nominal < 2.0 * np.hypot(gap.floor_sensor, gap.floor_numerics)
    hidden = next(line for line in verdict_lines(diagnosis) if line.startswith('HIDDEN'))
    mass = diagnosis.limits['added_mass']['mass']
    assert f'added_mass {mass:.2g} g' in hidden


@pytest.fixture(scope='module')
def biased():
    return diagnose(beam_scene((8, 2, 2)), [watched(seed=1, bias=0.003)])


def test_a_bias_of_depth_is_reported_with_what_would_settle_it(biased):
    diagnosis = biased.diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    # With one pose a uniform bias may as well be the camera's place.
    assert 'depth_affine' in diagnosis.ambiguity_set
    assert diagnosis.unknown_class is None
    assert len(diagnosis.ambiguity_set) > 1
    assert diagnosis.separating_recording
    assert diagnosis.closure > 0.9
    assert diagnosis.gap_mm.added < 0.25 * diagnosis.gap_mm.nominal


def test_the_modulus_heals(biased):
    parameters = biased.diagnosis.parameters
    after = parameters['after']['youngs_modulus']
    assert abs(after['value'] / MODULUS - 1.0) < 0.06


def test_the_verdict_file_holds_what_others_read(biased, tmp_path):
    save_verdict(biased.diagnosis, tmp_path / 'verdict.json')
    verdict = json.loads((tmp_path / 'verdict.json').read_text())
    assert verdict['verdict'] == 'disagree'
    assert {'nominal', 'added', 'floor_sensor', 'floor_numerics'} <= set(verdict['gap_mm'])
    assert {'before', 'after'} == set(verdict['parameters'])
    for key in (
        'evidence',
        'effects',
        'ambiguity_set',
        'runner_up',
        'unknown_class',
        'separating_recording',
        'where',
        'closure',
        'seconds',
    ):
        assert key in verdict


def test_a_person_reads_at_most_seven_kinds_of_lines(biased):
    lines = verdict_lines(biased.diagnosis)
    assert lines[0].startswith('DISAGREE')
    assert len({line.split()[0] for line in lines}) <= 7


def test_residual_images_are_read_as_the_sensor_reads(biased):
    """The bias stands in the nominal picture, and is gone from that of the model with it."""
    before = biased.evaluator.residual_images(biased.nominal.coordinates)[0]
    best = biased.selection.best
    after = best.evaluator.residual_images(best.fit.coordinates)[0]
    assert before.shape == biased.evaluator.model.observations[0].depth.shape
    assert np.nanmedian(np.abs(after)) < 0.25 * np.nanmedian(np.abs(before))


def test_held_out_patches_are_not_fitted(biased):
    """Spoiling them changes what is reported, and nothing that a fit looks at."""
    evaluator, fit = biased.evaluator, biased.nominal
    groups = evaluator.groups(fit.coordinates)
    kept = sum(int(group.is_report.sum()) for group in groups)
    everything = sum(len(group.is_report) for group in groups)
    assert 0.15 < kept / everything < 0.4
    reported, fitted = patch_gap(groups, Part.REPORT).rms, whiten(groups, Part.FIT).values
    for group in groups:
        group.patches.values[group.is_report] += 1.0
    assert patch_gap(groups, Part.REPORT).rms > 0.9 > reported
    np.testing.assert_array_equal(whiten(groups, Part.FIT).values, fitted)


@pytest.mark.slow
def test_a_small_disagreement_is_said_to_be_small():
    trace = diagnose(beam_scene((8, 2, 2)), [watched(seed=2, bias=0.0012)])
    wide = DiagnosisSettings(margin=0.003)
    lenient = diagnose(beam_scene((8, 2, 2)), [watched(seed=2, bias=0.0012)], wide)
    assert trace.diagnosis.p_value < 0.003
    assert lenient.diagnosis.verdict is Verdict.BELOW_MARGIN


@pytest.mark.slow
def test_one_frame_makes_the_evidence_suspected():
    from dataclasses import replace

    single = replace(watched(seed=4, bias=0.006), frame_count=1, noise=float('nan'))
    diagnosis = diagnose(beam_scene((6, 2, 2)), [single]).diagnosis
    assert diagnosis.evidence is Evidence.SUSPECTED
    assert diagnosis.verdict is Verdict.DISAGREE
    assert 'depth_affine' in diagnosis.ambiguity_set


def test_one_pose_offers_twins_and_no_name(biased):
    """The depth camera's bias and its place differ by less than a mesh's error."""
    diagnosis = biased.diagnosis
    assert len(diagnosis.ambiguity_set) > 1
    assert diagnosis.effects == ()
