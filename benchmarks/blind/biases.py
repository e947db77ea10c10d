# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How an error of depth varies over an image and from pose to pose."""

import numpy as np

from benchmarks.blind.bounce import bounced_share
from benchmarks.blind.breath import breath_share
from benchmarks.blind.dented_window import dented_share
from benchmarks.blind.exposure import exposure, returned_light
from benchmarks.blind.faults import Faults
from benchmarks.blind.flare import flared_share
from benchmarks.blind.glued_window import glued_share
from benchmarks.blind.guard import guard_share
from benchmarks.blind.peeling import film_share
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.sealed_window import bulged_share
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.shifted_bar import shifted_share
from benchmarks.blind.sunbeam import sunbeam_share
from benchmarks.blind.taps import tap_share
from benchmarks.blind.veil import veiled
from benchmarks.blind.wiping import wiped_share

_UPPER = 0.25  # Share of the image's height over which an error of rows falls to a third.
_NEAR = 0.1  # Of depth over which an error of the near field falls to a third [m].
# Errors that lie elsewhere in an image in each pose.
_IN_POSES = {'sunbeam': sunbeam_share, 'peeling': film_share, 'breath': breath_share}
# Those that are the same in all, by place alone.
_IN_IMAGE = {
    'splash guard': guard_share,
    'two taps': tap_share,
    'shifted bar': shifted_share,
    'glued window': glued_share,
    'wiped': wiped_share,
    'sealed window': bulged_share,
    'dented window': dented_share,
}
# Errors that go with how far away a surface is, and how bright with that.
_BY_DISTANCE = ('near field', 'walk', 'veil', 'saturated', 'two gains', 'bounced')


def bias_share(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return how much of the error of depth is there, pixel by pixel, shape (h, w, 1)."""
    height, width = rendering.depth.shape[:2]
    if faults.depth_form in ('radial', 'smudge', 'warped'):
        return _share_around(rendering, setup, faults)
    if faults.depth_form in _IN_POSES:
        return _IN_POSES[faults.depth_form](rendering, setup, observation, faults)
    if faults.depth_form in _IN_IMAGE:
        return _IN_IMAGE[faults.depth_form](rendering, setup, faults)
    if faults.depth_form == 'flared':
        return flared_share(rendering, faults.depth_width)
    if faults.depth_form == 'disparity':
        return _squared_depth(rendering, setup)
    if faults.depth_form == 'toed':
        rows = (rendering.row + np.arange(height) - setup.camera.cy) / (0.5 * setup.camera.height)
        by_row = (1.0 + faults.depth_roll * rows)[:, None, None]
        return by_row * _squared_depth(rendering, setup)
    if faults.depth_form == 'incidence':
        return np.asarray(1.0 / np.maximum(rendering.facing, 1.0 / 3.0))
    if faults.depth_form in _BY_DISTANCE:
        return _share_by_distance(rendering, setup, faults)
    if faults.depth_form == 'entry':
        seen = np.where(np.isfinite(rendering.depth), rendering.depth, faults.depth_entry)
        away = np.abs(seen - faults.depth_entry) / faults.depth_spacing
        return np.asarray(np.maximum(1.0 - away, 0.0))
    if faults.depth_form == 'upper rows':
        # In the image's middle it is all there.
        rows = rendering.row + np.arange(height) - setup.camera.cy
        by_row = np.exp(-rows / (_UPPER * setup.camera.height))
        return np.broadcast_to(by_row[:, None], (height, width))[..., None]
    if faults.depth_form == 'ramp':
        columns = rendering.column + np.arange(width) - setup.camera.cx
        return np.broadcast_to(0.7 + columns / setup.camera.width, (height, width))[..., None]
    share = _share_of_pose(rendering, setup, observation, faults)
    return np.full((height, width, 1), share)


def _share_of_pose(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> float:
    """Return how much of an error of depth there is that is the same all over an image."""
    if faults.depth_form == 'exposed':
        return exposure(rendering, float(np.linalg.norm(setup.depth_from_world[:3, 3])))
    if faults.depth_form == 'restarted':
        return faults.depth_shares[setup.pose_number(observation)]
    if faults.depth_form == 'settling':
        return float(0.7 ** setup.pose_number(observation))
    if faults.depth_form == 'drift':
        return setup.reached(observation)
    if faults.depth_form == 'temperature':
        through = (setup.pose_number(observation) + 0.5) / len(setup.observations)
        return float(np.sin(np.pi * through))
    return 1.0


def _share_around(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much there is of an error that goes with the way from a pixel, (h, w, 1)."""
    height, width = rendering.depth.shape[:2]
    across, down = faults.depth_spot
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    if faults.depth_form == 'warped':
        angle = 2.0 * np.deg2rad(faults.depth_slant)
        saddle = np.cos(angle) * (columns**2 - rows**2) + 2.0 * np.sin(angle) * columns * rows
        return np.asarray(saddle / faults.depth_width**2)[..., None]
    squares = (rows**2 + columns**2)[..., None]
    if faults.depth_form == 'smudge':
        return np.asarray(np.exp(-squares / faults.depth_width**2))
    # One half of the image's height away it is all there.
    return np.asarray(squares / (0.5 * setup.camera.height) ** 2)


def _squared_depth(rendering: Rendering, setup: Setup) -> FloatArray:
    """Return how much there is of an error of disparity, about all at the body, (h, w, 9)."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    seen = np.where(np.isfinite(rendering.depth), rendering.depth, 0.0)
    return np.asarray((seen / distance) ** 2)


def _share_by_distance(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of an error of depth is there that is stated where the camera looks."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    seen = np.where(np.isfinite(rendering.depth), rendering.depth, distance)
    if faults.depth_form == 'near field':
        return np.asarray(np.exp((distance - seen) / _NEAR))
    if faults.depth_form == 'bounced':
        return bounced_share(rendering, setup, faults.depth_point)
    # The others are stated of what is met squarely.
    if faults.depth_form == 'veil':
        errors = veiled(seen, rendering.facing, distance, faults)
        return np.asarray(errors / (1e-3 * faults.depth_bias))
    light = returned_light(rendering, distance)
    if faults.depth_form == 'saturated':
        return np.asarray(np.maximum(light - faults.depth_full, 0.0) / (1.0 - faults.depth_full))
    if faults.depth_form == 'two gains':
        beyond = (light - faults.depth_full) / faults.depth_blend
        return np.asarray(0.5 * (1.0 + np.tanh(beyond)))
    return np.asarray(1.0 - np.log(light))
