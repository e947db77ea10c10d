# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The parameters of a fit, laid out by the names that a scene gives them."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from diffcal_ros.calibration.parameters.parameters import Kind, Parameter, ParameterSet
from diffcal_ros.effects.effect import Component, Effect
from diffcal_ros.effects.registry import EFFECTS, effects_by_fit_name
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.fit_names import CABLE_NAMES
from diffcal_ros.scene.model import Cable, Quantity, Region, Scene
from diffcal_ros.scene.size_of_body import size_of_body
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_Owner = TypeVar('_Owner', Region, Cable)

_OFFSET_AXES = ('x', 'y', 'z', 'rx', 'ry', 'rz')
_OFFSET_LIMITS = (0.2, 0.2, 0.2, np.pi / 3, np.pi / 3, np.pi / 3)
_EDGE_BIAS_STD = 1.0  # A LIDAR's spot smears an edge over about a pixel.
_PER_REGION = (Kind.YOUNGS_MODULUS, Kind.POISSONS_RATIO, Kind.DENSITY, Kind.DAMPING)
_UNITS = {
    Kind.YOUNGS_MODULUS: 'Pa',
    Kind.POISSONS_RATIO: '1',
    Kind.DENSITY: 'kg/m^3',
    Kind.DAMPING: 'Pa s',
    Kind.RELEASE_TIME: 's',
    Kind.REST_LENGTH: 'm',
    Kind.CABLE_STIFFNESS: 'N/m',
    Kind.GRAVITY_TILT: 'rad',
    Kind.EDGE_BIAS: 'px',
}


def known_names() -> tuple[str, ...]:
    """Return what a fit may name; also single regions, cables and amplitudes, after a dot."""
    effects = [effect.fit_name for effect in EFFECTS.values()]
    regional = (kind.value for kind in _PER_REGION)
    return (*regional, Kind.RELEASE_TIME.value, *CABLE_NAMES, *effects)


def make_parameters(
    scene: Scene,
    fit: Sequence[str] | None = None,
    *,
    pose_covariances: Sequence[FloatArray | None] = (),
    with_edge_bias: bool = True,
) -> ParameterSet:
    """Lay out the parameters of a fit.

    Args:
        scene: gives regions, start values and priors.
        fit: names as in `known_names`, a region's as `youngs_modulus.<region>`; default: the
            scene's.
        pose_covariances: of each observation's camera pose, shape (6, 6), translation [m] first;
            None where the pose is taken as exact.
        with_edge_bias: add the width by which the sensor smears edges, a nuisance.

    Raises:
        SceneError: for an unknown name, or a start outside its bounds.
    """
    names = tuple(scene.fit if fit is None else fit)
    if not names:
        raise SceneError(
            f"nothing to fit: name at least one of {', '.join(known_names())} under 'fit'"
        )
    parameters: list[Parameter] = []
    for name in names:
        for parameter in _named(scene, name):
            if parameter.name not in [p.name for p in parameters]:
                parameters.append(parameter)
    for index, covariance in enumerate(pose_covariances):
        if covariance is not None:
            parameters.extend(camera_pose_parameters(index))
    if with_edge_bias:
        bias = Quantity(0.0, -5.0, 5.0, 0.0, _EDGE_BIAS_STD)
        parameters.append(Parameter('edge_bias', Kind.EDGE_BIAS, 0, 'px', bias, is_nuisance=True))
    for parameter in parameters:
        _check_start(parameter)
    known = [(i, c) for i, c in enumerate(pose_covariances) if c is not None]
    return ParameterSet(tuple(parameters), tuple(known))


def _named(scene: Scene, name: str) -> list[Parameter]:
    head, _, region_name = name.partition('.')
    effect = effects_by_fit_name().get(head)
    if effect is not None and not (region_name and effect.is_fitted_whole):
        return _effect(scene, effect, region_name)
    if head in CABLE_NAMES:
        return _cables(scene, head, region_name)
    if head not in known_names() or (region_name and head not in [k.value for k in _PER_REGION]):
        raise SceneError(
            f"cannot fit {name!r}: use one of {', '.join(known_names())}; a single region's as "
            "'youngs_modulus.<region>'"
        )
    if head == Kind.RELEASE_TIME.value:
        return _release_times(scene)
    kind = Kind(head)
    return _of_owners(
        kind, region_name, scene.regions, 'regions', lambda region: _quantity(region, kind)
    )


def _quantity(region: Region, kind: Kind) -> Quantity:
    quantity: Quantity | None = getattr(region, kind.value)
    if quantity is None:
        raise SceneError(
            f'cannot fit {kind.value!r}: region {region.name!r} gives none to start from'
        )
    return quantity


