# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How stiff a body is from place to place."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.baking import baked_value
from benchmarks.blind.dosing import dosed_value
from benchmarks.blind.faults import Faults
from benchmarks.blind.frothing import froth_share
from benchmarks.blind.heat_gun import gun_heat
from benchmarks.blind.marbling import marbled_value
from benchmarks.blind.motor_heat import heated_share
from benchmarks.blind.seeping import seeped_share
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.sheets import sheet_value
from benchmarks.blind.surging import surged_value

_JAW = 0.15  # Share of the free length over which a soft root gives way.
_TORN = 0.05  # Half the share of the free length of a torn piece.
DECAY = 0.2  # Share of the free length over which what comes from the clamp falls to a third.
_CORE = 0.5  # Share of width and height of a tube that is cast in.
_LAMP = 0.15  # Share of the free length over which a lamp's light falls to a half.
_MIXED = 0.3  # Of half the width, over which two pours mix where their border lies aslant.
_PLUG_SKIN = 0.2  # Share of the half section over which a plug's rubber goes over to a body's.
_CAVITY = 5.0  # By which log E falls where there is no matter.
PARTED = 5.5  # The same where two halves hardly hold together.
SEAM_LAYERS = 5  # Cells over the height of such a body, of which that is the one in the middle.


def log_modulus(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return the change of log E at the Gauss points, shape (C, 8)."""
    section = np.array(setup.shape.section)[:, None, None]
    outward = np.abs(points[:, 1:]) / (0.5 * np.array(setup.shape.section)[:, None])
    mode = {
        'split': np.where(share > 0.5, 0.5, -0.5),
        'linear': share - 0.5,
        'smooth': 0.5 * np.tanh((share - 0.4) / 0.15),
        'thirds': np.where(np.abs(share - 0.5) < 1.0 / 6.0, 0.5, -0.5),
        'skin': np.where(outward.max(axis=1) > 0.6, 0.5, -0.5),
        'cosine': -0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0)),
        'late': np.where(share > 0.7, 0.5, -0.5),
        'square': np.clip(share, 0.0, 1.0) ** 2 - 0.5,
        'spot': (np.abs(share - 0.3) < 0.1).astype(float),
        'three pours': np.where(share > 0.6, 0.5, np.where(share > 0.25, 0.1, -0.5)),
        'decaying': -np.exp(-share / DECAY),
        'lamp': lamp_light(share, faults.contrast_at),
        'slanted': np.where(share > _border(setup, faults, points), 0.5, -0.5),
        'patched': _patch(faults, share, points),
        'streaky': np.sin(2.0 * np.pi * _aslant(setup, faults, share, points)),
        'plugged': plug_share(share, outward.max(axis=1), faults.contrast_at),
        'settled': settled_share(share, faults.contrast_at),
        'foil': on_foil(setup, faults, share, points),
        'overbent': overbent_share(
            share, 2.0 * points[:, 2] / setup.shape.section[1], faults.contrast_at
        ),
        'soaked': _soaked(setup, faults, share, points),
        'edged': edge_share(*(2.0 * points[:, 1:].swapaxes(0, 1) / section)),
        'wedged': _wedged(setup, faults, share, points),
        'ribbon': ribbon_share(share, *(2.0 * points[:, 1:].swapaxes(0, 1) / section), faults),
        'gated': gate_share(share, faults.contrast_at),
        'baked': baked_value(share, faults.contrast_at, faults.contrast_width),
        'dosed': dosed_value(share, faults.contrast_at, faults.contrast_wave),
        'surged': surged_value(share, faults.contrast_wave, faults.contrast_width),
        'seeped': seeped_share(share, faults.contrast_width),
        # In the first pose; each tells how far heat has come, and what a gun's has become.
        'motor heat': heated_share(share, faults.contrast_width, 0),
        'heat gun': gun_heat(share, faults, 0),
        'rolled sheets': sheet_value(share, faults.contrast_sheets),
        'frothed': froth_share(share, 2.0 * points[:, 2] / setup.shape.section[1]),
        'creased': crease_share(share, faults.contrast_creases, faults.contrast_width),
        'pours': pour_value(share, faults.contrast_pours),
        'marbled': _marbled(setup, faults, share, points),
        'cored': (in_core(setup, points) & (share < faults.contrast_at)).astype(float),
        'sleeve': -((outward.max(axis=1) > 0.6) & (share < 0.4)).astype(float),
    }[faults.contrast_mode]
    change = faults.contrast * mode
    if faults.clamp_form == 'jaw':
        # A root that is softer by as much as the clamp gives way.
        change = change - faults.clamp_compliance * (share < _JAW)
    height = points[:, 2] / (0.5 * setup.shape.section[1])
    change = change + (faults.soft_skin + np.log1p(-faults.crazed)) * (height > 0.5)
    if faults.torn:
        change = change - 3.0 * _torn(faults, share, height)
    if faults.unglued:
        change = change - PARTED * on_seam(share, height, 1.0 - faults.unglued)
    if faults.hollow:
        change = change - _CAVITY * cavity(setup, faults, share, points)
    return change


def lamp_light(share: FloatArray, at: float) -> FloatArray:
    """Return a lamp's light by the square of the distance, 1 below it.

    Args:
        share: of the free length, any shape.
        at: share above which it stands, as high as `_LAMP`.
    """
    return np.asarray(1.0 / (1.0 + ((share - at) / _LAMP) ** 2))


def plug_share(share: FloatArray, outward: FloatArray, end: float) -> FloatArray:
    """Return which places lie in a cone that fills a body at its clamp: 1, 0, or a part near it.

    Args:
        share: of the free length, any shape.
        outward: 0 in the section's middle and 1 at its surface, the same shape.
        end: share at which the cone comes to its point.
    """
    radius = 1.0 - share / max(end, 1e-9)
    # Over a fifth of the half section: Gauss points are few, and rubber creeps into a plug's skin.
    return np.asarray(np.clip(0.5 + (radius - outward) / _PLUG_SKIN, 0.0, 1.0) * (radius > 0.0))


def settled_share(share: FloatArray, end: float) -> FloatArray:
    """Return how much settled at places of a mould that stood on its clamp's end, 1 at the clamp.

    It falls evenly to where the rubber is clear, as that of grains of all sizes does.

    Args:
        share: of the free length, any shape.
        end: share from which on there is nothing.
    """
    return np.asarray(np.maximum(1.0 - share / max(end, 1e-9), 0.0))


def overbent_share(share: FloatArray, height: FloatArray, at: float) -> FloatArray:
    """Return how much a body was strained that was bent over something, 1 on its faces there.

    Its moment fell evenly to where it was held, at the clamp and the tip, and strain goes with
    the distance from the middle of the height.

    Args:
        share: of the free length, any shape.
        height: -1 at the lower face and 1 at the upper one, that shape.
        at: share where it was bent most; 0: nowhere.
    """
    if not at:
        return np.zeros(np.shape(share))
    moment = np.minimum(share / at, (1.0 - share) / (1.0 - at))
    return np.asarray(np.maximum(moment, 0.0) * np.abs(height))


def soaked_share(share: FloatArray, below: FloatArray, at: float, depth: float) -> FloatArray:
    """Return how much of an oil is in a body that was dipped into it, 1 at its surface.

    Args:
        share: of the free length, any shape.
        below: how far below the nearest side places lie [m], that shape.
        at: share from which on, to the tip, it was dipped.
        depth: over which there is a third as much [m].
    """
    return np.asarray(np.exp(-np.maximum(below, 0.0) / depth) * (share > at))


def crease_share(share: FloatArray, creases: tuple[float, ...], width: float) -> FloatArray:
    """Return how much a body suffered that was folded, 1 amid a crease.

    Args:
        share: of the free length, any shape.
        creases: shares at which it was folded; each adds to the others.
        width: share over which that falls to a third on either side.
    """
    away = (np.asarray(share)[..., None] - np.array(creases)) / width
    return np.asarray(np.exp(-(away**2)).sum(axis=-1))


def edge_share(across: FloatArray, height: FloatArray) -> FloatArray:
    """Return how little a mould let a body cure, 1 on its four long edges, where two walls meet.

    It goes with the places along both: on the middle of a side there is none of it.

    Args:
        across: -1 and 1 at the sides, any shape; beyond, of a crossbar, as there.
        height: -1 at the lower face and 1 at the upper one, that shape.
    """
    return np.asarray(np.minimum(np.abs(across), 1.0) * np.minimum(np.abs(height), 1.0))


def wedge_value(share: FloatArray, across: FloatArray, begin: float, until: float) -> FloatArray:
    """Return in which of two pours places lie, -1/2 in the one at the clamp, 1/2 in the other.

    Their border goes from the side where `across` is 1 to the other one, as the mould stood aslant
    on its side when the first was poured; beside it they mixed.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides, that shape.
        begin: share at which the border begins, on the one side.
        until: share at which it comes to the other one.
    """
    border = 1.0 - 2.0 * (share - begin) / (until - begin)
    return np.asarray(np.clip((across - border) / _MIXED, -0.5, 0.5))


def ribbon_share(
    share: FloatArray, across: FloatArray, height: FloatArray, faults: Faults
) -> FloatArray:
    """Return how much of another rubber is there that was poured as a ribbon, 0 to 1.

    It winds around a body's length like the stripe of a candy cane: by the cosine of the angle
    about that between a place and where the ribbon is.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides, that shape.
        height: -1 at the lower face and 1 at the upper one, that shape.
        faults: say how long a turn is, where the ribbon is at the side of positive y, and which
            way it winds.
    """
    wound = 2.0 * np.pi * (share - faults.contrast_at) / faults.contrast_wave
    around = np.arctan2(height, across)
    return np.asarray(0.5 * (1.0 + np.cos(around - faults.contrast_side * wound)))


def gate_share(share: FloatArray, at: float) -> FloatArray:
    """Return how far places are from the gate through which a mould was filled, 1 where farthest.

    Rubber that flowed on for longer had set the more, and healed the less where it came together.

    Args:
        share: of the free length, any shape.
        at: that of the gate.
    """
    return np.asarray(np.abs(share - at) / max(at, 1.0 - at))


def _wedged(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return in which of two pours Gauss points lie, shape (C, 8)."""
    if faults.contrast_until <= faults.contrast_at:
        return np.zeros(share.shape)
    across = faults.contrast_side * points[:, 1] / (0.5 * setup.shape.section[0])
    return wedge_value(share, across, faults.contrast_at, faults.contrast_until)


def _soaked(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return how much oil is at Gauss points, shape (C, 8)."""
    half = 0.5 * np.array(setup.shape.section)[:, None]
    below = (half - np.abs(points[:, 1:])).min(axis=1)
    return soaked_share(share, below, faults.contrast_at, faults.contrast_depth)


def pour_value(share: FloatArray, values: tuple[float, ...]) -> FloatArray:
    """Return the value of the pour in which places lie, of pours that are alike in length.

    Args:
        share: of the free length, any shape.
        values: of the pours, from the clamp on; empty: 0 everywhere.
    """
    if not values:
        return np.zeros(np.shape(share))
    pours = np.clip((share * len(values)).astype(int), 0, len(values) - 1)
    return np.asarray(np.array(values)[pours])


def on_foil(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return which Gauss points lie in a strip of the uppermost quarter, 1 or 0, shape (C, 8).

    To the nearest row of points: it is a sixth of the height where three cells share that.
    """
    above = points[:, 2] > 0.25 * setup.shape.section[1]
    along = (share > faults.contrast_at) & (share < faults.contrast_until)
    return np.asarray((along & above).astype(float))


def in_core(setup: Setup, points: FloatArray) -> NDArray[np.bool_]:
    """Return which Gauss points lie in the core of the section, shape (C, 8)."""
    outward = np.abs(points[:, 1:]) / (0.5 * np.array(setup.shape.section)[:, None])
    return np.asarray(outward.max(axis=1) < _CORE)


def _border(setup: Setup, faults: Faults, points: FloatArray) -> FloatArray:
    """Return at which share of the free length a mould that stood aslant was filled up."""
    height = points[:, 2] / (0.5 * setup.shape.section[1])
    return np.asarray(faults.contrast_at + faults.contrast_slant * height)


def _aslant(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return at how many waves of streaks from the clamp Gauss points lie, shape (C, 8)."""
    height = points[:, 2] / (0.5 * setup.shape.section[1])
    return np.asarray((share - faults.contrast_slant * height) / faults.contrast_wave)


def _marbled(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return by which part of the contrast Gauss points are harder, shape (C, 8)."""
    across = points[:, 1:].swapaxes(0, 1) / (0.5 * np.array(setup.shape.section)[:, None, None])
    return marbled_value(share, across, faults.contrast_wave, faults.contrast_seed)


def on_seam(share: FloatArray, height: FloatArray, begin: float) -> FloatArray:
    """Return which places lie between an upper and a lower half that came apart, 1 or 0.

    Args:
        share: of the free length, any shape.
        height: -1 at the lower face and 1 at the upper one, that shape.
        begin: share from which on, to the tip, they came apart.
    """
    return np.asarray(((np.abs(height) < 1.0 / SEAM_LAYERS) & (share > begin)).astype(float))


def _patch(faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return which Gauss points lie in a patch on one side, 1 or 0, shape (C, 8)."""
    along = (share > faults.contrast_at) & (share < faults.contrast_until)
    return np.asarray((along & (faults.contrast_side * points[:, 1] > 0.0)).astype(float))


def cavity(setup: Setup, faults: Faults, share: FloatArray, points: FloatArray) -> FloatArray:
    """Return which Gauss points lie in a cavity below the upper side, 1 or 0, shape (C, 8)."""
    width, height = setup.shape.section
    is_inside = (np.abs(points[:, 1]) < 0.3 * width) & (points[:, 2] > 0.05 * height)
    is_there = (np.abs(share - faults.hollow_at) < 0.5 * faults.hollow) & (share > 0.0)
    return np.asarray((is_inside & is_there).astype(float))


def _torn(faults: Faults, share: FloatArray, height: FloatArray) -> FloatArray:
    """Return which Gauss points lie in a torn piece: the nearest, where none lies in it."""
    away = np.abs(share - faults.torn_at)
    is_there = away < max(_TORN, 1.01 * float(away.min()))
    above = height > min(1.0 - 2.0 * faults.torn, 0.99 * float(height.max()))
    return np.asarray((is_there & above).astype(float))
