# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A robot's base may be metres from the body, a map's origin a kilometre: no fit follows that."""

from dataclasses import replace
from functools import cache

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.rigid_motion import upwards
from diffcal_ros.rigid_transform import transform
from diffcal_ros.scene.model import HeldPart, Turn
import numpy as np
import pytest
from support.far_worlds import DISTANCES, moved_scene, moved_views, shift_by, TURN
from support.moving_beams import instants, moving_scene
from support.scenes import beam_scene, GRAVITY, MODULUS, observation, SIZE, true_depth

# Of a fitted modulus; of points [m] and, relative, of their derivatives.
_MODULUS, _POINTS, _SLOPES = 1e-6, 1e-10, 1e-6
_SETTINGS = CalibrationSettings(with_mesh_error=False, max_iterations=6)
_COUNTS = (4, 2, 1)
_SMALL = PinholeCamera(120, 90, 131.0, 137.0, 56.5, 48.25)
_BODY = ('youngs_modulus', 'clamp_offset', 'added_mass', 'rest_curvature', 'rigid_offset')
_TIMES = (0.02, 0.08, 0.15)


def _away(parameters) -> np.ndarray:
    here = parameters.start()
    for place, parameter in enumerate(parameters):
        if parameter.component is not None:
            here[place] = 0.3 * parameter.component.scale
        elif parameter.axis or 'tilt' in parameter.name:
            here[place] = 0.02
        if parameter.name == 'contact_plane.height':
            here[place] = -0.045
    return here


def _rise(move: np.ndarray) -> float:
    """Return how much higher everything is after a move of the world [m]."""
    return float(upwards(GRAVITY) @ move[:3, 3])


def _with_turned_end(scene):
    """Let a second clamp turn the far end about an axis that is somewhere in the world."""
    (setup,) = scene.observations
    far = np.flatnonzero(scene.mesh.rest_positions[:, 0] > SIZE[0] - 1e-9).astype(np.int32)
    turn = Turn(np.array([0.6, 0.0, 0.8]), 0.1, np.array([0.08, 0.01, 0.02]), np.full(3, 0.001))
    held = (*setup.held, HeldPart('far', far, turn))
    return replace(scene, observations=(replace(setup, held=held),))


def _asked(scene, seen, coordinates) -> tuple[list, list, np.ndarray]:
    """Return points, their tangents and one adjoint."""
    parameters = make_parameters(scene, with_edge_bias=False)
    model = ForwardModel(scene, seen, parameters)
    tangents = model.tangents(coordinates)
    at_rest = seen[0].instant is None  # No motion's adjoint knows effects.
    points = [view.points for view in model.views(coordinates)]
    weights = [(np.arange(p.size).reshape(p.shape) % 5).astype(float) for p in points]
    return points, tangents, model.pull_back(weights, coordinates) if at_rest else np.zeros(0)


def _assert_same(found, expected) -> None:
    for ours, theirs in zip(found[0], expected[0], strict=True):
        np.testing.assert_allclose(ours, theirs, atol=_POINTS)
    for ours, theirs in zip(found[1], expected[1], strict=True):
        sizes = np.maximum(np.abs(theirs).max(axis=(1, 2), keepdims=True), 1e-12)
        np.testing.assert_allclose(ours / sizes, theirs / sizes, atol=_SLOPES)
    np.testing.assert_allclose(found[2], expected[2], rtol=_SLOPES, atol=1e-9)


@pytest.mark.parametrize('distance', DISTANCES)
def test_a_clamp_that_turns_does_not_follow_the_origin(distance) -> None:
    scene, seen = _with_turned_end(beam_scene(_COUNTS, fit=_BODY)), [_seen()]
    here = _away(make_parameters(scene, with_edge_bias=False))
    move = shift_by(distance)
    moved = moved_scene(scene, move), moved_views(seen, move)
    _assert_same(_asked(*moved, here), _asked(scene, seen, here))


@pytest.mark.parametrize('distance', DISTANCES)
def test_a_plane_does_not_follow_the_origin(distance) -> None:
    fit = (*_BODY, 'gravity_tilt', 'contact_plane.height')
    scene, seen = beam_scene(_COUNTS, fit=fit), [_seen()]
    parameters = make_parameters(scene, with_edge_bias=False)
    here, move = _away(parameters), shift_by(distance)
    there = here.copy()
    there[parameters.names.index('contact_plane.height')] += _rise(move)
    moved = moved_scene(scene, move), moved_views(seen, move)
    _assert_same(_asked(*moved, there), _asked(scene, seen, here))


