# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cables in scene files: what is read, what is refused, and what a fitted scene says."""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import SceneError
from diffcal_ros.fem.terms.cable_route import route_through, RouteError
from diffcal_ros.rigid_transform import looking_at
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
from diffcal_ros.scene.sections.cables import start_cables
import numpy as np
import pytest

VIA = [[-0.09, 0.0, 0.01], [0.0, 0.001, 0.012], [0.09, 0.0, 0.01]]
LENGTH = float(np.linalg.norm(np.diff(np.array(VIA), axis=0), axis=1).sum())
# The conftest's beam is held at its high-x end.
CAMERA = PinholeCamera(160, 120, 150.0, 155.0, 78.0, 61.0)
POSE = looking_at(np.zeros(3), np.array([0.05, 0.1, 0.4]), np.array([0.0, 1.0, 0.0]))


def with_cable(**settings) -> dict:
    return {'cables': {'tendon': {'via': VIA, **settings}}}


def test_defaults_are_a_taut_cable(write_scene):
    (cable,) = load_scene(write_scene(with_cable())).cables
    assert cable.name == 'tendon'
    assert cable.length == pytest.approx(LENGTH)
    assert cable.rest_length.start == pytest.approx(LENGTH)
    assert cable.rest_length.lower < LENGTH < cable.rest_length.upper
    assert cable.stiffness.start == 1e4


def test_pull_and_rest_length_say_the_same(write_scene):
    (pulled,) = load_scene(write_scene(with_cable(pull=0.018))).cables
    (given,) = load_scene(write_scene(with_cable(rest_length=LENGTH - 0.018))).cables
    assert pulled.rest_length.start == pytest.approx(given.rest_length.start, abs=1e-12)
    bounded = {'start': 0.17, 'min': 0.15, 'max': 0.19, 'prior': {'mean': 0.17, 'std': 0.002}}
    (known,) = load_scene(
        write_scene(with_cable(rest_length=bounded, stiffness={'start': 500.0}))
    ).cables
    assert (known.rest_length.lower, known.rest_length.prior_std) == (0.15, 0.002)
    assert known.stiffness.start == 500.0


def test_observations_pull_each_their_own_way(write_scene):
    changes = {
        **with_cable(pull=0.002),
        'observations': [{'name': 'loose'}, {'name': 'bent', 'pulls': {'tendon': 0.02}}],
        'fit': ['rest_length', 'cable_stiffness.tendon'],
    }
    scene = load_scene(write_scene(changes))
    loose, bent = (start_cables(scene, setup)[0] for setup in scene.observations)
    assert loose.rest_length == pytest.approx(LENGTH - 0.002)
    assert bent.rest_length == pytest.approx(LENGTH - 0.022)
    assert make_parameters(scene).names == ('rest_length', 'cable_stiffness', 'edge_bias')


def test_cable_without_stiffness_is_no_cable_bit_for_bit(write_scene):
    plain = load_scene(write_scene({'fit': ['youngs_modulus']}))
    without = load_scene(write_scene({**with_cable(stiffness=0), 'fit': ['youngs_modulus']}))
    assert without.cables == ()
    assert 'cable tendon has no stiffness and is left out' in without.notes
    seen = Observation('x', 0, np.full((120, 160), np.nan, np.float32), CAMERA, POSE)
    parameters = make_parameters(plain, with_edge_bias=False)
    points = [
        ForwardModel(scene, [seen], parameters).views(parameters.start())[0].points
        for scene in (plain, without)
    ]
    np.testing.assert_array_equal(*points)


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'cables': {'tendon': {'via': VIA[:1]}}}, r'cables.tendon.via has 1 points: give at'),
        ({'cables': {'tendon': {}}}, r'cables.tendon.via is missing: give a list of via points'),
        ({'cables': {'tendon': {'via': [[0, 0], [1, 2]]}}}, r'via\[0\] is \[0, 0\]: give a list'),
        (
            {'cables': {'tendon': {'via': [VIA[0], [0.3, 0.0, 0.0]]}}},
            r'via point 1 at \(0.3, 0, 0\) m, outside of the body: move it inside',
        ),
        (with_cable(rest_length=0.0), r'rest_length is 0: give the cable.s rest length in m'),
        (with_cable(rest_length=-0.1), r'rest_length is -0.1: give the cable.s rest length in m'),
        (with_cable(rest_length=180.0), r'rest_length is 180: .* is usually'),
        (with_cable(rest_length=0.17, pull=0.01), 'has rest_length and pull: keep one'),
        (with_cable(pull=18), 'pull is 18: give by how many metres it is shortened'),
        (with_cable(stiffness=-5), r'stiffness is -5: give the cable.s stiffness in N/m, above 0'),
        (with_cable(stifness=5), 'stifness is no key that is known here; did you mean `stiffness'),
        ({'cables': {'my tendon': {'via': VIA}}}, 'is no name for a cable'),
        ({**with_cable(), 'fit': ['rest_length.tenden']}, 'did you mean `rest_length.tendon`'),
        ({'fit': ['rest_length']}, "fit has 'rest_length'"),
        (
            {**with_cable(), 'observations': [{'name': 'a', 'pulls': {'tenden': 0.01}}]},
            'is no cable of the scene; did you mean `tendon`',
        ),
        (
            {**with_cable(), 'observations': [{'name': 'a', 'pulls': {'tendon': 10}}]},
            'something must be left of it',
        ),
        (
            {
                **with_cable(),
                'held': {
                    'clamp': {'box': {'x': [0.08, 1.0]}},
                    'end': {'box': {'x': [-1.0, -0.08]}},
                },
                'motion': {'released': ['end'], 'at': 0.1},
            },
            'cables are given while the body moves',
        ),
    ],
)
def test_wrong_cables_are_refused(write_scene, changes, words):
    with pytest.raises(SceneError, match=words):
        load_scene(write_scene(changes))


def test_gap_that_is_meant_may_be_crossed(write_scene, write_tet, make_beam, tmp_path):
    beam = make_beam((10, 2, 2))
    x, _, z = beam.centroids.T
    kept = ~((np.abs(x) < 0.021) & (z > 0.0))
    used, tets = np.unique(beam.tets[kept], return_inverse=True)
    notched = type(beam)(beam.rest_positions[used], tets.reshape(-1, 4).astype(np.int32))
    straight = np.array([VIA[0], VIA[2]])
    with pytest.raises(RouteError, match='leaves the body'):
        route_through(notched, straight)
    path = write_scene({'cables': {'tendon': {'via': straight.tolist()}}})
    write_tet(tmp_path / 'beam.tet', notched)
    with pytest.raises(SceneError, match=r'leaves the body between via points.*crosses_gaps'):
        load_scene(path)
    path = write_scene({'cables': {'tendon': {'via': straight.tolist(), 'crosses_gaps': True}}})
    write_tet(tmp_path / 'beam.tet', notched)
    assert len(load_scene(path).cables) == 1


def test_fitted_scene_keeps_the_cable(write_scene, tmp_path):
    scene = load_scene(write_scene({**with_cable(pull=0.018), 'fit': ['rest_length']}))
    save_fitted_scene(
        scene, tmp_path / 'fitted.yaml', {'rest_length': 0.1625, 'cable_stiffness.tendon': 800.0}
    )
    (again,) = load_scene(tmp_path / 'fitted.yaml').cables
    assert (again.rest_length.start, again.stiffness.start) == (0.1625, 800.0)
    with pytest.raises(ValueError, match='of no cable of the scene'):
        save_fitted_scene(scene, tmp_path / 'fitted.yaml', {'rest_length.x': 0.1})
