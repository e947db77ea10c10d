# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An edge in the picture: its settings, what is beyond it, how it is read and said."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.diagnosis.patches.rigid_reference import RigidReference
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.effects.picture_edge import edge_in, has_edge, NOWHERE, PictureEdge
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import InputError
from diffcal_ros.report.tables.verdict_text import effect_words
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.sections.fixture import blocks_fixture
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD, observation, true_depth

TURN, PLACE, HEIGHT = 0.4, -0.03, 0.004
STATED = {'edge_turn': TURN, 'edge_at': PLACE}


def test_what_is_beyond_is_ahead_along_its_way(random):
    directions = random.uniform(-0.5, 0.5, size=(400, 2))
    x, y = directions.T
    ahead = np.cos(TURN) * x + np.sin(TURN) * y - PLACE
    edge = PictureEdge(TURN, PLACE)
    np.testing.assert_array_equal(edge.beyond(directions), ahead > 0.0)
    wide = replace(edge, width=0.1).beyond(directions)
    assert ((wide > 0.0) & (wide < 1.0)).sum() > 20
    np.testing.assert_allclose(wide, np.interp(ahead, [-0.05, 0.05], [0.0, 1.0]))


@pytest.mark.parametrize('curve', [3.0, -3.0])
def test_what_is_beyond_a_round_edge_is_inside_or_outside(random, curve):
    """It is one over how far ahead the middle is: circles about that cross the way there."""
    directions = random.uniform(-0.5, 0.5, size=(400, 2))
    middle = np.array([np.cos(TURN), np.sin(TURN)]) / curve
    apart = np.linalg.norm(directions - middle, axis=1)
    radius = abs(1.0 / curve - PLACE)
    edge = PictureEdge(TURN, PLACE, curve=curve)
    is_beyond = apart < radius if curve > 0.0 else apart > radius
    assert 20 < is_beyond.sum() < 380
    np.testing.assert_array_equal(edge.beyond(directions), is_beyond)
    np.testing.assert_allclose(edge.along(directions), 1.0 / curve - np.sign(curve) * apart)


@pytest.mark.parametrize('curve', [1e-2, 1e-4, 1e-6])
def test_a_round_edge_goes_over_into_a_straight_one(random, curve):
    directions = random.uniform(-0.5, 0.5, size=(100, 2))
    straight = PictureEdge(TURN, PLACE)
    off = replace(straight, curve=curve).along(directions) - straight.along(directions)
    across = directions @ np.array([-np.sin(TURN), np.cos(TURN)])
    np.testing.assert_allclose(off, -0.5 * curve * across**2, atol=0.5 * curve**2 + 1e-15)


def test_each_pose_may_have_its_own_place():
    assert edge_in({}, 0) is None
    assert not has_edge({'edge_turn': TURN})
    assert edge_in(STATED, 3) == PictureEdge(TURN, PLACE)
    assert edge_in({**STATED, 'edge_curve': -2.0}, 0) == PictureEdge(TURN, PLACE, curve=-2.0)
    own = {'edge_turn': TURN, 'edge_at_2': 0.1}
    assert has_edge(own)
    assert (edge_in(own, 0), edge_in(own, 1)) == (None, PictureEdge(TURN, 0.1))
    # Those that have none have the one of all.
    assert edge_in({**own, **STATED}, 0) == PictureEdge(TURN, PLACE)


def test_a_scene_states_an_edge(write_scene):
    stated = {**STATED, 'beyond': HEIGHT, 'edge_at_3': 0.2}
    own = load_scene(write_scene({'effects': {'depth_affine': stated}})).effects['depth_affine']
    assert own == {'scale': 0.0, 'bias': 0.0, **stated}
    plain = load_scene(write_scene({'effects': {'depth_affine': {'bias': 0.002}}})).effects
    assert plain['depth_affine'] == {'scale': 0.0, 'bias': 0.002, 'beyond': 0.0}


