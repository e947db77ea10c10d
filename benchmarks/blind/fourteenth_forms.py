# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the fourteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.moduli import in_core
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.setups import Setup
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_HARDEST = 4.5  # Log of a tube's modulus over a rubber's.
_BARELY = 0.02  # Share by which a rope is longer that hardly hangs through.


def _knitted(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a body into a knitted sleeve, whose loops bear the more the longer they are drawn."""
    return {
        'stiffening_form': 'knitted',
        'stiffening': number((0.6, 2.0, 8.0)[size], random),
    }


def _cored(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a plastic tube into the core, from the clamp to some place."""
    at = round(float(random.uniform(0.35, 0.6)), 4)
    contrasts = np.linspace(0.0, _HARDEST, 101)
    core = _core_share(setup)
    # By the tip's share of an even load's moments, where the section is stiffer by its core.
    kept = 1.0 / (1.0 + core * np.expm1(contrasts))
    changes = tip_sag(setup) * (1.0 - (1.0 - at) ** 4) * (1.0 - kept)
    # More than the formula asks: a body's fibres, or its bend, bear a part as well.
    contrast = float(np.interp(1.35 * _MOVES[size], changes, contrasts))
    return {'contrast_mode': 'cored', 'contrast': number(contrast, random), 'contrast_at': at}


def _core_share(setup: Setup) -> float:
    """Return which share of a section's second moment about y its core has."""
    mesh = mesh_hexahedra(setup.shape)
    quadrature = integrate(mesh.nodes, mesh.cells)
    points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    parts = quadrature.volumes * points[:, 2] ** 2
    return float(parts[in_core(setup, points)].sum() / parts.sum())


def _draped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body over a rail, from which both of its ends hang."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'draped',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.3, 0.55)), 4),
    }


def _pinched(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Overtighten jaws that close aslant, so that the body comes out, more on one side."""
    shape = setup.shape
    turn = 0.85 * _MOVES[size] / (shape.length - shape.clamp)
    wedge = signed(0.5 * turn * shape.section[0] / shape.clamp, random)
    # On the side that is held least it is just touched.
    pinch = abs(wedge) + float(random.uniform(0.01, 0.05))
    return {'clamp_pinch': round(pinch, 5), 'clamp_wedge': wedge}


def _rope(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a rubber rope below the body, which sinks by a third or a half of what it lifts."""
    share = round(float(random.uniform(0.62, 0.8)), 4)
    sinks, span = random.uniform(0.3, 0.5), round(float(random.uniform(0.06, 0.09)), 4)
    # A place inside the tip moves by less, and is stiffer.
    lift = _MOVES[size] * share**1.5
    force, sunk = tip_stiffness(setup) / share**3 * lift, lift * sinks / (1.0 - sinks)
    drawn = np.hypot(span, sunk)
    loose = span / (1.0 + _BARELY)
    tension = 0.5 * force * drawn / sunk * (span - loose) / (drawn - loose)
    return {
        'contact_form': 'rope',
        'contact_height': number(1e3 * (lift + sunk), random),
        'contact_share': share,
        'contact_span': span,
        'contact_drawn': _BARELY,
        'contact_tension': number(tension, random),
    }


def _veil(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a fingerprint on a lens, which spreads the light of something near, or of a wall."""
    is_near = random.random() < 0.5
    depth = random.uniform(0.14, 0.2) if is_near else random.uniform(0.7, 0.9)
    # What is dark errs by more.
    amount = number((1.4, 3.5, 7.0)[size], random)
    return {
        'depth_form': 'veil',
        'depth_bias': -amount if is_near else amount,
        'depth_veil': round(float(depth), 4),
    }


def _banded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wind bands of tape around the outer part, which throw more light back than the rubber."""
    return {
        'region_bias': signed((2.0, 5.0, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.3, 0.4)), 4),
        'region_bands': (
            round(float(random.uniform(0.22, 0.3)), 4),
            round(float(random.uniform(0.45, 0.6)), 4),
        ),
    }


def _creeping(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a printed bracket, which creeps a part of its way in every pose."""
    part = round(float(random.uniform(0.5, 0.7)), 4)
    turn = float(np.deg2rad((1.0, 2.5, 5.0)[size]))
    return {
        'clamp_form': 'creeping',
        'clamp_compliance': number(turn / (part * held_moment(setup)), random),
        'clamp_crept': part,
    }


FOURTEENTH_FORMS = (
    Form('strain_stiffening', 'knitted', _knitted),
    Form('stiffness_contrast', 'cored', _cored),
    Form('rest_curvature', 'draped', _draped),
    Form('clamp_offset', 'pinched', _pinched),
    Form('contact_plane', 'rope', _rope),
    Form('depth_affine', 'veil', _veil),
    Form('depth_bias_by_region', 'banded', _banded),
    Form('compliant_clamp', 'creeping', _creeping),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
FOURTEENTH_PAIRS = (
    ('strain_stiffening/knitted', 'camera_offset/pane'),
    ('clamp_offset/pinched', 'gravity_tilt/blower'),
    ('contact_plane/rope', 'depth_affine/veil'),
    ('rest_curvature/draped', 'added_mass/pooled'),
)
