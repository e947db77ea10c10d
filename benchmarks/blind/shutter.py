# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a camera sees of a body that moves while it looks."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import positions_at
from benchmarks.blind.interlacing import interlaced
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Camera, Rendering
from benchmarks.blind.rig_motion import rig_at
from benchmarks.blind.ripples import rippled
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.smoothing import smoothed
from benchmarks.blind.stamping import moments
from benchmarks.blind.timing import Timing

_ROLLS = 9  # Moments between which nodes of a rolling shutter's image are interpolated.
_EXPOSURES = 6  # Moments whose mean an exposure is.
_NEAR = 1e-3  # Between moments of which a rate is the difference [s].
_ROUNDS = 5  # Until a node's row and the moment at which that is read belong together.


def filmed_views(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults, timing: Timing
) -> list[Rendering]:
    """Return what every frame shows, without noise."""

    def seen(time: float, place: FloatArray, number: int) -> Rendering:
        there, since = rig_at(observation, faults, time), time + timing.release
        then = in_turn(drooped(warmed_up(faults, since), since), number)
        return true_rendering(specimen, setup, there, then, place)

    spread = _spread(faults)
    times = np.array(moments(timing, faults))[:, None] + spread
    found = positions_at(specimen, setup, observation, faults, timing, times.ravel())
    count, views = len(spread), []
    for number, around in enumerate(times):
        places = found[number * count : (number + 1) * count]
        one = _in_one(np.array(places), setup, observation, faults, number)
        if one is not None:
            places, around = [one], around[count // 2 : count // 2 + 1]
        shown = [seen(*each, number) for each in zip(around, places, strict=True)]
        views.append(_of_moments(shown, faults))
    return smoothed(views, faults.smoothing)


def _of_moments(shown: Sequence[Rendering], faults: Faults) -> Rendering:
    """Return the one image of what is seen at several moments."""
    if faults.rippled:
        return rippled(shown, _NEAR, faults)
    return interlaced(shown) if faults.stamps_form == 'interlaced' else averaged(shown)


def _in_one(
    places: FloatArray, setup: Setup, observation: Observation, faults: Faults, number: int
) -> FloatArray | None:
    """Return where nodes seem to be in a frame that is one image of several moments [m].

    None: it is the mean of images, or of one moment.
    """
    if faults.stamps_form == 'rolling':
        return rolled(places, setup, observation)
    if faults.stamps_form == 'swept':
        return swept(places, setup, observation, is_back=number % 2 == 1)
    return by_range_rate(places, setup, observation, faults) if faults.doppler else None


def _spread(faults: Faults) -> FloatArray:
    """Return the moments that a frame is made of, from its own one [s]."""
    half = 1e-3 * abs(faults.stamps_late)
    if faults.stamps_form in ('rolling', 'swept'):
        return np.linspace(-half, half, _ROLLS)
    if faults.stamps_form == 'interlaced':
        return np.array([-half, half])
    if faults.stamps_form == 'exposed':
        return half * ((2.0 * np.arange(_EXPOSURES) + 1.0) / _EXPOSURES - 1.0)
    return np.linspace(-_NEAR, _NEAR, 3) if faults.doppler or faults.rippled else np.zeros(1)


def warmed_up(faults: Faults, since: float) -> Faults:
    """Return faults as they are so long after the first frame [s], where a sensor warms up."""
    if faults.depth_form != 'switched on':
        return faults
    left = float(np.exp(-since / faults.depth_time))
    return replace(faults, depth_bias=left * faults.depth_bias)


def in_turn(faults: Faults, number: int) -> Faults:
    """Return faults as they are in one frame, where a sensor has two exposures in turn."""
    if faults.depth_form != 'in turn' or number % 2 == faults.depth_turn:
        return faults
    return replace(faults, depth_scale=0.0, depth_bias=0.0)


def drooped(faults: Faults, since: float) -> Faults:
    """Return faults as they are so long after the first frame [s], where a camera droops.

    What friction holds gives way by the logarithm of the time (Dieterich 1972, J. Geophys. Res.
    77): as much again in ten times as long.
    """
    if not faults.camera_hold:
        return faults
    share = float(np.log1p(max(since, 0.0) / faults.camera_hold) / np.log(10.0))
    x, y, z = faults.camera_turn
    return replace(faults, camera_turn=(share * x, share * y, share * z))


def by_range_rate(
    places: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return where nodes seem to be whose range errs by its rate, object frame [m], shape (N, 3).

    Args:
        places: of all nodes, a moment before, then and a moment after, shape (3, N, 3).
        setup: its camera.
        observation: the pose.
        faults: say by how much.
    """
    to_camera = setup.depth_from_world @ observation.world_from_object
    before, then, after = (applied(to_camera, place) for place in places)
    ranges = np.linalg.norm(then, axis=1)
    rates = (np.linalg.norm(after, axis=1) - np.linalg.norm(before, axis=1)) / (2.0 * _NEAR)
    seeming = (1.0 + 1e-3 * faults.doppler * rates / ranges)[:, None] * then
    return np.asarray((seeming - to_camera[:3, 3]) @ to_camera[:3, :3])


def rolled(places: FloatArray, setup: Setup, observation: Observation) -> FloatArray:
    """Return where each node is when its row is read, object frame [m], shape (N, 3).

    Args:
        places: of all nodes, at even moments from the first row to the last, shape (M, N, 3).
        setup: its camera.
        observation: the pose.
    """
    return _scanned(places, setup, observation, _read)


def swept(
    places: FloatArray, setup: Setup, observation: Observation, *, is_back: bool
) -> FloatArray:
    """Return where each node is when a beam comes by, object frame [m], shape (N, 3).

    A mirror sweeps that over the columns, to and fro as a spring lets it: one image from the left
    to the right, the next one back.

    Args:
        places: of all nodes, at even moments from one end to the other, shape (M, N, 3).
        setup: its camera.
        observation: the pose.
        is_back: whether the beam goes from the right to the left.
    """

    def passed(camera: Camera, points: FloatArray) -> FloatArray:
        gone = swept_share(camera, camera.project(points)[:, 0])
        return 1.0 - gone if is_back else gone

    return _scanned(places, setup, observation, passed)


def swept_share(camera: Camera, columns: FloatArray) -> FloatArray:
    """Return after which share of its way to the right a beam comes to columns, any shape."""
    across = np.clip(2.0 * columns / (camera.width - 1.0) - 1.0, -1.0, 1.0)
    return np.asarray(0.5 + np.arcsin(across) / np.pi)


def _scanned(
    places: FloatArray,
    setup: Setup,
    observation: Observation,
    read: Callable[[Camera, FloatArray], FloatArray],
) -> FloatArray:
    """Return where each node is when it is read, object frame [m], shape (N, 3).

    Args:
        places: of all nodes, at even moments, shape (M, N, 3).
        setup: its camera.
        observation: the pose.
        read: after which share of the time points of the camera's frame are.
    """
    to_camera = setup.depth_from_world @ observation.world_from_object
    last, nodes = len(places) - 1, np.arange(places.shape[1])
    seen = places[last // 2]
    for _ in range(_ROUNDS):
        when = last * read(setup.camera, applied(to_camera, seen))
        before = np.minimum(when.astype(np.int64), last - 1)
        part = (when - before)[:, None]
        seen = (1.0 - part) * places[before, nodes] + part * places[before + 1, nodes]
    return np.asarray(seen)


def _read(camera: Camera, points: FloatArray) -> FloatArray:
    """Return which share of all rows has been read where points are seen, shape (N,)."""
    rows = camera.project(points)[:, 1]
    return np.asarray(np.clip(rows / (camera.height - 1.0), 0.0, 1.0))


def averaged(views: Sequence[Rendering]) -> Rendering:
    """Return the mean depth of what most of some views see at each sample."""
    if len(views) == 1:
        return views[0]
    row, column = min(view.row for view in views), min(view.column for view in views)
    height = max(view.row + view.depth.shape[0] for view in views) - row
    width = max(view.column + view.depth.shape[1] for view in views) - column
    hits = np.zeros((height, width, views[0].depth.shape[2]))
    depth = np.zeros(hits.shape)
    labels, facing = np.full(hits.shape, -1), np.ones(hits.shape)
    for view in views:
        down, across = view.row - row, view.column - column
        there = slice(down, down + view.depth.shape[0])
        window = there, slice(across, across + view.depth.shape[1])
        is_hit = np.isfinite(view.depth)
        hits[window] += is_hit
        depth[window] += np.where(is_hit, view.depth, 0.0)
        labels[window] = np.where(is_hit, view.labels, labels[window])
        facing[window] = np.where(is_hit, view.facing, facing[window])
    is_seen = 2.0 * hits > len(views)
    mean = np.where(is_seen, depth / np.maximum(hits, 1.0), np.inf)
    return replace(
        views[0],
        row=row,
        column=column,
        depth=mean,
        labels=np.where(is_seen, labels, -1),
        facing=np.where(is_seen, facing, 1.0),
    )