@pytest.mark.parametrize(
    'wrong', [{'edge_at': 2.0 * NOWHERE}, {'edge_width': -0.1}, {'edge_curve': 60.0}]
)
def test_what_is_no_edge_is_refused(write_scene, wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        load_scene(write_scene({'effects': {'depth_affine': wrong}}))


def _model(more):
    scene = replace(beam_scene((6, 2, 2)), effects={'depth_affine': {**STATED, **more}})
    names = ('youngs_modulus', *(['depth_affine.beyond'] if not more else []))
    parameters = make_parameters(scene, names, with_edge_bias=False)
    return ForwardModel(scene, [observation(true_depth())], parameters)


def _is_beyond(trace):
    x, y = np.moveaxis(CAMERA.rays()[trace.rows, trace.columns][..., :2], -1, 0)
    return np.cos(TURN) * x + np.sin(TURN) * y > PLACE


def test_a_camera_reads_too_far_beyond_it():
    model = _model({'beyond': HEIGHT, 'bias': -0.001})
    here = model.parameters.start()
    trace, sensor = model.views(here)[0].trace, model.sensor(here, 0)
    error = make_comparers(model)[0].read(trace, sensor) - trace.depth
    beyond, seen = _is_beyond(trace), trace.faces >= 0
    assert min((beyond & seen).sum(), (~beyond & seen).sum()) > 500
    np.testing.assert_allclose(error[seen], HEIGHT * beyond[seen] - 0.001, atol=1e-12)


def test_residuals_follow_what_is_beyond_it():
    model = _model({})
    objective = RobustObjective(model)
    here = model.parameters.start()
    (view,), (comparison,) = model.views(here), objective.comparisons(here)
    (tangent,) = model.tangents(here)
    (depth, columns), _ = objective.with_jacobians(0, comparison, view, tangent, here)
    index = model.parameters.names.index('depth_affine.beyond')
    expected = _is_beyond(view.trace).ravel()[depth.indices]
    np.testing.assert_array_equal(columns[:, index], expected)
    assert 0 < expected.sum() < len(expected)


def test_a_fit_of_all_of_it_has_what_is_beyond_an_edge_where_there_is_one():
    plain = beam_scene((6, 2, 2))
    stated = replace(plain, effects={'depth_affine': STATED})
    names = [
        make_parameters(scene, ('depth_affine',), with_edge_bias=False).names
        for scene in (plain, stated)
    ]
    assert list(names[0]) == ['depth_affine.scale', 'depth_affine.bias']
    assert list(names[1]) == [*names[0], 'depth_affine.beyond']


def test_a_fixture_is_read_as_wrongly():
    scene = replace(beam_scene((6, 2, 2)), effects={'depth_affine': STATED})
    fixture = blocks_fixture([np.array([[-0.03, -0.01, -0.01], [0.0, 0.035, 0.03]])])
    seen = Observation('seen', 0, true_depth().astype(np.float32), CAMERA, DEPTH_FROM_WORLD)
    reference = RigidReference(scene, fixture, seen)
    assert reference.comparer.surface.edge == PictureEdge(TURN, PLACE)


def test_what_is_beyond_is_looked_for_where_an_edge_shows():
    def tried(scene):
        own = [c for c in candidates(scene) if c.identifier == 'depth_affine']
        return {candidate.components for candidate in own}

    plain = beam_scene()
    with_edge = replace(plain, effects={'depth_affine': STATED})
    assert tried(with_edge) == {*tried(plain), ('beyond',), ('bias', 'beyond')}


@pytest.mark.parametrize(
    ('setting', 'said'),
    [
        (STATED, 'past an edge at -0.03 in the picture, 23 degrees from x to y'),
        (
            {**STATED, 'edge_curve': 2.0},
            'past an edge at -0.03 in the picture, 23 degrees from x to y, '
            'round x / z = 0.46, y / z = 0.19',
        ),
        (
            {'edge_turn': TURN, 'edge_at_1': 0.1, 'edge_at_3': -0.2},
            'past an edge at -0.2 to 0.1 (another place in each pose) in the picture, '
            '23 degrees from x to y',
        ),
    ],
)
def test_words_say_where_it_is(setting, said):
    effect = EFFECTS['depth_affine']
    named = NamedEffect(
        identifier=effect.identifier,
        group=effect.group,
        amplitude={'beyond': 4.1},
        std_error={'beyond': 0.2},
        unit={'beyond': 'mm'},
        setting=setting,
        frame={},
        confidence=0.8,
        sentence=effect.sentence,
        outside_twins=(),
    )
    assert effect_words(named).endswith(said)
