# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Standard errors of fitted parameters, and which of them the data cannot tell apart.

The covariance is that of an estimator with robust weights and correlated residuals,

    C = H^-1 S H^-1 + d d^T,

with the information H and the covariance S of the gradient, priors included, and the shift d that
a finer mesh would make: an error that is the same in every recording, so it is added whole.

The sign of d is known. An interval for the body itself is centred where a mesh without error would
end, x + r s, with the shift s of one halving and r between its values for smooth solutions and for
the clamp's edge; what is left of r is the mesh's part of that interval.
"""

from dataclasses import dataclass

from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Refinement removes three quarters of the error of a smooth solution and half of that at the
# clamp's corners: what one halving shows is multiplied by this.
MESH_SHIFT_FACTOR = 1.5
# An error that halves as h^p goes by r = 1 / (1 - 2^-p) times what one halving shows. Quadratic
# displacements have p = 4 where they are smooth, and twice the exponent of the singularity, about
# 0.65 in nearly incompressible bodies, where a clamp's edge rules: r is 1.07 to 1.68.
_SMOOTH_RATIO, _EDGE_RATIO = 1.07, 1.68
_RATIO = 0.5 * (_SMOOTH_RATIO + _EDGE_RATIO)
_RATIO_STD = (_EDGE_RATIO - _SMOOTH_RATIO) / np.sqrt(12.0)
# Standard errors to either side in a 95 % interval.
Z_95 = 1.96
# A combination of parameters known to no better than this is not known.
_UNKNOWN = 1.0
_NATURAL_SCALE = {
    Kind.YOUNGS_MODULUS: 1.0,  # of the logarithm: a factor e
    Kind.DENSITY: 1.0,
    Kind.DAMPING: 1.0,
    Kind.RELEASE_TIME: 0.1,
    Kind.REST_LENGTH: 0.05,
    Kind.CABLE_STIFFNESS: 1.0,
    Kind.POISSONS_RATIO: 0.2,
    Kind.GRAVITY_TILT: 0.5,
    Kind.EDGE_BIAS: 10.0,
}
_NATURAL_SIZES = 10.0  # Of an effect, in usual sizes.
_NATURAL_LENGTH = 0.2
_NATURAL_ANGLE = 0.7
# A component of a blind direction below this share does not take part in it.
_TAKES_PART = 0.3


@dataclass(frozen=True)
class Uncertainty:
    """Errors of the coordinates.

    Attributes:
        covariance: of the coordinates, shape (k, k).
        statistical: the part from the data and the priors, shape (k, k).
        mesh_shift: what halving the mesh size would change, shape (k,).
        fine_shift: how far off a mesh without error would end, shape (k,).
        fine_covariance: of the coordinates there, shape (k, k).
        blind: names of parameters that take part in a combination the data cannot see.
        prior_bound: names of parameters known only through their priors.
    """

    covariance: FloatArray
    statistical: FloatArray
    mesh_shift: FloatArray
    fine_shift: FloatArray
    fine_covariance: FloatArray
    blind: tuple[str, ...]
    prior_bound: tuple[str, ...]

    @property
    def standard_errors(self) -> FloatArray:
        """Of the coordinates, shape (k,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def fine_errors(self) -> FloatArray:
        """Standard errors of what a mesh without error would give, shape (k,)."""
        return np.sqrt(np.maximum(np.diag(self.fine_covariance), 0.0))

    @property
    def correlation(self) -> FloatArray:
        """Statistical correlation of the coordinates, shape (k, k)."""
        spread = np.sqrt(np.maximum(np.diag(self.statistical), 1e-300))
        return self.statistical / np.outer(spread, spread)


def natural_scales(parameters: ParameterSet) -> FloatArray:
    """Return changes of the coordinates that would be called large, shape (k,)."""
    scales = []
    for parameter in parameters:
        if parameter.kind in _NATURAL_SCALE:
            scales.append(_NATURAL_SCALE[parameter.kind])
        elif parameter.component is not None:
            scales.append(_NATURAL_SIZES * parameter.component.scale)
        else:
            scales.append(_NATURAL_LENGTH if parameter.axis < 3 else _NATURAL_ANGLE)
    return np.array(scales)


def estimate_uncertainty(
    linear: Linearisation,
    parameters: ParameterSet,
    mesh_shift: FloatArray,
    *,
    one_sided: tuple[str, ...] = (),
) -> Uncertainty:
    """Estimate errors at a minimum.

    Args:
        linear: information and covariance of the gradient there.
        parameters: with their priors.
        mesh_shift: what halving the mesh size would change, shape (k,).
        one_sided: names of parameters that the data limit on one side only.
    """
    _, precision = parameters.prior()
    scales = natural_scales(parameters)
    both = np.outer(scales, scales)
    statistical, blind = _covariance(linear.information, linear.gradient_covariance, parameters)
    shift = MESH_SHIFT_FACTOR * mesh_shift
    # The shift is that of a linear step: of a large one the square is left.
    left = mesh_shift * np.hypot(_RATIO_STD, 0.5 * np.abs(mesh_shift / scales).max(initial=0.0))
    data_only, *_ = _inverse(linear.information * both, parameters)
    return Uncertainty(
        covariance=statistical + np.outer(shift, shift),
        statistical=statistical,
        mesh_shift=mesh_shift,
        fine_shift=_RATIO * mesh_shift,
        fine_covariance=statistical + np.outer(left, left),
        blind=tuple(name for name in parameters.names if name in {*blind, *one_sided}),
        prior_bound=_prior_bound(data_only, precision, parameters),
    )


def covariance_of(
    information: FloatArray, gradient_covariance: FloatArray, parameters: ParameterSet
) -> FloatArray:
    """Return the covariance of the coordinates by data and priors, shape (k, k).

    Args:
        information: of the data, shape (k, k).
        gradient_covariance: of the data's part of the gradient, shape (k, k).
        parameters: with their priors.
    """
    return _covariance(information, gradient_covariance, parameters)[0]


def _covariance(
    information: FloatArray, gradient_covariance: FloatArray, parameters: ParameterSet
) -> tuple[FloatArray, tuple[str, ...]]:
    _, precision = parameters.prior()
    scales = natural_scales(parameters)
    both = np.outer(scales, scales)
    inverse, unknown, blind = _inverse((information + precision) * both, parameters)
    # What the data do not see is as uncertain as its natural scale, whatever their gradient.
    own = inverse @ ((gradient_covariance + precision) * both) @ inverse + _UNKNOWN**2 * unknown
    return own * both, blind


def _inverse(
    information: FloatArray, parameters: ParameterSet
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Invert in natural scales, where unknown directions get a variance of one.

    Returns:
        The inverse, the projector on what is not known, and the names that take part in that.
    """
    values, vectors = np.linalg.eigh(information)
    known = values > _UNKNOWN**-2
    names: set[str] = set()
    for vector in vectors[:, ~known].T:
        names.update(
            parameter.name
            for parameter, fraction in zip(parameters, np.abs(vector), strict=True)
            if fraction > _TAKES_PART
        )
    capped = np.where(known, values, _UNKNOWN**-2)
    order = [name for name in parameters.names if name in names]
    dark = vectors[:, ~known]
    return (vectors / capped) @ vectors.T, dark @ dark.T, tuple(order)


def _prior_bound(
    data_only: FloatArray, precision: FloatArray, parameters: ParameterSet
) -> tuple[str, ...]:
    """Name asked-for parameters whose prior says more than the data."""
    scales, own = natural_scales(parameters), np.diag(precision)
    names = []
    for index, parameter in enumerate(parameters):
        if parameter.is_nuisance or parameter.kind is Kind.RIGID_OFFSET or not own[index]:
            continue
        if data_only[index, index] * scales[index] ** 2 * own[index] > 1.0:
            names.append(parameter.name)
    return tuple(names)
