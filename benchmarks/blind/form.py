# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a mathematical form of an effect is, and how those with one amplitude are drawn."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, Effect, number, signed, weight_moment
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


@dataclass(frozen=True)
class Form:
    """One mathematical form of an effect.

    Attributes:
        truth: identifier of the effect, of the library.
        name: of the form.
        draw: changes of the faults by size, set-up and source of random numbers.
    """

    truth: str
    name: str
    draw: Callable[[int, Setup, np.random.Generator], dict[str, Any]]

    @property
    def key(self) -> str:
        """What a list of cases calls it."""
        return f'{self.truth}/{self.name}'

    def effect(self, size: int, setup: Setup, random: np.random.Generator) -> Effect:
        """Draw the effect."""
        changes = self.draw(size, setup, random)
        told = {name: str(value) for name, value in changes.items()}
        return Effect(self.truth, {'form': self.name, **told}, 'as the faults', changes)


def drawn_form(
    truth: str,
    name: str,
    fixed: dict[str, Any],
    key: str,
    draw: Callable[[int, np.random.Generator], Any],
) -> Form:
    """Return a form of which one number or vector is drawn, by size."""
    return Form(truth, name, lambda size, setup, random: {**fixed, key: draw(size, random)})


def stiffening_form(form: str, amounts: tuple[float, float, float]) -> Form:
    return drawn_form(
        'strain_stiffening',
        form,
        {'stiffening_form': form},
        'stiffening',
        lambda size, random: number(amounts[size], random),
    )


def contrast_form(mode: str) -> Form:
    return drawn_form(
        'stiffness_contrast',
        mode,
        {'contrast_mode': mode},
        'contrast',
        lambda size, random: signed((0.4, 0.9, 1.8)[size], random),
    )


def mass_form(form: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        mass, _ = weight_moment(setup)
        return {
            'mass_form': form,
            'added_mass': number(1e3 * mass * (0.05, 0.12, 0.30)[size], random),
            'added_mass_at': round(float(random.uniform(0.5, 0.9)), 3),
        }

    return Form('added_mass', form, draw)


def give_form(form: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        mass, moment = weight_moment(setup)
        by_turn = float(np.deg2rad((1.0, 3.0, 7.0)[size])) / moment
        by_shift = (0.001, 0.003, 0.006)[size] / (9.81 * mass)
        others = {'shear': by_shift, 'jaw': (0.3, 0.7, 1.3)[size]}
        amount = others.get(form, by_turn)
        return {'clamp_form': form, 'clamp_compliance': number(amount, random)}

    return Form('compliant_clamp', form, draw)


def tilt_form(form: str) -> Form:
    return drawn_form(
        'gravity_tilt',
        form,
        {'tilt_form': form},
        'gravity_tilt',
        lambda size, random: direction((4.0, 9.0, 18.0)[size], 2, random),
    )


def curvature_form(form: str) -> Form:
    return drawn_form(
        'rest_curvature',
        form,
        {'curvature_form': form},
        'rest_curvature',
        lambda size, random: direction((0.4, 1.0, 2.5)[size], 2, random),
    )


def depth_form(form: str) -> Form:
    return drawn_form(
        'depth_affine',
        form,
        {'depth_form': form},
        'depth_bias',
        lambda size, random: signed((1.5, 4.0, 9.0)[size], random),
    )


def border_form(name: str, fixed: dict[str, Any]) -> Form:
    return drawn_form(
        'depth_bias_by_region',
        name,
        fixed,
        'region_bias',
        lambda size, random: signed((0.8, 2.0, 5.0)[size], random),
    )


def contact_form(form: str) -> Form:
    return drawn_form(
        'contact_plane',
        form,
        {'contact_form': form},
        'contact_height',
        lambda size, random: number((2.0, 5.0, 11.0)[size], random),
    )


def apart(count: int, draw: Callable[[int], FloatArray]) -> FloatArray:
    """Draw a place for each pose, the farthest of which is 1 or -1, until they lie well apart.

    Args:
        count: number of poses.
        draw: as many numbers.
    """
    places, is_apart = np.ones(1), count < 2
    while not is_apart:
        places = draw(count)
        places /= np.abs(places).max()
        is_apart = bool(np.ptp(places) > 1.0)
    return places


def camera_form(name: str, key: str, amounts: tuple[float, float, float]) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        amount = signed(amounts[size], random)
        return {key: amount, 'center_shift': direction((3.0, 7.0, 15.0)[size], 2, random)}

    return Form('camera_offset', name, draw)
