# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pose is fitted from near, with derivatives and a covariance that are right."""

from diffcal_ros.calibration.residuals.robust_residual import Reach
from diffcal_ros.registration.rigid_fit import approach, moved_pose, settle
from diffcal_ros.registration.rigid_view import RigidImage
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Masks
import numpy as np
import pytest
from scipy.spatial import cKDTree

from .conftest import CAMERA

OFF = np.array([0.004, -0.003, 0.005, 0.06, -0.05, 0.08])
REACH = Reach(0.05, 0.02, 8)


def image_of(made) -> RigidImage:
    return RigidImage(made.fixture, made.depth, CAMERA, Masks())


def by_pixel(sights) -> dict:
    return {tuple(own): number for number, own in enumerate(sights.pixels[0].astype(int).tolist())}


@pytest.mark.parametrize('axis', range(6))
def test_depth_follows_the_pose_as_finite_differences_say(picture, axis):
    made = picture('bracket', seed=3, has_body=False)
    image = image_of(made)
    pose = moved_pose(made.truth, OFF, image.pivot)
    here = image.sights(pose, REACH, is_final=True)
    worst = []
    for size in (1e-3, 1e-4, 1e-5):
        step = size * np.eye(6)[axis]
        ahead, behind = (
            image.sights(moved_pose(pose, sign * step, image.pivot), REACH, is_final=True)
            for sign in (1.0, -1.0)
        )
        places = [by_pixel(own) for own in (here, ahead, behind)]
        shared = sorted(set(places[0]) & set(places[1]) & set(places[2]))
        rows = [np.array([own[pixel] for pixel in shared]) for own in places]
        found = -(ahead.values[0][rows[1]] - behind.values[0][rows[2]]) / (2.0 * size)
        said = here.jacobian[0][rows[0], axis]
        # A pixel on a crease changes its face.
        worst.append(np.quantile(np.abs(found - said), 0.9) / np.abs(said).max())
    assert len(shared) > 500
    assert worst[1] < 0.05 * worst[0] + 1e-7
    assert worst[2] < 1e-5


@pytest.mark.parametrize('axis', range(6))
def test_the_outline_follows_the_pose_to_first_order(picture, axis):
    """Moved along its normals by what the derivative says, it lies on the outline moved."""
    made = picture('block', seed=4, has_body=False)
    image = image_of(made)
    here = image.view(made.truth)
    outline = here.trace.outline
    middle = apply(made.truth, image.pivot)
    rates = here.trace.push_outline(outline.segments, image.tangents(here.points, middle))
    missed = []
    for size in (1e-2, 1e-3, 1e-4):
        pose = moved_pose(made.truth, size * np.eye(6)[axis], image.pivot)
        moved = image.view(pose).trace.outline
        told = outline.points[:, :2] + size * rates[:, axis, None] * outline.normals
        _, near = cKDTree(moved.points[:, :2]).query(told)
        beside = ((told - moved.points[near, :2]) * moved.normals[near]).sum(axis=1)
        # At corners the nearest piece may be of the other edge.
        missed.append(np.quantile(np.abs(beside), 0.9) / (size * np.abs(rates[:, axis]).max()))
    assert missed[1] < 0.2 * missed[0] + 1e-6
    assert missed[2] < 0.2 * missed[1] + 1e-6


@pytest.mark.parametrize('name', ['bracket', 'clamp', 'block'])
def test_a_pose_that_is_off_is_found_again(picture, name):
    made = picture(name, seed=5, has_body=False)
    image = image_of(made)
    near = approach(image, moved_pose(made.truth, OFF, image.pivot))
    fit = settle(image, near)
    shift, turn = made.error(fit.depth_from_object)
    assert shift < 3e-4
    assert turn < np.deg2rad(0.3)
    spread = np.sqrt(np.diag(fit.covariance))
    assert (spread[:3] > 3e-5).all()
    assert (spread[:3] < 1e-3).all()


def test_a_sensors_smooth_error_is_not_averaged_away(picture):
    """Beside 0.05 mm of noise a sensor's smooth error leaves depth unsure by a tenth or more."""
    made = picture('block', seed=5, has_body=False)
    fit = settle(image_of(made), made.truth)
    along = fit.depth_from_object[:3, 3] / np.linalg.norm(fit.depth_from_object[:3, 3])
    assert float(along @ fit.covariance[:3, :3] @ along) > 1e-4**2
    white = fit.noise**2 / fit.pixels
    assert float(along @ fit.covariance[:3, :3] @ along) > 100.0 * white


@pytest.mark.slow
def test_errors_are_as_large_as_their_covariance_says(picture):
    """With a smooth error of 0.3 mm over 80 px and noise; the benchmark has the full count."""
    squared = []
    made = picture('bracket', seed=8, has_body=False)
    for seed in range(8):
        random = np.random.default_rng(seed)
        phases = random.uniform(0.0, 2.0 * np.pi, 40)
        # Random waves whose covariance is the Gaussian one of length 80 px.
        waves = random.normal(0.0, np.sqrt(2.0) / 80.0, (40, 2))
        rows, columns = np.indices(made.depth.shape)
        field = sum(
            np.cos(wave[0] * columns + wave[1] * rows + phase)
            for wave, phase in zip(waves, phases, strict=True)
        )
        depth = made.depth + (3e-4 * np.sqrt(2.0 / 40.0) * field).astype(np.float32)
        image = RigidImage(made.fixture, depth, CAMERA, Masks())
        fit = settle(image, made.truth)
        middle = fit.depth_from_object[:3, :3] @ image.pivot + fit.depth_from_object[:3, 3]
        squared.append(made.squared(fit.depth_from_object, fit.covariance, middle))
    assert 1.0 < np.mean(squared) < 12.0


def test_nothing_in_view_is_no_fit(picture):
    made = picture('block', seed=5, has_body=False)
    away = made.truth.copy()
    away[0, 3] += 3.0
    assert approach(image_of(made), away) is None
    assert settle(image_of(made), away) is None