def _cables(scene: Scene, head: str, cable_name: str) -> list[Parameter]:
    kind = Kind(head)

    def quantity(cable: Cable) -> Quantity:
        return cable.rest_length if kind is Kind.REST_LENGTH else cable.stiffness

    return _of_owners(kind, cable_name, scene.cables, 'cables', quantity)


def _of_owners(
    kind: Kind,
    wanted: str,
    owners: Sequence[_Owner],
    what: str,
    quantity: Callable[[_Owner], Quantity],
) -> list[Parameter]:
    """Make the parameter of one region or cable, or of all without a name."""
    head = kind.value
    chosen = [(i, owner) for i, owner in enumerate(owners) if wanted in ('', owner.name)]
    if not chosen:
        known = ', '.join(owner.name for owner in owners) or 'none'
        name = f'{head}.{wanted}' if wanted else head
        raise SceneError(f'cannot fit {name!r}: the {what} of the scene are {known}')
    is_single = len(owners) == 1
    return [
        Parameter(
            head if is_single else f'{head}.{owner.name}',
            kind,
            index,
            _UNITS[kind],
            quantity(owner),
        )
        for index, owner in chosen
    ]


def _release_times(scene: Scene) -> list[Parameter]:
    moving = [
        (index, setup.name, setup.motion.release_time)
        for index, setup in enumerate(scene.observations)
        if setup.motion is not None
    ]
    if not moving:
        raise SceneError("cannot fit 'release_time': no observation of the scene moves")
    return [
        Parameter(
            'release_time' if len(moving) == 1 else f'release_time.{name}',
            Kind.RELEASE_TIME,
            index,
            _UNITS[Kind.RELEASE_TIME],
            quantity,
        )
        for index, name, quantity in moving
    ]


def _effect(scene: Scene, effect: Effect, component_name: str) -> list[Parameter]:
    known, identifier = scene.effects.get(effect.identifier, {}), effect.identifier
    offered = effect.components if component_name else effect.components_in(known)
    chosen = [part for part in offered if component_name in ('', part.name)]
    if not chosen:
        names = ', '.join(part.name for part in effect.components)
        raise SceneError(f'cannot fit {identifier}.{component_name!r}: its components are {names}')
    kind, body = Kind(effect.kind), size_of_body(scene)
    return [
        Parameter(
            effect.amplitude_name(part.name),
            kind,
            index,
            part.unit,
            _effect_quantity(part, known.get(part.name, 0.0), _nominal_std(scene, kind, part)),
            axis=index if effect.is_fitted_whole else 0,
            effect=identifier,
            amplitude=part.name,
            sized=part,
        )
        for index, part in enumerate(own.of(body) for own in chosen)
    ]


def _effect_quantity(part: Component, start: float, std: float) -> Quantity:
    lower, upper = part.lower, part.upper
    if part.goes_by_body:
        # What a scene states is there, however unusual on such a body.
        lower, upper = min(lower, 2.0 * start), max(upper, 2.0 * start)
    if not part.has_prior:
        return Quantity(start, lower, upper)
    return Quantity(start, lower, upper, 0.0, std)


def _nominal_std(scene: Scene, kind: Kind, part: Component) -> float:
    """Return the standard deviation of an amplitude's prior; a rigid offset's is the scene's."""
    if kind is Kind.RIGID_OFFSET:
        prior = scene.rigid_offset
        return prior.translation_std if part.unit == 'm' else prior.rotation_std
    return part.scale if part.nominal_std is None else part.nominal_std


def camera_pose_parameters(observation: int) -> list[Parameter]:
    """Lay out the error of one observation's camera pose, a nuisance."""
    return rigid_motion_parameters(f'camera_pose.{observation}', Kind.CAMERA_POSE, observation)


def rigid_motion_parameters(name: str, kind: Kind, target: int) -> list[Parameter]:
    """Lay out a rigid motion of which nothing is known, a nuisance.

    Args:
        name: before those of the axes.
        kind: of the parameters.
        target: what they are of.
    """
    return [
        Parameter(
            f'{name}.{axis}',
            kind,
            target,
            'm' if index < 3 else 'rad',
            Quantity(0.0, -_OFFSET_LIMITS[index], _OFFSET_LIMITS[index]),
            axis=index,
            is_nuisance=True,
        )
        for index, axis in enumerate(_OFFSET_AXES)
    ]


def _check_start(parameter: Parameter) -> None:
    quantity = parameter.quantity
    if not quantity.lower <= quantity.start <= quantity.upper:
        raise SceneError(
            f'{parameter.name} starts at {quantity.start:g} {parameter.unit}: it must lie within '
            f'its bounds {quantity.lower:g} to {quantity.upper:g}'
        )
