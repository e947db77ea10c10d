# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names of the parameters that a scene, or `--fit`, may ask to be fitted."""

from collections.abc import Sequence

from diffcal_ros.effects.registry import EFFECTS, effects_by_fit_name
from diffcal_ros.scene.model import ObservationSetup, Region
from diffcal_ros.scene.reading.problems import listed, suggestion
from diffcal_ros.scene.reading.quantities import QUANTITY_RULES
import numpy as np

MATERIAL_NAMES = tuple(QUANTITY_RULES)
RIGID_OFFSET = 'rigid_offset'
DAMPING = 'damping'
RELEASE_TIME = 'release_time'
REST_LENGTH = 'rest_length'
CABLE_STIFFNESS = 'cable_stiffness'
CABLE_NAMES = (REST_LENGTH, CABLE_STIFFNESS)
DEFAULT_FIT = ('youngs_modulus', RIGID_OFFSET)


def allowed_fit_names(
    region_names: Sequence[str], cable_names: Sequence[str] = ()
) -> tuple[str, ...]:
    """List every name: of a material number in all regions or in one, of cables, of the pose."""
    in_one = [f'{name}.{region}' for name in MATERIAL_NAMES for region in region_names]
    whole = [effect.fit_name for effect in EFFECTS.values() if effect.is_fitted_whole]
    effects = [
        name
        for effect in EFFECTS.values()
        if not effect.is_fitted_whole
        for name in (effect.fit_name, *(effect.amplitude_name(c.name) for c in effect.components))
    ]
    cables = [
        name
        for kind in CABLE_NAMES
        for name in (kind, *(f'{kind}.{cable}' for cable in cable_names))
        if cable_names
    ]
    return (*MATERIAL_NAMES, *in_one, *cables, *whole, RELEASE_TIME, *effects)


def fit_problems(
    names: Sequence[str],
    region_names: Sequence[str],
    observations: Sequence[ObservationSetup],
    cable_names: Sequence[str] = (),
) -> list[str]:
    """Say what is wrong with a list of names to fit; empty when it can be done.

    Args:
        names: as in `fit` of the scene file or after `--fit`.
        region_names: regions of the scene.
        observations: loads that the fit can learn from.
        cable_names: cables of the scene, which load the body, too.
    """
    if not names:
        return ['is empty: name at least one parameter to fit']
    allowed = allowed_fit_names(region_names, cable_names)
    problems = [
        f'has {name!r}{suggestion(name, allowed)} (allowed: {listed(allowed)})'
        for name in names
        if name not in allowed
    ]
    repeated = {name for name in names if names.count(name) > 1}
    repeated |= {name for name in names if name.partition('.')[0] in names and '.' in name}
    problems += [f'has {name!r} twice: keep one of each' for name in sorted(repeated)]
    return problems + _load_problems(names, observations, has_cables=bool(cable_names))


def _load_problems(
    names: Sequence[str], observations: Sequence[ObservationSetup], *, has_cables: bool
) -> list[str]:
    has_gravity = any(np.any(setup.gravity) for setup in observations)
    has_turn = any(part.turn for setup in observations for part in setup.held)
    has_motion = any(setup.motion is not None for setup in observations)
    problems = []
    for name in names:
        material = name.partition('.')[0]
        effect = effects_by_fit_name().get(material)
        needs_motion = effect is not None and effect.needs_motion
        needs_gravity = material == 'density' or (effect is not None and effect.needs_gravity)
        if (material in (DAMPING, RELEASE_TIME) or needs_motion) and not has_motion:
            problems.append(
                f'has {name!r} while the body is at rest in every observation: give a `motion`, '
                'or leave it out'
            )
        elif needs_gravity and not has_gravity:
            problems.append(
                f'has {name!r} while gravity is zero in every observation: give gravity, or '
                'leave it out'
            )
        elif material in MATERIAL_NAMES and not (has_gravity or has_turn or has_cables):
            problems.append(
                f'has {name!r} while nothing loads the body: give gravity, turn a held part or '
                'pull a cable'
            )
    return problems


def damping_problems(names: Sequence[str], regions: Sequence[Region]) -> list[str]:
    """Name the regions whose damping is to be fitted and has no start value."""
    return [
        f'has {name!r} while region {region.name!r} gives no damping: give it one in Pa s'
        for name in names
        for region in regions
        if name in (DAMPING, f'{DAMPING}.{region.name}') and region.damping is None
    ]
