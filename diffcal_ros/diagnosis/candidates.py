# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ways in which each effect of the library may be present."""

from collections.abc import Collection
from dataclasses import dataclass

from diffcal_ros.scene.effects import Effect, EFFECTS, FIT_NAME_OF
from diffcal_ros.scene.fit_names import RELEASE_TIME
from diffcal_ros.scene.model import Scene

# Shares of the free length at which a mass is looked for: one between two places still looks like
# one of them, and less like a contrast of stiffness.
MASS_PLACES = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
# Relaxation times that are screened [s]; refits go on from the best.
CREEP_TIMES = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)


@dataclass(frozen=True)
class Candidate:
    """One effect with some of its amplitudes.

    Attributes:
        identifier: of the effect.
        components: names of the amplitudes that are free.
        at: place along the body, or relaxation time [s], for an effect that has one; None for the
            usual one.
    """

    identifier: str
    components: tuple[str, ...]
    at: float | None = None

    @property
    def effect(self) -> Effect:
        """The effect."""
        return EFFECTS[self.identifier]

    @property
    def settings(self) -> dict[str, float]:
        """Fixed numbers that go with it."""
        return {'at': self.at} if self.at is not None and self.effect.settings else {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its amplitudes among the parameters of a fit."""
        head = FIT_NAME_OF.get(self.identifier, self.identifier)
        return tuple(f'{head}.{name}' for name in self.components)

    @property
    def fit_name(self) -> str:
        """What a scene's `fit` calls it."""
        return FIT_NAME_OF.get(self.identifier, self.identifier)


_SHIFT, _TURN = ('x', 'y', 'z'), ('rx', 'ry', 'rz')
_VARIANTS: dict[str, tuple[tuple[str, ...], ...]] = {
    'camera_offset': (_SHIFT, _SHIFT + _TURN),
    'depth_affine': (('bias',), ('scale',), ('scale', 'bias')),
    'depth_bias_by_region': (('bias',),),
    'gravity_tilt': (('a', 'b'),),
    'contact_plane': (('height', 'a', 'b'),),
    'clamp_offset': (_SHIFT, _TURN, _SHIFT + _TURN),
    'compliant_clamp': (('compliance',),),
    'rest_curvature': (('a', 'b'),),
    'stiffness_contrast': (('split',), ('along',)),
    'strain_stiffening': (('ratio',),),
    'time_offset': (('late',),),
    'air_drag': (('area',),),
}
# A clamp that gives way is modelled for a body at rest only, and the forces that stand in for
# contact in the screening would be masses in a motion.
_AT_REST_ONLY = ('compliant_clamp', 'contact_plane')


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
    left_out |= {name for name in EFFECTS if FIT_NAME_OF.get(name, name) in fitted}
    left_out |= _not_shown(scene, fitted)
    found = [
        Candidate(identifier, components, scene.effects.get(identifier, {}).get('at'))
        for identifier, variants in _VARIANTS.items()
        for components in variants
        if identifier not in left_out
    ]
    if 'added_mass' not in left_out:
        found += [Candidate('added_mass', ('mass',), place) for place in MASS_PLACES]
    if 'creep' not in left_out:
        found += [Candidate('creep', ('share', 'tau'), time) for time in CREEP_TIMES]
    return found


def _is_stated(scene: Scene, effect: str) -> bool:
    """Tell whether a scene states amplitudes of an effect, and not just where it would be."""
    return bool(scene.effects[effect].keys() - EFFECTS[effect].settings.keys())


def _not_shown(scene: Scene, fitted: Collection[str]) -> set[str]:
    """Return the effects that the observations of a scene cannot show, or not apart."""
    motions = [setup.motion for setup in scene.observations if setup.motion is not None]
    kinds = {motion.is_slow for motion in motions}
    found = {
        name
        for name, effect in EFFECTS.items()
        if effect.needs_motion and effect.needs_hold not in kinds
    }
    if not motions:
        return found
    found |= set(_AT_REST_ONLY)
    if RELEASE_TIME in fitted and any(m.release_time.prior_std is None for m in motions):
        # A release of which nothing is known beforehand does all that late stamps do.
        found.add('time_offset')
    return found
