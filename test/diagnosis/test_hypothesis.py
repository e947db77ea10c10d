# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that do nothing, or nothing that is seen, are told from those that matter."""

from diffcal_ros.diagnosis.diagnose import fit_nominal
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, try_effects
from diffcal_ros.diagnosis.model_comparison.refit import Refit, refit
from diffcal_ros.diagnosis.patches.evidence import Evidence
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched


@pytest.fixture(scope='module')
def clean() -> tuple[Evidence, Refit]:
    return fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3)], None)


def _candidate(evidence: Evidence, name: str) -> Candidate:
    listed = candidates(evidence.model.scene, (), None)
    return next(c for c in listed if c.identifier == name and len(c.components) != 2)


def _with_plane_at(clean: tuple[Evidence, Refit], height: float) -> Hypothesis:
    """Put a plane where it is told to be, without fitting it."""
    evidence, base = clean
    plane = _candidate(evidence, 'contact_plane')
    found = try_effects(evidence, base, [plane], {}, max_iterations=1)
    place = found.fit.parameters.names.index('contact_plane.height')
    start = found.fit.coordinates.copy()
    start[place] = height
    fit = refit(found.evidence, start, max_iterations=1)
    return Hypothesis((plane,), found.scene, found.evidence, fit)


def test_a_plane_that_touches_nowhere_is_idle(clean):
    far = _with_plane_at(clean, -1.0)
    assert far.has_idle_effect
    assert not far.has_doubtful_effect, 'a plane has no amplitude that would be zero'


def test_a_plane_that_lifts_the_body_is_not_idle(clean):
    assert not _with_plane_at(clean, -0.060).has_idle_effect


@pytest.mark.parametrize(('bias', 'is_doubtful'), [(0.0, True), (0.003, False)])
def test_an_amplitude_within_its_error_is_doubtful(bias, is_doubtful):
    evidence, base = fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3, bias=bias)], None)
    found = try_effects(evidence, base, [_candidate(evidence, 'depth_affine')], {})
    assert found.has_doubtful_effect == is_doubtful
    assert not found.has_idle_effect
    assert np.isfinite(found.fit.log_evidence)
