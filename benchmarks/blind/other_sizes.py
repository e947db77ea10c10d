# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make effects as large as they are to be seen, as a share of a body's free length."""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind.equilibrium import NoEquilibriumError
from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_camera, true_rendering
from benchmarks.blind.other_rigs import COARSE, OtherSetup, rests_of, UnfitError
from benchmarks.blind.renderer import Camera
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.thirtyfourth_forms import OtherForm

_SHARES = (0.015, 0.03, 0.08)  # Of the free length, by size.
_LEAST, _MOST = 0.0015, 0.025  # [m].
_NEAR_ENOUGH = 0.04
_ROUNDS = 7
_FEWER = 4  # Pixels along a side of an image in which depths are looked at.
_SEEN_QUANTILE = 0.99  # Of the pixels whose depth changes.
_ABOVE = 0.002  # By which all that is held stays above a plane [m].
_LEVEL = 0.5  # Sine of how steep a body may hang that is lifted.
_LIFTS, _LIFT_NEAR_ENOUGH = 4, 0.1
_CLEARANCE = 0.05  # Of a body that does not touch it, as a share of the free length.


def wanted_change(setup: OtherSetup, size: int) -> float:
    """Return by how much an effect of a size is to change what is seen at most [m]."""
    return float(np.clip(_SHARES[size] * setup.body.free, _LEAST, _MOST))


def sized(
    form: OtherForm, wanted: float, setup: OtherSetup, random: np.random.Generator
) -> tuple[dict[str, Any], float]:
    """Draw an effect that is to change what is seen by so much [m]; return its faults and change.

    Raises:
        UnfitError: where there is no rest.
    """
    drawn = form.draw(setup, random)
    specimen = make_specimen(setup, Faults(), COARSE)
    rests = rests_of(specimen, setup, Faults())
    factor, best, found = 1.0, 0.0, drawn
    for _ in range(_ROUNDS):
        tried = scaled(drawn, form.scaled, factor)
        try:
            change = largest_change(form, setup, tried, specimen, rests)
        except (NoEquilibriumError, ValueError):
            factor = 0.5 * (factor + best)
            continue
        found, best = tried, factor
        ratio = wanted / max(change, 1e-9)
        if abs(ratio - 1.0) < _NEAR_ENOUGH or (ratio > 1.0 and factor >= form.most):
            return found, change
        factor = min(factor * float(np.clip(ratio, 0.1, 8.0)), form.most)
    if best == 0.0:
        raise UnfitError('no rest with an effect')
    return found, largest_change(form, setup, found, specimen, rests)


def scaled(changes: dict[str, Any], names: tuple[str, ...], factor: float) -> dict[str, Any]:
    """Return faults of which some are by a factor larger, as they are told."""
    found = dict(changes)
    for name in names:
        value = changes[name]
        if isinstance(value, tuple):
            found[name] = tuple(float(f'{factor * part:.6g}') for part in value)
        else:
            found[name] = float(f'{factor * value:.6g}')
    return found


def largest_change(
    form: OtherForm,
    setup: OtherSetup,
    changes: dict[str, Any],
    specimen: Specimen,
    rests: list[FloatArray],
) -> float:
    """Return by how much an effect changes what is seen at most [m].

    Args:
        form: of it.
        setup: the rig.
        changes: its faults.
        specimen: the body without it.
        rests: where that rests in each pose, object frame [m].
    """
    faults = Faults(**changes)
    if form.seen_by == 'body':
        moved = rests_of(make_specimen(setup, faults, COARSE), setup, faults)
        moves = [np.linalg.norm(a - b, axis=1).max() for a, b in zip(moved, rests, strict=True)]
        return float(max(moves))
    found = 0.0
    for rest, view in zip(rests, setup.observations, strict=True):
        if form.seen_by == 'camera':
            points = applied(view.world_from_object, rest)
            seen = applied(true_camera(specimen, setup, faults), points)
            stored = applied(setup.depth_from_world, points)
            change = float(np.linalg.norm(seen - stored, axis=1).max())
        else:
            change = _change_of_depth(specimen, setup, view, faults, rest)
        found = max(found, change)
    return found


