# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Put a body on what lies below it."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.contact import highest_tops, LONG, lowered, OUTER, ROUND
from benchmarks.blind.faults import Faults
from benchmarks.blind.knob import knob_tops
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import make_specimen, settle

_CLEARANCE = 0.008  # Of a body that does not touch the plane [m].
# What is placed by where the tip hangs.
_BELOW_TIP = ('dish', 'cushion', 'crate', 'flap', 'corrugated', 'tent', 'saddle', 'rim')
_KNOB_REACH = 0.08  # Half the share of the free length whose middle comes to lie over a knob.


def softer(setup: Setup, factor: float) -> Setup:
    """Return a set-up with a body whose true and first moduli are a factor of what they were."""
    return replace(
        setup,
        youngs_modulus=setup.youngs_modulus * factor,
        start_modulus=setup.start_modulus * factor,
    )


def lay_on_plane(
    setup: Setup, faults: Faults, random: np.random.Generator
) -> tuple[Setup, Faults]:
    """Put the plane under the body so that it lifts it in some poses and is free in others."""
    assert faults.contact_height is not None
    if faults.contact_form == 'rig':
        return _stopped_by_rig(setup, faults)
    if faults.contact_form == 'knob':
        return _stopped_by_knob(setup, faults)
    lift = 1e-3 * faults.contact_height
    normal = np.array(faults.contact_normal)
    if faults.contact_form == 'vee':
        faults = replace(faults, contact_at=_below_tip(setup, faults)[2])
    if faults.contact_form == 'pipe':
        aside = _below_tip(setup, faults)[2]
        faults = replace(faults, contact_at=aside + faults.contact_at)
    if faults.contact_form in _BELOW_TIP:
        ahead, _, aside = _below_tip(setup, faults)
        ahead, aside = ahead + faults.contact_ahead, aside + faults.contact_at
        faults = replace(faults, contact_ahead=ahead, contact_at=aside)
    if faults.contact_form in ROUND:
        faults = replace(faults, contact_at=_over_bar(setup, faults))
    lows, is_at_tip = _lowest_points(setup, faults, normal)
    while not is_at_tip:
        setup = softer(setup, 0.75)
        lows, is_at_tip = _lowest_points(setup, faults, normal)
    height = lows[0] + lift
    # The second and the last pose are free, the third is lifted by a part.
    lifts = [lift, -_CLEARANCE, lift * random.uniform(0.4, 0.8), -_CLEARANCE]
    moved = []
    for observation, low, wanted in zip(setup.observations, lows, lifts, strict=False):
        matrix = observation.world_from_object.copy()
        matrix[1, 3] += (height - wanted - low) / normal[1]
        moved.append(Observation(observation.name, matrix))
    return replace(setup, observations=tuple(moved)), replace(faults, contact_height=height)


def _stopped_by_rig(setup: Setup, faults: Faults) -> tuple[Setup, Faults]:
    """Put a stop of the rig so that it lifts the body in the first pose; others follow."""
    assert faults.contact_height is not None
    lift = 1e-3 * faults.contact_height
    normal = np.array(faults.contact_normal)
    free = replace(faults, contact_height=None)
    while True:
        specimen = make_specimen(setup, free)
        heights = settle(specimen, setup, setup.observations[0], free) @ normal
        low = float(heights.min())
        root = (specimen.mesh.nodes @ normal)[specimen.shares < 0.1]
        is_at_tip = specimen.shares[heights.argmin()] > 0.5
        if is_at_tip and float(root.min()) > low + lift + 0.001:
            return setup, replace(faults, contact_height=low + lift)
        setup = softer(setup, 0.75)


def _stopped_by_knob(setup: Setup, faults: Faults) -> tuple[Setup, Faults]:
    """Put the end of a screw so that it lifts the body in the first pose; others follow."""
    assert faults.contact_height is not None
    lift = 1e-3 * faults.contact_height
    free = replace(faults, contact_height=None)
    while True:
        specimen = make_specimen(setup, free)
        rest = settle(specimen, setup, setup.observations[0], free)
        over = rest[np.abs(specimen.shares - faults.contact_share) < _KNOB_REACH]
        ahead, aside = (float(place) for place in over.mean(axis=0)[:2])
        placed = replace(faults, contact_ahead=ahead, contact_at=aside)
        low = float(knob_tops(rest, placed).min())
        # A body that is not loaded must stay above it.
        if float(knob_tops(specimen.mesh.nodes, placed).min()) > low + lift + 0.001:
            return setup, replace(placed, contact_height=low + lift)
        setup = softer(setup, 0.75)


def _lowest_points(setup: Setup, faults: Faults, normal: FloatArray) -> tuple[list[float], bool]:
    """Return how low the free body hangs in each pose [m], and whether with its tip at first."""
    free = replace(faults, contact_height=None)
    specimen = make_specimen(setup, free)
    lows, shares = [], []
    for observation in setup.observations:
        rest = settle(specimen, setup, observation, free)
        world = applied(observation.world_from_object, rest)
        heights = highest_tops(world, faults) + lowered(specimen.shares, faults)
        lows.append(float(heights.min()))
        shares.append(specimen.shares[heights.argmin()])
    # With room for the lift: what is at the root must stay above the plane.
    placed = applied(setup.observations[0].world_from_object, specimen.mesh.nodes)
    root = highest_tops(placed, faults)
    lift = 1e-3 * (faults.contact_height or 0.0)
    is_clear = float(root[specimen.shares < 0.1].min()) > lows[0] + lift + 0.001
    # A bar, or a block, lies under a part of the body that is not at the root; others are long.
    is_long = faults.contact_form in LONG
    clear = is_clear or (faults.contact_form in (*ROUND, *OUTER) and not is_long)
    return lows, bool(shares[0] > 0.5) and clear


def _below_tip(setup: Setup, faults: Faults) -> list[float]:
    """Return where in the world the tip hangs below which something is to lie [m]."""
    free = replace(faults, contact_height=None)
    specimen, observation = make_specimen(setup, free), setup.observations[0]
    rest = settle(specimen, setup, observation, free)
    places = applied(observation.world_from_object, rest)[specimen.shares > 0.95]
    return [float(place.mean()) for place in places.T]


def _over_bar(setup: Setup, faults: Faults) -> float:
    """Return where along the world's x the part of the body hangs that is to lie on a bar [m]."""
    free = replace(faults, contact_height=None)
    specimen, observation = make_specimen(setup, free), setup.observations[0]
    rest = settle(specimen, setup, observation, free)
    places = applied(observation.world_from_object, rest)[:, 0]
    order = np.argsort(specimen.shares)
    return float(np.interp(faults.contact_share, specimen.shares[order], places[order]))
