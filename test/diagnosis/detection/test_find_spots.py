# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Stickers, prints and dots on a body are found where they are, and read the right way round."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.borders_seen import knowing
from diffcal_ros.diagnosis.detection.find_spots import find_spots
from diffcal_ros.diagnosis.detection.material_boundary import OFF, with_spots
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.model_comparison.settled_spots import settled_spots
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.effects.spots import cells_of, ROUND, ROWS, spot_settings, spots_of
from diffcal_ros.effects.surface_parts import parts_of
from diffcal_ros.rigid_transform import transform
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.scenes import MODULUS
from support.watched import with_part

HEIGHT = -0.006
LAYERS = 16


def _scene():
    return beam_in_two_poses(LAYERS)[0]


def _seen():
    return beam_in_two_poses(LAYERS)[1]


def _print(kind):
    """Return a map of a print on the outer two thirds, shape (ROWS, ROUND)."""
    rows, around = np.mgrid[:ROWS, :ROUND]
    if kind == 'squares':
        cells = (rows // 8 + around // 12) % 2 == 0
    elif kind == 'stickers':
        cells = ((rows + 2) % 12 - 6) ** 2 + (1.2 * (around % 24 - 12)) ** 2 < 28
    else:
        drawn = np.random.default_rng(7).random((ROWS // 6 + 1, ROUND // 6)) < 0.35
        cells = np.kron(drawn, np.ones((6, 6), dtype=bool))[:ROWS]
    return cells & (rows > ROWS // 3)


def _printed(cells, height=HEIGHT):
    return [with_part(seen, spot_settings(cells), height, _scene()) for seen in _seen()]


def _fitted(seen):
    """Return the evaluator of the model as it is, and the map that its scene states."""
    evaluator, nominal = fit_nominal(_scene(), seen, None)
    stated = evaluator.model.scene.effects.get('depth_bias_by_region', {})
    return evaluator, nominal, spots_of(stated)


def _alike(found, cells, evaluator, nominal):
    """Return the share of the cells that are seen well of which a map is right."""
    places = [
        comparer.places(view.trace, np.flatnonzero(view.trace.faces >= 0).astype(np.int32))
        for comparer, view in zip(
            evaluator.comparers, evaluator.model.views(nominal.coordinates), strict=True
        )
    ]
    counts = np.bincount(cells_of(np.concatenate(places)), minlength=ROWS * ROUND)
    well = counts.reshape(ROWS, ROUND) >= 3
    return float(np.mean(found[well] == cells[well]))


@pytest.mark.parametrize(
    'kind',
    ['dots', *(pytest.param(own, marks=pytest.mark.slow) for own in ('squares', 'stickers'))],
)
def test_spots_are_found_where_they_are(kind):
    cells = _print(kind)
    evaluator, nominal, found = _fitted(_printed(cells))
    assert found is not None
    assert _alike(found.cells, cells, evaluator, nominal) > 0.9


@pytest.mark.slow
def test_spots_are_read_the_right_way_round_where_they_are_most_of_the_body():
    cells = _print('dots')
    others = ~cells & (np.arange(ROWS) > ROWS // 3)[:, None]
    assert others.sum() > 0.55 * (others | cells).sum()
    evaluator, nominal, found = _fitted(_printed(others))
    assert _alike(found.cells, others, evaluator, nominal) > 0.9


@pytest.mark.parametrize(
    'seen',
    [
        pytest.param(_seen, id='nothing'),
        pytest.param(lambda: [_printed(_print('dots'))[0], _seen()[1]], id='before one of two'),
        pytest.param(lambda: _printed(_print('dots'))[:1], id='one pose'),
        pytest.param(
            lambda: [with_part(own, {'at': 0.4}, HEIGHT, _scene()) for own in _seen()],
            id='one step',
        ),
    ],
)
@pytest.mark.slow
def test_what_are_no_spots_are_not_taken_for_some(seen):
    assert _fitted(seen())[2] is None


@pytest.mark.slow
def test_spots_leave_far_less_than_what_was_found_before():
    cells = _print('squares')
    scene = replace(_scene(), effects={'depth_bias_by_region': {'at': 0.5}})
    evaluator, nominal = fit_nominal(scene, _printed(cells), None)
    one, other = find_spots(evaluator, nominal, ())
    assert not (one & other).any()
    # Beside a map that is the print there is nothing left to be far less than.
    assert find_spots(evaluator, nominal, parts_of(spot_settings(cells))) == []


@pytest.mark.slow
def test_of_two_readings_the_one_that_explains_more_is_placed_anew():
    cells = _print('stickers')
    scene = replace(_scene(), effects={'depth_bias_by_region': {'at': 0.5}})
    evaluator, nominal = fit_nominal(scene, _printed(cells), None)
    # Of one reading a tenth of the cells is wrong, of the other all others are.
    rough = cells ^ (np.random.default_rng(1).random(cells.shape) < 0.1)
    read = [knowing(with_spots(scene, own), evaluator, nominal) for own in (~rough, rough)]
    found, left = settled_spots(read)
    assert _alike(rough, cells, evaluator, nominal) == pytest.approx(0.9, abs=0.02)
    assert _alike(found, cells, evaluator, nominal) > 0.97
    # Read the wrong way round they leave more than noise.
    assert left < OFF < settled_spots(read[:1])[1]


@pytest.mark.slow
def test_stickers_are_named_and_the_modulus_heals():
    diagnosis = diagnose(_scene(), _printed(_print('stickers'))).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (named,) = diagnosis.effects
    assert named.identifier == 'depth_bias_by_region'
    assert named.amplitude['bias'] == pytest.approx(1e3 * HEIGHT, abs=0.3)
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.03


@pytest.mark.slow
def test_spots_show_beside_a_body_that_is_elsewhere_in_each_pose():
    """Of a body that is elsewhere than its model cells of one pose are not those of another."""
    cells = _print('stickers')
    seen = _printed(cells)
    setups = [
        replace(
            own, world_from_object=own.world_from_object @ transform(np.eye(3), (off, 0.0, 0.0))
        )
        for own, off in zip(_scene().observations, (0.006, -0.006), strict=True)
    ]
    scene = replace(_scene(), observations=tuple(setups))
    evaluator, _ = fit_nominal(scene, seen, None)
    assert not evaluator.model.scene.effects
    trace = diagnose(scene, seen)
    found = spots_of(trace.evaluator.model.scene.effects['depth_bias_by_region'])
    assert _alike(found.cells, cells, trace.evaluator, trace.nominal) > 0.85
    assert 'depth_bias_by_region' in trace.selection.best.identifiers
