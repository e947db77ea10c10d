# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a report draws is what the fit has found already: no body is settled for it again."""

from collections import Counter

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.report.figures.observed_view import observed_views, views_at
from diffcal_ros.report.pages.fit_page import write_report
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest


@pytest.fixture
def settled(monkeypatch) -> Counter:
    """How often each model was solved at each of its coordinates, and any body settled."""
    counts: Counter = Counter()
    solve, settle = ForwardModel.solve, StaticBody.solve_own_equilibrium

    def counted_solve(self, coordinates, warm=None):
        counts[self, coordinates.round(9).tobytes()] += 1
        return solve(self, coordinates, warm)

    def counted_settle(self, *args, **kwargs):
        counts['bodies'] += 1
        return settle(self, *args, **kwargs)

    monkeypatch.setattr(ForwardModel, 'solve', counted_solve)
    monkeypatch.setattr(StaticBody, 'solve_own_equilibrium', counted_settle)
    return counts


@pytest.mark.slow
def test_a_fit_and_its_report_settle_no_body_twice(recorded_beam, tmp_path, settled):
    inputs = open_inputs(load_scene(recorded_beam.scene), [])
    settings = CalibrationSettings(fit=('youngs_modulus', 'rigid_offset'))
    fitted = run_calibration(inputs, settings, tmp_path)
    bodies = settled.pop('bodies')
    assert bodies >= len(settled) > len(fitted[1].history)
    assert set(settled.values()) == {1}
    write_report(tmp_path / 'report.html', *fitted)
    assert settled['bodies'] == 0


def test_pictures_of_remembered_solutions_are_those_of_new_ones(fitted):
    calibration, result = fitted
    (drawn,) = observed_views(calibration, result)
    fresh = calibration.model.with_parameters(calibration.scene, calibration.parameters)
    for picture, values in (
        (drawn.start, result.history[0].values),
        (drawn.fitted, {p.name: p.value for p in result.parameters}),
    ):
        at = np.array([p.coordinate(values[p.name]) for p in calibration.parameters])
        trace = fresh.solve(at).views[0].trace
        shown = picture.depth[trace.rows, trace.columns]
        assert np.isfinite(shown).sum() > 100
        np.testing.assert_allclose(shown, trace.depth, atol=1e-6)


def test_other_values_are_still_simulated(fitted, settled):
    calibration, result = fitted
    values = {p.name: p.value for p in result.parameters}
    values['youngs_modulus'] *= 1.01
    views_at(calibration, values)
    assert settled['bodies'] == 1
