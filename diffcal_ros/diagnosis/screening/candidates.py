# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ways in which each effect of the library may be present."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.effects.body_size import BodySize, USUAL_BODY
from diffcal_ros.effects.effect import Component, Effect
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.scene.fit_names import RELEASE_TIME
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.size_of_body import size_of_body
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """One effect with some of its amplitudes.

    Attributes:
        identifier: of the effect.
        components: names of the amplitudes that are free.
        at: place along the body, or relaxation time [s], for an effect that has one; None for the
            usual one.
        size: how many times as large as usual it may well be, see `usual_sizes`; no part of what
            it is.
        body: on which it is: what usual sizes go by; no part of what it is.
    """

    identifier: str
    components: tuple[str, ...]
    at: float | None = None
    size: float = field(default=1.0, compare=False)
    body: BodySize = field(default=USUAL_BODY, compare=False)

    @property
    def effect(self) -> Effect:
        """The effect."""
        return EFFECTS[self.identifier]

    @property
    def settings(self) -> dict[str, float]:
        """Fixed numbers that go with it."""
        return {'at': self.at} if self.at is not None and 'at' in self.effect.settings else {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its amplitudes among the parameters of a fit."""
        return tuple(map(self.effect.amplitude_name, self.components))

    @property
    def parts(self) -> tuple[Component, ...]:
        """Its amplitudes."""
        return tuple(map(self.part, self.components))

    def part(self, name: str) -> Component:
        """Return one of the effect's amplitudes, also of its other forms, on the body."""
        return self.effect.component(name).of(self.body)

    @property
    def scales(self) -> FloatArray:
        """Usual sizes of its amplitudes, SI units, shape (a,)."""
        return np.array([part.scale for part in self.parts])

    @property
    def likely_scales(self) -> FloatArray:
        """How large its amplitudes may well be, of its size, SI units, shape (a,)."""
        return self.size * self.scales

    def extends(self, part: 'Candidate') -> bool:
        """Tell whether it is the same effect at the same place, with further amplitudes."""
        is_same = (self.identifier, self.at) == (part.identifier, part.at)
        return is_same and set(self.components) > set(part.components)

    @property
    def screened(self) -> dict[str, float]:
        """The amplitude that its place or time is, by name; empty where that is a setting."""
        own = self.effect
        if self.at is None or own.screened_name not in self.components:
            return {}
        return {own.amplitude_name(own.screened_name): self.at}


def candidates(
    scene: Scene, without: Collection[str] = (), fit: Collection[str] | None = None
) -> list[Candidate]:
    """List what a scene's model may lack.

    Args:
        scene: effects that it states already are no candidates, nor are those that its
            observations cannot show.
        without: identifiers to leave out.
        fit: names of the nominal parameters; effects among them are no candidates. Default: the
            scene's.
    """
    fitted = {name.partition('.')[0] for name in (scene.fit if fit is None else fit)}
    left_out = {*without, *(name for name in scene.effects if _is_stated(scene, name))}
    left_out |= {effect.identifier for effect in EFFECTS.values() if effect.fit_name in fitted}
    shown, body = shown_effects(scene, fitted), size_of_body(scene)
    return [
        Candidate(effect.identifier, components, at, body=body)
        for effect in shown
        if effect.identifier not in left_out
        for components in effect.variants_in(scene.effects.get(effect.identifier, {}))
        for place in effect.places_of(components)
        for at in (place or scene.effects.get(effect.identifier, {}).get('at'),)
    ]


def identifiers_of(added: Iterable[Candidate]) -> tuple[str, ...]:
    """Return the identifiers of some effects, in alphabetical order."""
    return tuple(sorted(own.identifier for own in added))


def parameters_of(parameters: ParameterSet, added: Iterable[Candidate]) -> list[str]:
    """Return the names of all that some effects brought into a fit, also what is freed."""
    wanted = {own.identifier: own.names for own in added}
    return [
        one.name
        for one in parameters
        if one.effect in wanted and (one.is_freed or one.name in wanted[one.effect])
    ]


def _is_stated(scene: Scene, effect: str) -> bool:
    """Tell whether a scene states amplitudes of an effect, and not just where it would be."""
    return bool(scene.effects[effect].keys() - EFFECTS[effect].settings.keys())


def shown_effects(scene: Scene, fitted: Collection[str]) -> list[Effect]:
    """Return the effects that the observations of a scene can show, and show apart.

    Args:
        scene: with its observations.
        fitted: names of the nominal parameters, without what comes after a dot.
    """
    motions = [setup.motion for setup in scene.observations if setup.motion is not None]
    kinds = {motion.is_slow for motion in motions}
    has_explicit = any(motion.has_explicit_steps for motion in motions)
    # A release of which nothing is known beforehand does all that late stamps do.
    is_free = RELEASE_TIME in fitted and any(m.release_time.prior_std is None for m in motions)
    return [
        effect
        for effect in EFFECTS.values()
        if not (effect.needs_motion and effect.needs_hold not in kinds)
        and not (effect.is_at_rest_only and False in kinds)
        and not (effect.needs_implicit_steps and has_explicit)
        and not (effect.hides_in_release and is_free)
    ]
