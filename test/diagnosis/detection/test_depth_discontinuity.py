# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A step of a millimetre, which pose and modulus have followed, is found where it begins."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.depth_discontinuity import (
    beyond,
    find_depth_discontinuity,
    jumps_seen,
    with_jumps,
)
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patches.patch_gap import tangent_slack
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS
from support.watched import watched, with_step

SCENE = beam_scene((8, 2, 2))


def _boundaries(scene):
    return {effect: settings['at'] for effect, settings in scene.effects.items()}


def _ramped(begin, end, height, steps=9):
    seen = watched(seed=4)
    for at in np.linspace(begin, end, steps):
        seen = with_step(seen, at, height / steps)
    return seen


@pytest.mark.parametrize(
    ('at', 'step'), [(0.3, 0.0015), (0.66, -0.002), (0.437, 0.0045), (0.3, -0.0035)]
)
@pytest.mark.slow_but_first
def test_a_small_step_is_found_where_it_begins(at, step):
    evaluator, _ = fit_nominal(SCENE, [with_step(watched(seed=4), at, step)], None)
    boundaries = _boundaries(evaluator.model.scene)
    assert boundaries.keys() == {'depth_bias_by_region', 'stiffness_contrast'}
    # An eighth of the body lies between two boundaries of elements.
    assert boundaries['depth_bias_by_region'] == pytest.approx(at, abs=0.01)


@pytest.mark.parametrize(
    'look',
    [
        pytest.param(lambda: watched(seed=4), id='nothing'),
        pytest.param(lambda: watched(seed=4, tilt=0.06), id='tilt'),
        pytest.param(lambda: watched(seed=4, bias=0.003), id='bias of the whole'),
        pytest.param(lambda: _ramped(0.26, 0.34, 0.002), id='ramp over a twelfth of the length'),
        pytest.param(
            lambda: with_step(watched(seed=4), 0.5, 0.0015), id='middle, where it is sought anyway'
        ),
        pytest.param(
            lambda: replace(with_step(watched(seed=4), 0.3, 0.0015), frame_count=1, noise=np.nan),
            id='floor is a guess',
        ),
    ],
)
@pytest.mark.slow_but_first
def test_what_is_no_step_elsewhere_moves_no_border(look):
    evaluator, _ = fit_nominal(SCENE, [look()], None)
    assert _boundaries(evaluator.model.scene) == {}


def test_gains_are_those_of_least_squares_with_the_step():
    evaluator, nominal = fit_nominal(SCENE, [with_step(watched(seed=4), 0.5, 0.0015)], None)
    groups = with_jumps(evaluator, nominal, beyond([0.3, 0.5]))
    seen = whiten(groups, Part.FIT, tangent_slack(groups))
    _, precision = regularised_prior(nominal.parameters)
    root = np.linalg.cholesky(precision + 1e-12 * np.eye(len(precision))).T
    usual = EFFECTS['depth_bias_by_region'].component('bias').scale

    def left(columns, priors):
        rows = np.vstack([seen.jacobian[:, columns], priors])
        values = np.concatenate([seen.values, np.zeros(len(priors))])
        found = np.linalg.lstsq(rows, values, rcond=None)[0]
        return float(np.sum((values - rows @ found) ** 2))

    known = list(range(len(precision) + 1))
    without = left(known, np.pad(root, ((0, 0), (0, 1))))
    jumps = jumps_seen(groups, nominal)
    gains, heights = jumps.gains(np.eye(2))
    assert jumps.whole == pytest.approx(without, rel=1e-6)
    for place, gain in enumerate(gains):
        priors = np.pad(root, ((0, 1), (0, 2)))
        priors[-1, -1] = 1.0 / usual
        assert gain == pytest.approx(
            without - left([*known, known[-1] + 1 + place], priors), rel=1e-4
        )
    assert gains[1] > gains[0] > 0.0
    # Pose and modulus have taken up a part of the step.
    assert heights[1] == pytest.approx(0.0015, rel=0.3)


def test_the_share_of_a_patch_beyond_a_step_is_that_of_its_pixels():
    evaluator, nominal = fit_nominal(SCENE, [watched(seed=4)], None)
    (depth,) = (b for b in with_jumps(evaluator, nominal, beyond([0.5])) if b.kind == 'depth')
    whole, share = depth.patches.jacobian[:, -2:].T
    # Averages of ones: the order of the weights' sums costs a rounding on some processors.
    exactly = 8 * np.finfo(float).eps
    assert whole == pytest.approx(1.0, abs=exactly)
    view = evaluator.model.views(nominal.coordinates)[0]
    rows, columns = np.nonzero(view.trace.faces >= 0)
    # By the middles of triangles, of which an eighth of the body lies between two layers.
    middles = evaluator.comparers[0].surface.places[view.trace.faces[rows, columns], 0]
    second = middles > 0.5
    # The beam hangs across the image: whole patches lie on either side, few on the boundary.
    assert second.mean() == pytest.approx(
        np.average(share, weights=depth.patches.weights), abs=0.05
    )
    assert np.mean((share == 0.0) | (share > 1.0 - exactly)) > 0.7
    assert 0.0 < share.mean() < 1.0


def test_of_a_patch_that_is_not_seen_again_no_jump_is_known():
    """A state that is found again may show another patch at the outline."""
    evaluator, nominal = fit_nominal(SCENE, [watched(seed=4)], None)
    (depth,) = (group for group in nominal.groups if group.kind == 'depth')

    def columns(cells):
        patches = replace(depth.patches, cells=cells)
        fit = replace(nominal, groups=(replace(depth, patches=patches),))
        (group,) = with_jumps(evaluator, fit, beyond([0.5]))
        return group.patches.jacobian[:, -2:]

    cells = depth.patches.cells
    known = columns(cells)
    assert known[:, 0].all()
    for others, gone in (
        (np.append(cells[:-1], cells[-1] + 10_000), -1),
        (np.append(cells[0] - 10_000, cells[1:]), 0),
    ):
        found = columns(others)
        assert not found[gone].any()
        kept = np.delete(np.arange(len(cells)), gone)
        assert found[kept] == pytest.approx(known[kept])


@pytest.mark.slow
def test_the_step_is_named_and_the_modulus_heals():
    diagnosis = diagnose(SCENE, [with_step(watched(seed=4), 0.3, 0.002)]).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'depth_bias_by_region'
    assert effect.amplitude['bias'] == pytest.approx(2.0, abs=0.3)
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.05


def test_a_scene_that_knows_its_border_keeps_it():
    scene = replace(SCENE, effects={'depth_bias_by_region': {'at': 0.4}})
    evaluator, nominal = fit_nominal(scene, [with_step(watched(seed=4), 0.3, 0.0015)], None)
    assert find_depth_discontinuity(evaluator, nominal) is None
    assert _boundaries(evaluator.model.scene) == {'depth_bias_by_region': 0.4}