def test_a_plane_tilts_about_the_body_and_not_about_an_origin_far_away() -> None:
    scene, seen = beam_scene(_COUNTS, fit=('contact_plane',)), [_seen()]
    parameters = make_parameters(scene, with_edge_bias=False)
    points = []
    for distance in (2.0, 90.0):
        move = shift_by(distance)
        here = np.array([-0.045 + _rise(move), 0.05, -0.08])
        model = ForwardModel(moved_scene(scene, move), moved_views(seen, move), parameters)
        tangents = model.tangents(here)[0]
        points.append(model.views(here)[0].points)
        for place in (1, 2):
            step = 1e-4 * np.eye(3)[place]
            ahead, behind = (model.views(here + s * step)[0].points for s in (1.0, -1.0))
            slope = (ahead - behind) / 2e-4
            assert np.linalg.norm(slope - tangents[place]) < 2e-3 * np.linalg.norm(slope)
    # The points that it tilts about differ by up to a millimetre, the body by that times the tilt.
    np.testing.assert_allclose(points[1], points[0], atol=2e-4)


def test_points_and_slopes_do_not_follow_the_worlds_axes() -> None:
    scene, seen = beam_scene(_COUNTS, fit=_BODY), [_seen()]
    here = _away(make_parameters(scene, with_edge_bias=False))
    move = shift_by(50.0) @ transform(TURN, np.zeros(3))
    moved = moved_scene(scene, move), moved_views(seen, move)
    _assert_same(_asked(*moved, here), _asked(scene, seen, here))


@pytest.mark.parametrize('distance', DISTANCES)
@pytest.mark.slow_but_first
def test_a_motion_does_not_follow_the_origin(distance) -> None:
    fit = ('youngs_modulus', 'damping', 'clamp_offset', 'release_time', 'rigid_offset')
    fit = (*fit, 'compliant_clamp.compliance')
    scene = moving_scene((4, 1, 1), fit=fit)
    seen = instants(_TIMES, [np.full((1, 1), np.nan)] * len(_TIMES))
    here = _away(make_parameters(scene, with_edge_bias=False))
    move = shift_by(distance)
    moved = moved_scene(scene, move), moved_views(seen, move)
    _assert_same(_asked(*moved, here), _asked(scene, seen, here))


@cache
def _seen(modulus: float = MODULUS):
    depth = true_depth(modulus, counts=_COUNTS, camera=_SMALL)
    return observation(np.where(np.isnan(depth), 0.9, depth), camera=_SMALL)


def _calibration(distance: float, mesh_origin: float, fit, settings) -> Calibration:
    """Prepare a fit of one view; the mesh's own origin may be far from the body, too."""
    scene = beam_scene(_COUNTS, modulus=50e3, fit=fit)
    seen = replace(_seen(), pose_covariance=np.diag([1e-6] * 3 + [1e-5] * 3))
    off = shift_by(mesh_origin)[:3, 3]
    (setup,) = scene.observations
    setup = replace(setup, world_from_object=setup.world_from_object @ shift_by(-mesh_origin))
    mesh = replace(scene.mesh, rest_positions=scene.mesh.rest_positions + off)
    scene = replace(scene, mesh=mesh, observations=(setup,))
    move = shift_by(distance)
    return Calibration(moved_scene(scene, move), moved_views([seen], move), settings)


@pytest.mark.parametrize('search', [True, False])
@pytest.mark.slow_but_first
def test_the_same_modulus_is_calibrated(search) -> None:
    fit = ('youngs_modulus', 'rigid_offset') if search else ('youngs_modulus',)
    settings = replace(_SETTINGS, search=search, with_mesh_error=not search)
    places = [(0.0, 0.0), (1000.0, 0.0)] if search else [(0.0, 0.0), (2.0, 0.0), (10.0, 30.0)]
    results = [_calibration(*place, fit, settings).run() for place in places]
    first, *others = (result['youngs_modulus'] for result in results)
    for other in others:
        assert other.value == pytest.approx(first.value, rel=_MODULUS)
        assert other.std_error == pytest.approx(first.std_error, rel=1e-4)


def test_the_tracker_follows_the_same_modulus(random) -> None:
    noise = random.normal(scale=1e-4, size=_seen().depth.shape)
    depths = [_seen(factor * MODULUS).depth + noise for factor in (1.0, 1.02, 1.04)]
    found = []
    for distance in (0.0, 1000.0):
        calibration = _calibration(distance, 0.0, ('youngs_modulus',), _SETTINGS)
        tracker = Tracker(calibration, calibration.run().parameters)
        for number, depth in enumerate(depths):
            frame = DepthFrame(depth.astype(np.float32), 33_000_000 * (number + 1), 'camera')
            told = tracker.follow(frame)
        found.append(told.values()['youngs_modulus'])
    assert found[1] == pytest.approx(found[0], rel=_MODULUS)
