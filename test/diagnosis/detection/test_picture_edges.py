# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An edge in the picture is found from pixels of several poses, and no other step is one."""

from dataclasses import replace

from diffcal_ros.diagnosis.detection.edge_search import round_edge, straight_edge
from diffcal_ros.diagnosis.detection.picture_edges import (
    edge_in_views,
    find_picture_edge,
    with_edge,
)
from diffcal_ros.diagnosis.detection.pictured_views import is_there, PicturedView, SeenEdge
from diffcal_ros.diagnosis.detection.spot_map import SpottedView
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.effects.picture_edge import PictureEdge
import numpy as np
import pytest
from support.clamped_anew import rolled
from support.scenes import beam_scene, CAMERA

HEIGHT, NOISE, TURN = 0.005, 0.00015, 0.5
_PIXELS = 6000
# Where the body's middle is in the picture, and how it lies there [rad], in each pose.
POSES = ((0.07, 0.01, 0.0), (-0.08, 0.0, 0.25), (0.1, -0.02, -0.3), (0.0, 0.03, 0.1))


def _view(random, posture, read, *, outliers=0.03):
    """Return pixels of a body that is bent otherwise than its model in each pose.

    Args:
        random: draws places and noise.
        posture: number of the pose.
        read: from directions and places to what is read too far [m].
        outliers: share of pixels that see something else.
    """
    along, aside = random.uniform(size=_PIXELS), random.uniform(-1.0, 1.0, size=_PIXELS)
    x, y, turn = POSES[posture]
    own = np.column_stack([0.3 * (along - 0.5), 0.05 * aside])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    directions = own @ rotation.T + [x, y]
    places = np.column_stack([along, np.ones(_PIXELS), aside])
    smooth = 0.003 * (posture - 1.5) * (1.0 - 2.0 * along + 1.5 * along**2)
    left = read(directions, places, posture) + smooth + NOISE * random.normal(size=_PIXELS)
    is_other = random.random(_PIXELS) < outliers
    left[is_other] += random.uniform(0.005, 0.02, size=int(is_other.sum()))
    return PicturedView(SpottedView.of(left, places), directions, places, posture)


def _views(random, read, count=4, **kwargs):
    return [_view(random, posture, read, **kwargs) for posture in range(count)]


def _edge(places, height=HEIGHT, width=0.0, curve=0.0):
    """Return what is read beyond an edge that is somewhere in each pose."""
    edges = [PictureEdge(TURN, place, width, curve) for place in places]
    return lambda directions, _, posture: height * edges[posture].beyond(directions)


@pytest.mark.parametrize('height', [HEIGHT, -HEIGHT])
@pytest.mark.parametrize('outliers', [0.0, 0.12])
@pytest.mark.slow
def test_an_edge_at_one_place_is_found(random, height, outliers):
    views = _views(random, _edge([0.013] * 4, height), outliers=outliers)
    found = straight_edge(views, is_fixed=True)
    assert is_there(views, found)
    edge = found.edges[0]
    assert edge.turn == pytest.approx(TURN, abs=np.deg2rad(3.0))
    assert edge.place == pytest.approx(0.013, abs=0.004)
    assert all(own == edge for own in found.edges.values())


@pytest.mark.slow
def test_an_edge_that_moves_from_pose_to_pose_is_found_with_its_width(random):
    places = (0.06, 0.0, -0.02, 0.04)
    views = _views(random, _edge(places, width=0.02))
    assert not is_there(views, straight_edge(views, is_fixed=True))
    found = straight_edge(views, is_fixed=False)
    assert is_there(views, found)
    assert found.edges[0].turn == pytest.approx(TURN, abs=np.deg2rad(4.0))
    assert found.edges[0].width in (0.01, 0.02, 0.04)
    near = [found.edges[number].place for number in range(4)]
    np.testing.assert_allclose(near, places, atol=0.008)


def _middle(edge):
    return edge.way / edge.curve


@pytest.mark.parametrize('curve', [5.0, -6.0])
@pytest.mark.parametrize('places', [(0.02,) * 4, (0.07, 0.04, 0.02, -0.01)])
@pytest.mark.slow
def test_a_round_edge_is_found(random, curve, places):
    views = _views(random, _edge(places, curve=curve), outliers=0.05)
    found = edge_in_views(views)
    assert found.is_fixed == (len(set(places)) == 1)
    np.testing.assert_allclose(
        _middle(found.edges[0]), _middle(PictureEdge(TURN, 0.0, curve=curve)), atol=0.04
    )
    for posture, place in enumerate(places):
        own, true = found.edges[posture], PictureEdge(TURN, place, curve=curve)
        directions = views[posture].directions
        wrong = own.beyond(directions) != true.beyond(directions)
        # Which side reads right is not told here.
        assert min(wrong.mean(), 1.0 - wrong.mean()) < 0.04


