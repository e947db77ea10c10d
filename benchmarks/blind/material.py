# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Stable neo-Hookean elasticity that stiffens, in numbers that mean E and nu at rest.

    psi = a/2 (I - 3) - a/2 log((I + 1)/4) + b/2 (J - 1)^2 - 3/4 a (J - 1) + c (I - 3)^2

with I = tr F^T F, J = det F (Smith et al. 2018, eq. 13; Arnavaz et al. 2023, eq. 12). For small
strain the shear modulus is 3/4 a and Lame's lambda is b - 5/8 a; `constants` inverts that. Other
forms of stiffening in place of c (I - 3)^2, each without stress at rest:

    Gent (1996)      - mu / (2 k) log(1 - k (I - 3)) - mu/2 (I - 3),   k = 1 / Jm
    Fung               mu / (2 k) (exp(k (I - 3)) - 1) - mu/2 (I - 3)
    Yeoh, third term   d max(I - 3, 0)^3
    Mooney-Rivlin      s mu/2 (II - 3 - 4 (J - 1)),   II = (I^2 - tr (F^T F)^2) / 2
    Ogden, power 4     s mu/8 (tr (F^T F)^2 - 3 - 4 (J - 1))
    Veronda-Westmann   mu / k (exp(k (I - 3)) - 1) - mu (I - 3) - mu/2 (II - 3 - 4 (J - 1))
    Hart-Smith         mu/2 int_3^I exp(k (i - 3)^2) di - mu/2 (I - 3),   0 where I < 3

Mooney-Rivlin's and Ogden's take the share s of the shear modulus at rest. Veronda's and Westmann's
(1970) comes on a law of twice the shear modulus, whose first term it cancels. The others stiffen
changes of volume as well, as the term with c does. Hart-Smith's (1966, J. Appl. Math. Phys. 17)
is that of his first constant.

The plain neo-Hookean law has, in place of the terms with a and b,

    mu/2 (I - 3) - mu log J + lambda/2 (log J)^2

