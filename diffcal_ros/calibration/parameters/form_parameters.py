# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an effect may be more than the library's form of it, as nuisances of a fit."""

from collections.abc import Iterable
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameters import Kind, Parameter
from diffcal_ros.effects.body_size import BodySize, USUAL_BODY
from diffcal_ros.effects.effect import Component, Effect
from diffcal_ros.scene.model import Quantity
from diffcal_ros.time_knot import TimeKnot


def form_parameters(effect: Effect, size: float, body: BodySize = USUAL_BODY) -> list[Parameter]:
    """Return the parameters of an effect's other forms; see `Effect.forms`.

    Args:
        effect: whose.
        size: standard deviation about zero, in usual sizes of each.
        body: on which it is.
    """
    return [
        _nuisance(effect, part.of(body), number, size, Kind(effect.form_kind))
        for number, part in enumerate(effect.forms)
    ]


def course_parameters(effect: Effect, body: BodySize = USUAL_BODY) -> list[Parameter]:
    """Return the parameters of what an effect is over time alone; see `Effect.of_course`."""
    return [
        _nuisance(effect, part.of(body), number, 1.0, Kind.EFFECT)
        for number, part in enumerate(effect.of_course)
    ]


def posture_parameter(amplitude: Parameter, posture: int, size: float) -> Parameter:
    """Return what an amplitude of an effect is more in one posture.

    Args:
        amplitude: what it is in all.
        posture: number of it.
        size: standard deviation about zero, in usual sizes.
    """
    part = amplitude.part
    return replace(
        amplitude,
        name=f'{amplitude.name}@{posture}',
        quantity=_about_zero(part, part.upper - part.lower, size),
        is_nuisance=True,
        posture=posture,
    )


def knot_parameter(amplitude: Parameter, knot: TimeKnot, size: float) -> Parameter:
    """Return what an amplitude of an effect is more around a time of a recording.

    Args:
        amplitude: what it is at all times.
        knot: that time.
        size: standard deviation about zero, in usual sizes.
    """
    part = amplitude.part
    # As many knots may be of one time as there are ways of being another one.
    name = f'{amplitude.name}@{knot.at:.7g}+{knot.spacing:.3g}s'
    return replace(
        amplitude,
        name=name,
        quantity=_about_zero(part, part.upper - part.lower, size),
        is_nuisance=True,
        knot=knot,
    )


def posture_parameters(
    amplitudes: Iterable[Parameter], postures: Iterable[int], size: float
) -> list[Parameter]:
    """Return what amplitudes are more in each posture; see `posture_parameter`."""
    numbers = sorted(postures)
    return [posture_parameter(own, number, size) for own in amplitudes for number in numbers]


def _nuisance(effect: Effect, part: Component, number: int, size: float, kind: Kind) -> Parameter:
    return Parameter(
        effect.amplitude_name(part.name),
        kind,
        number,
        part.unit,
        _about_zero(part, part.upper, size),
        is_nuisance=True,
        effect=effect.identifier,
        amplitude=part.name,
        sized=part,
    )


def _about_zero(part: Component, reach: float, size: float) -> Quantity:
    return Quantity(0.0, -reach, reach, 0.0, size * part.scale)