def smaller(camera: Camera) -> Camera:
    """Return a camera that sees the same in a quarter of the rows and columns."""
    return replace(
        camera,
        width=camera.width // _FEWER,
        height=camera.height // _FEWER,
        fx=camera.fx / _FEWER,
        fy=camera.fy / _FEWER,
        cx=camera.cx / _FEWER,
        cy=camera.cy / _FEWER,
    )


def _change_of_depth(
    specimen: Specimen, setup: OtherSetup, view: Observation, faults: Faults, rest: FloatArray
) -> float:
    """Return by how much depths are wrong in a pose, but for the worst of a hundred [m]."""
    small = replace(setup, camera=smaller(setup.camera))
    seen, right = (
        true_rendering(specimen, small, view, each, rest).depth[..., 4]
        for each in (faults, Faults())
    )
    is_there = np.isfinite(right)
    return float(np.quantile(np.abs(seen[is_there] - right[is_there]), _SEEN_QUANTILE))


def laid(
    setup: OtherSetup, changes: dict[str, Any], wanted: float, random: np.random.Generator
) -> tuple[OtherSetup, dict[str, Any], float]:
    """Put a plane below a body so that it lifts it by so much at first, maybe in two poses.

    Returns:
        The rig, whose bodies may stand higher or lower by that, the faults, and the change [m].

    Raises:
        UnfitError: where a body does not hang below what is held.
    """
    part = random.uniform(0.4, 0.8)
    lift = wanted
    for _ in range(_LIFTS):
        moved, found, change = _lifted(setup, changes, lift, part)
        if abs(change / wanted - 1.0) < _LIFT_NEAR_ENOUGH:
            break
        lift *= float(np.clip(wanted / change, 0.5, 1.6))
    return moved, found, change


def _lifted(
    setup: OtherSetup, changes: dict[str, Any], lift: float, part: float
) -> tuple[OtherSetup, dict[str, Any], float]:
    """Put a plane so that it goes by a lift [m] into where a body hung, by a part at second."""
    free = setup.body.free
    faults = Faults(**{**changes, 'contact_height': None})
    normal = np.array(faults.contact_normal)
    specimen = make_specimen(setup, faults, COARSE)
    rests = rests_of(specimen, setup, faults)
    lows, rooms, at_tip = _heights(setup, specimen, rests, normal)
    if not at_tip[0] or rooms[0] - lows[0] < lift + _ABOVE:
        raise UnfitError('the body does not hang low at first')
    height, views = lows[0] + lift, []
    for number, view in enumerate(setup.observations):
        up = 0.0
        is_level = abs(view.world_from_object[1, 0]) < _LEVEL
        if number == 1 and is_level and at_tip[1] and rooms[1] - lows[1] > lift + _ABOVE:
            up = height - part * lift - lows[1]
        elif number and lows[number] < height + _CLEARANCE * free:
            up = height + _CLEARANCE * free - lows[number]
        views.append(_raised(view, up / normal[1]))
    moved = replace(setup, observations=tuple(views))
    found = {**changes, 'contact_height': float(height)}
    try:
        lifted = rests_of(specimen, moved, Faults(**found))
    except NoEquilibriumError as error:
        raise UnfitError(str(error)) from error
    change = max(
        float(np.linalg.norm(a - b, axis=1).max()) for a, b in zip(lifted, rests, strict=True)
    )
    return moved, found, change


def _heights(
    setup: OtherSetup, specimen: Specimen, rests: list[FloatArray], normal: FloatArray
) -> tuple[list[float], list[float], list[bool]]:
    """Return how low a body hangs in each pose, how low by its clamp, whether with its tip.

    Heights are along a normal of the world [m].
    """
    lows, rooms, at_tip = [], [], []
    for rest, view in zip(rests, setup.observations, strict=True):
        heights = applied(view.world_from_object, rest) @ normal
        lows.append(float(heights.min()))
        rooms.append(float(heights[specimen.shares < 0.1].min()) - setup.rim)
        at_tip.append(bool(specimen.shares[heights.argmin()] > 0.5))
    return lows, rooms, at_tip


def _raised(view: Observation, up: float) -> Observation:
    """Return a pose that is higher in the world by a way [m], as it is stated, too."""
    shift = np.eye(4)
    shift[1, 3] = up
    stated = None if view.stated is None else shift @ view.stated
    return Observation(view.name, shift @ view.world_from_object, stated)
