# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects that there are: a new one is added to the list."""

from collections.abc import Iterable, Mapping

from diffcal_ros.effects.added_mass import AddedMass
from diffcal_ros.effects.air_drag import AirDrag
from diffcal_ros.effects.anisotropy import Anisotropy
from diffcal_ros.effects.camera_offset import CameraOffset
from diffcal_ros.effects.clamp_offset import ClampOffset
from diffcal_ros.effects.compliant_clamp import CompliantClamp
from diffcal_ros.effects.contact_plane import ContactPlane
from diffcal_ros.effects.creep import MaterialCreep
from diffcal_ros.effects.depth_affine import DepthAffine
from diffcal_ros.effects.depth_bias_by_region import DepthBiasByRegion
from diffcal_ros.effects.effect import Effect, Numbers
from diffcal_ros.effects.gravity_tilt import GravityTilt
from diffcal_ros.effects.picture_edge import edge_in, PictureEdge
from diffcal_ros.effects.rest_curvature import RestCurvature
from diffcal_ros.effects.stiffness_contrast import StiffnessContrast
from diffcal_ros.effects.strain_stiffening import StrainStiffening
from diffcal_ros.effects.time_offset import TimeOffset

# Amplitudes and settings by identifier of the effect and by name, SI units.
Amplitudes = Mapping[str, Numbers]

# In this order they are listed, and act.
_ALL = (
    CameraOffset(),
    DepthAffine(),
    DepthBiasByRegion(),
    TimeOffset(),
    GravityTilt(),
    AddedMass(),
    ContactPlane(),
    ClampOffset(),
    CompliantClamp(),
    RestCurvature(),
    StiffnessContrast(),
    StrainStiffening(),
    Anisotropy(),
    MaterialCreep(),
    AirDrag(),
)
EFFECTS: dict[str, Effect] = {effect.identifier: effect for effect in _ALL}


def effects_by_fit_name() -> dict[str, Effect]:
    """Return the effects by what a fit calls them."""
    return {effect.fit_name: effect for effect in EFFECTS.values()}


def boundary_effects() -> list[Effect]:
    """Return the effects of two materials, whose boundary is a setting."""
    return [effect for effect in EFFECTS.values() if effect.has_boundary]


def seen_boundary() -> Effect:
    """Return the one of those whose boundary the depth camera sees."""
    return next(effect for effect in boundary_effects() if effect.group == 'sensor')


def edge_effect() -> Effect:
    """Return the effect that may have an edge in the picture."""
    return next(effect for effect in EFFECTS.values() if effect.has_edge)


def edge_seen(effects: Amplitudes, number: int) -> PictureEdge | None:
    """Return the edge in the picture of an observation; None: there is none.

    Args:
        effects: that a scene states.
        number: of the observation, from 0.
    """
    return edge_in(effects.get(edge_effect().identifier, {}), number)


def what_settles(identifiers: Iterable[str]) -> str:
    """Say what to record or measure to tell effects from their twins."""
    ways = (way for name in identifiers for way in EFFECTS[name].settles)
    return ', or '.join(dict.fromkeys(ways))