(Bonet and Wood 2008, eq. 6.27). Fibres may come on top (`fibres`, `network`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import erfi

from benchmarks.blind.fibres import Fibres
from benchmarks.blind.shapes import FloatArray

STIFFENINGS = (
    'gent',
    'fung',
    'cubic',
    'mooney_rivlin',
    'ogden',
    'veronda_westmann',
    'hart_smith',
)
_MOST = 50.0  # Exponent that a line search may try; no body comes near it.


@dataclass(frozen=True)
class Constants:
    """Numbers of the energy; shapes (C, 8) or broadcastable to it.

    Attributes:
        shear: a [Pa].
        bulk: b [Pa].
        yeoh: c [Pa].
        cubic: d [Pa].
        gent: mu [Pa] and k [-]; a k of 0: none.
        fung: likewise.
        hart_smith: likewise.
        invariant: factor of II [Pa].
        squares: factor of tr (F^T F)^2, that of II included [Pa].
        rest: of J - 1, so that nothing is stressed at rest [Pa].
        is_plain: the law with logarithms of the same mu and lambda as a and b stand for.
        fibres: that stiffen it along one direction; None: it is the same in all.
        fabric: further ones, in a part of the body; None: there is none.
        network: those of a network, alike in all directions.
    """

    shear: FloatArray
    bulk: FloatArray
    yeoh: FloatArray
    cubic: FloatArray | float = 0.0
    gent: tuple[FloatArray | float, float] = (0.0, 0.0)
    fung: tuple[FloatArray | float, float] = (0.0, 0.0)
    hart_smith: tuple[FloatArray | float, float] = (0.0, 0.0)
    invariant: FloatArray | float = 0.0
    squares: FloatArray | float = 0.0
    rest: FloatArray | float = 0.0
    is_plain: bool = False
    fibres: Fibres | None = None
    fabric: Fibres | None = None
    network: tuple[Fibres, ...] = ()

    @property
    def families(self) -> tuple[Fibres, ...]:
        """All fibres that there are."""
        single = (each for each in (self.fibres, self.fabric) if each is not None)
        return (*single, *self.network)


def constants(
    youngs_modulus: FloatArray, poissons_ratio: float, yeoh_ratio: float = 0.0
) -> Constants:
    """Return the energy's numbers.

    Args:
        youngs_modulus: [Pa].
        poissons_ratio: dimensionless.
        yeoh_ratio: C2 / C1 [-], where C1 is half the shear modulus at rest.
    """
    mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    lam = 2.0 * mu * poissons_ratio / (1.0 - 2.0 * poissons_ratio)
    shear = mu / 0.75
    return Constants(shear, lam + 0.625 * shear, 0.5 * yeoh_ratio * mu)


def stiffened(numbers: Constants, form: str, amount: float) -> Constants:
    """Return the numbers with one of the other forms of stiffening.

    Args:
        numbers: of the law without.
        form: one of `STIFFENINGS`.
        amount: k, d over half the shear modulus, or s.
    """
    mu = 0.75 * numbers.shear
    if amount == 0.0:
        return numbers
    if form in ('gent', 'fung', 'hart_smith'):
        return replace(numbers, **{form: (mu, amount)})
    if form == 'cubic':
        return replace(numbers, cubic=0.5 * amount * mu)
    if form == 'veronda_westmann':
        return replace(stiffened(numbers, 'mooney_rivlin', -1.0), fung=(2.0 * mu, amount))
    lam = numbers.bulk - 0.625 * numbers.shear
    shear = (1.0 - amount) * numbers.shear
    plain = replace(numbers, shear=shear, bulk=lam + 0.625 * shear)
    part = amount * mu
    if form == 'mooney_rivlin':
        # On top of what the rubber has of it already.
        return replace(
            plain,
            invariant=numbers.invariant + 0.5 * part,
            squares=numbers.squares - 0.25 * part,
            rest=numbers.rest + 2.0 * part,
        )
    if form == 'ogden':
        # Its lambda is half of what it adds to the shear modulus, and negative.
        bulk = plain.bulk + 0.5 * part
        return replace(plain, bulk=bulk, squares=0.125 * part, rest=0.5 * part)
    raise ValueError(f'form of stiffening is {form!r}: {", ".join(STIFFENINGS)}')


def softened(numbers: Constants, factor: float) -> Constants:
    """Return the numbers of a law whose energy is a factor of what it was."""
    fibres, fabric = (
        None if each is None else replace(each, stiffness=factor * each.stiffness)
        for each in (numbers.fibres, numbers.fabric)
    )
    network = (replace(each, stiffness=factor * each.stiffness) for each in numbers.network)
    return replace(
        numbers,
        network=tuple(network),
        shear=factor * numbers.shear,
        bulk=factor * numbers.bulk,
        yeoh=factor * numbers.yeoh,
        cubic=factor * numbers.cubic,
        gent=(factor * numbers.gent[0], numbers.gent[1]),
        fung=(factor * numbers.fung[0], numbers.fung[1]),
        hart_smith=(factor * numbers.hart_smith[0], numbers.hart_smith[1]),
        invariant=factor * numbers.invariant,
        squares=factor * numbers.squares,
        rest=factor * numbers.rest,
        fibres=fibres,
        fabric=fabric,
    )


@dataclass(frozen=True)
class Response:
    """Energy and its derivatives by F, written with F and its cofactor C.

    stress = along F + pressure C + 4 squares F F^T F; its derivative along dF is
    along dF + stretch (F:dF) F + bulk (C:dF) C + pressure dC and that of the last term.
    Fibres are in the energy alone: they have a stress and a stiffness of their own.
    """

    energy: FloatArray
    along: FloatArray
    pressure: FloatArray
    stretch: FloatArray
    bulk: FloatArray
    cofactor: FloatArray
    squares: FloatArray


def respond(F: FloatArray, numbers: Constants) -> Response:
    """Evaluate the law at deformation gradients, shape (..., 3, 3)."""
    cofactor = cofactors(F)
    growth = np.einsum('...j,...j->...', F[..., 0, :], cofactor[..., 0, :]) - 1.0
    strain = np.einsum('...ij,...ij->...', F, F) - 3.0
    c = numbers.yeoh
    base = (_plain if numbers.is_plain else _stable)(growth, strain, numbers)
    energy = base.energy + c * strain**2
    more, slope, curve = _stiffening(strain, numbers)
    squares = np.broadcast_to(np.asarray(numbers.squares, dtype=float), strain.shape)
    if squares.any():
        right = np.swapaxes(F, -1, -2) @ F
        energy = energy + squares * (np.einsum('...ij,...ij->...', right, right) - 3.0)
    for family in numbers.families:
        energy = energy + family.energy(F)
    return Response(
        energy=energy + more - numbers.rest * growth,
        along=base.along + 4.0 * c * strain + 2.0 * slope,
        pressure=base.pressure - numbers.rest,
        stretch=base.stretch + 8.0 * c + 4.0 * curve,
        bulk=np.broadcast_to(base.bulk, strain.shape),
        cofactor=cofactor,
        squares=squares,
    )


@dataclass(frozen=True)
class _Base:
    """The law without what stiffens it: as in `Response`."""

    energy: FloatArray
    along: FloatArray
    pressure: FloatArray
    stretch: FloatArray
    bulk: FloatArray


def _stable(growth: FloatArray, strain: FloatArray, numbers: Constants) -> _Base:
    a, b = numbers.shear, numbers.bulk
    return _Base(
        energy=0.5 * a * (strain - np.log1p(0.25 * strain))
        + 0.5 * b * growth**2
        - 0.75 * a * growth,
        along=a * (1.0 - 1.0 / (strain + 4.0)),
        pressure=b * growth - 0.75 * a,
        stretch=2.0 * a / (strain + 4.0) ** 2,
        bulk=b,
    )


def _plain(growth: FloatArray, strain: FloatArray, numbers: Constants) -> _Base:
    mu = 0.75 * numbers.shear
    lam = numbers.bulk - 0.625 * numbers.shear
    # What is turned inside out has no logarithm: a line search turns back from there.
    volume = np.where(growth > -1.0, 1.0 + growth, np.nan)
    logarithm = np.log(volume)
    energy = 0.5 * mu * strain - mu * logarithm + 0.5 * lam * logarithm**2
    return _Base(
        energy=np.where(np.isfinite(logarithm), energy, np.inf),
        along=np.broadcast_to(mu, strain.shape),
        pressure=(lam * logarithm - mu) / volume,
        stretch=np.zeros(strain.shape),
        # It falls below zero only where a volume grew more than twofold.
        bulk=np.maximum(lam * (1.0 - logarithm) + mu, 0.0) / volume**2,
    )


def _stiffening(
    strain: FloatArray, numbers: Constants
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what depends on I - 3 alone beside the Yeoh term, and its two derivatives."""
    d, e = numbers.cubic, numbers.invariant
    # What is pressed together from all sides does not stiffen.
    drawn = np.maximum(strain, 0.0)
    # The half square of I in II, less its value at rest.
    energy = d * drawn**3 + 0.5 * e * ((strain + 3.0) ** 2 - 9.0)
    slope = 3.0 * d * drawn**2 + e * (strain + 3.0)
    curve = 6.0 * d * drawn + e
    mu, k = numbers.fung
    if k:
        grown = np.exp(k * strain)
        energy = energy + 0.5 * mu * ((grown - 1.0) / k - strain)
        slope, curve = slope + 0.5 * mu * (grown - 1.0), curve + 0.5 * mu * k * grown
    mu, k = numbers.hart_smith
    if k:
        # Beyond what a line search may try the slope stays as it is there.
        part = np.minimum(drawn, np.sqrt(_MOST / k))
        grown = np.exp(k * part**2)
        whole = 0.5 * np.sqrt(np.pi / k) * erfi(np.sqrt(k) * part) + grown * (drawn - part)
        energy = energy + 0.5 * mu * (whole - drawn)
        slope, curve = slope + 0.5 * mu * (grown - 1.0), curve + mu * k * part * grown
    mu, k = numbers.gent
    if not k:
        return energy, slope, curve
    # Beyond its limit a chain is as good as broken: a line search turns back from there.
    left = np.where(k * strain < 1.0, 1.0 - k * strain, np.nan)
    energy = energy + np.where(np.isfinite(left), -0.5 * mu * (np.log(left) / k + strain), np.inf)
    return energy, slope + 0.5 * mu * (1.0 / left - 1.0), curve + 0.5 * mu * k / left**2


def squares_stress(F: FloatArray, squares: FloatArray) -> FloatArray:
    """Return the stress of squares tr (F^T F)^2, shape (..., 3, 3)."""
    return 4.0 * squares[..., None, None] * (F @ np.swapaxes(F, -1, -2) @ F)


def squares_stiffness(F: FloatArray, squares: FloatArray) -> FloatArray:
    """Return its derivative: stress component iI by dF component jJ, shape (..., 3, 3, 3, 3)."""
    one = np.eye(3)
    right, left = np.swapaxes(F, -1, -2) @ F, F @ np.swapaxes(F, -1, -2)
    whole = (
        np.einsum('ij,...IJ->...iIjJ', one, right)
        + np.einsum('...iJ,...jI->...iIjJ', F, F)
        + np.einsum('...ij,IJ->...iIjJ', left, one)
    )
    return np.asarray(4.0 * squares[..., None, None, None, None] * whole)


def cofactors(F: FloatArray) -> FloatArray:
    """Return dJ/dF, shape (..., 3, 3): each row the cross product of the other two."""
    rows = [np.cross(F[..., (i + 1) % 3, :], F[..., (i + 2) % 3, :]) for i in range(3)]
    return np.stack(rows, axis=-2)