@pytest.mark.parametrize('curve', [0.0, 0.2])
@pytest.mark.slow
def test_one_that_is_about_straight_is_straight(random, curve):
    views = _views(random, _edge([0.013] * 4, curve=curve))
    assert edge_in_views(views).edges[0].curve == 0.0


def test_two_poses_with_a_step_each_have_no_edge_that_moves(random):
    views = _views(random, _edge((0.06, 0.0)), count=2)
    assert not is_there(views, straight_edge(views, is_fixed=False))


@pytest.mark.parametrize(
    'read',
    [
        pytest.param(lambda directions, *_: 0.0 * directions[:, 0], id='nothing'),
        pytest.param(lambda directions, *_: 0.05 * directions[:, 0], id='a slope'),
        pytest.param(lambda directions, *_: HEIGHT * np.sin(20.0 * directions[:, 0]), id='waves'),
        pytest.param(lambda _, places, __: HEIGHT * (places[:, 0] > 0.45), id='a border along'),
        pytest.param(
            # The model knows where the body is to some hundredths of its length.
            lambda _, places, posture: (
                HEIGHT * (places[:, 0] > 0.45 + (0.0, 0.03, -0.03, 0.01)[posture])
            ),
            id='a border of a body that is elsewhere',
        ),
        pytest.param(lambda _, places, __: HEIGHT * (places[:, 2] > 0.1), id='a border across'),
        pytest.param(
            lambda directions, _, posture: HEIGHT * (directions[:, 0] > 0.0) * (posture == 1),
            id='a step in one pose',
        ),
        pytest.param(
            lambda directions, _, posture: HEIGHT * (-1.0) ** posture * (directions[:, 0] > 0.0),
            id='a step up and down by turns',
        ),
    ],
)
@pytest.mark.slow
def test_what_is_no_edge_in_the_picture_is_none(random, read):
    views = _views(random, read)
    for search in (straight_edge, round_edge):
        assert not is_there(views, search(views, is_fixed=True))
        assert not is_there(views, search(views, is_fixed=False))


def _beyond_an_edge(seen):
    """Return observations that read too far beyond an edge in the picture."""
    beyond = PictureEdge(TURN, 0.0).beyond(CAMERA.rays()[..., :2])
    return [replace(own, depth=(own.depth + HEIGHT * beyond).astype(np.float32)) for own in seen]


@pytest.fixture(scope='module')
def turned():
    """Return a scene of a beam that points elsewhere in each pose, and what is seen of it."""
    turns = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.5], [-0.1, 0.0, -0.45]])
    return rolled(turns, np.zeros((3, 6)), (8, 2, 2))


@pytest.mark.slow
def test_an_edge_that_a_camera_has_is_seen_beside_a_body_that_is_bent_for_it(turned):
    scene, seen = turned
    evaluator, nominal = fit_nominal(scene, _beyond_an_edge(seen), None)
    stated = evaluator.model.scene.effects['depth_affine']
    assert stated['edge_turn'] == pytest.approx(TURN, abs=np.deg2rad(4.0))
    assert stated['edge_at'] == pytest.approx(0.0, abs=0.005)
    beyond = next(c for c in candidates(evaluator.model.scene) if c.components == ('beyond',))
    model = try_effects(evaluator, nominal, [beyond], {})
    height = model.fit.values_by_name()['depth_affine.beyond']
    assert height == pytest.approx(HEIGHT, abs=0.0003)
    assert model.fit.chi_square_per_patch < 0.1 * nominal.chi_square_per_patch
    # It is looked for once.
    assert find_picture_edge(evaluator, nominal) is None


@pytest.mark.slow
def test_a_camera_that_has_none_sees_none(turned):
    evaluator, _ = fit_nominal(*turned, None)
    assert not evaluator.model.scene.effects


def test_settings_are_those_of_the_edge_seen():
    fixed = SeenEdge({0: PictureEdge(0.2, 0.1, 0.02), 1: PictureEdge(0.2, 0.1, 0.02)}, True)
    moved = SeenEdge({0: PictureEdge(0.2, 0.1), 2: PictureEdge(0.2, -0.3)}, False)
    scene = beam_scene()
    (own,) = with_edge(scene, fixed).effects.values()
    assert own == {'edge_turn': 0.2, 'edge_at': 0.1, 'edge_width': 0.02}
    curved = {number: replace(own, curve=-1.5) for number, own in fixed.edges.items()}
    (own,) = with_edge(scene, SeenEdge(curved, True)).effects.values()
    assert own == {'edge_turn': 0.2, 'edge_at': 0.1, 'edge_width': 0.02, 'edge_curve': -1.5}
    (own,) = with_edge(scene, moved).effects.values()
    assert own == {'edge_turn': 0.2, 'edge_width': 0.0, 'edge_at_1': 0.1, 'edge_at_3': -0.3}
