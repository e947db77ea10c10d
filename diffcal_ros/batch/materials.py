# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the bodies of a batch say of their materials, together."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
import math
from typing import Any

from diffcal_ros.batch.body_result import BodyResult, MaterialValue
from diffcal_ros.batch.outliers import find_outliers
from diffcal_ros.batch.random_effects import fit_random_effects, RandomEffects
from diffcal_ros.batch.shared_materials import find_shared_materials
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

FloatArray = NDArray[np.float64]

NOT_STATED = 'not stated'
# Numbers whose size is known in shares rather than in units; even in the logarithm.
_LOGARITHMIC = ('youngs_modulus', 'density', 'damping')


@dataclass(frozen=True)
class MaterialFit:
    """One material over all its bodies.

    Attributes:
        quantity: such as `youngs_modulus`.
        material: its name.
        unit: SI.
        bodies: whose fits may be used, shape (n,).
        values: of them, in `unit`, shape (n,).
        errors: standard errors that they do not share, in `unit`, shape (n,).
        is_outlier: which of them are not of the material of the others, shape (n,).
        effects: mean, spread and offsets of the others; of moduli and the like in the logarithm.
    """

    quantity: str
    material: str
    unit: str
    bodies: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    is_outlier: NDArray[np.bool_]
    effects: RandomEffects

    @property
    def is_logarithmic(self) -> bool:
        """Tell whether `effects` are of the logarithm."""
        return self.quantity in _LOGARITHMIC

    def in_unit(self, value: float) -> float:
        """Return a mean or the end of an interval of `effects` in `unit`."""
        return math.exp(value) if self.is_logarithmic else value

    @property
    def spread(self) -> float:
        """Standard deviation between bodies, in `unit`."""
        scale = self.in_unit(self.effects.mean) if self.is_logarithmic else 1.0
        return scale * self.effects.spread

    def as_dict(self) -> dict[str, Any]:
        """Return what batch.json holds of it."""
        own = self.effects
        kept = [name for name, out in zip(self.bodies, self.is_outlier, strict=True) if not out]
        return {
            'quantity': self.quantity,
            'material': self.material,
            'unit': self.unit,
            'bodies': list(self.bodies),
            'outliers': [
                name for name, out in zip(self.bodies, self.is_outlier, strict=True) if out
            ],
            'is_logarithmic': self.is_logarithmic,
            'mean': self.in_unit(own.mean),
            'mean_error': self._size(own.mean_error),
            'interval_95': [self.in_unit(end) for end in own.interval_95],
            'spread': self.spread,
            'spread_95': [self._size(end) for end in own.spread_95],
            'another_body_95': [self.in_unit(end) for end in own.prediction_95],
            'homogeneity_p': own.homogeneity_p,
            'offsets': {
                name: {'offset': offset, 'std_error': error}
                for name, offset, error in zip(
                    kept, own.offsets.tolist(), own.offset_errors.tolist(), strict=True
                )
            },
        }

    def _size(self, deviation: float) -> float:
        return deviation * (self.in_unit(self.effects.mean) if self.is_logarithmic else 1.0)


@dataclass(frozen=True)
class Comparison:
    """Whether two materials differ in a number.

    Attributes:
        quantity: such as `youngs_modulus`.
        materials: their names.
        difference: of the second from the first; of moduli and the like in the logarithm.
        std_error: of it.
        p: chance of such a difference if there were none, after Holm, of all pairs together.
    """

    quantity: str
    materials: tuple[str, str]
    difference: float
    std_error: float
    p: float


@dataclass(frozen=True)
class FoundMaterials:
    """Which bodies share a material, whatever the manifest says.

    Attributes:
        quantity: that tells.
        unit: SI.
        means: of the materials that were found, ascending, in `unit`.
        places: number of each body's material, from 0, by the body's name; None where unsure.
    """

    quantity: str
    unit: str
    means: tuple[float, ...]
    places: dict[str, int | None]


def fit_materials(results: Sequence[BodyResult]) -> list[MaterialFit]:
    """Fit every material that has a usable body; see `random_effects` for the model."""
    groups: dict[tuple[str, str], list[tuple[str, MaterialValue]]] = {}
    for name, value in _values(results):
        key = (value.quantity, value.material or NOT_STATED)
        groups.setdefault(key, []).append((name, value))
    return [_fit(*key, members) for key, members in sorted(groups.items())]


def compare_materials(fits: Sequence[MaterialFit]) -> list[Comparison]:
    """Compare the means of every two materials of a quantity.

    Student's t of the difference with the degrees of freedom of Welch and Satterthwaite; what the
    mesh may be off is in both errors. Several pairs are told together by Holm 1979.
    """
    found: list[Comparison] = []
    for quantity in dict.fromkeys(fit.quantity for fit in fits):
        own = [fit for fit in fits if fit.quantity == quantity and fit.effects.count > 1]
        pairs = [_comparison(*pair) for pair in combinations(own, 2)]
        found += _holm(pairs)
    return found


def find_materials(results: Sequence[BodyResult]) -> list[FoundMaterials]:
    """Tell which bodies share a material, from each quantity by itself."""
    by_quantity: dict[str, list[tuple[str, MaterialValue]]] = {}
    for name, value in _values(results):
        by_quantity.setdefault(value.quantity, []).append((name, value))
    return [_found(quantity, own) for quantity, own in sorted(by_quantity.items())]


def _values(results: Sequence[BodyResult]) -> list[tuple[str, MaterialValue]]:
    """List values of fits that may be used; of a body with several regions there are several."""
    listed = []
    for result in results:
        own = result.material_values() if result.is_usable else []
        counts = [value.quantity for value in own]
        for value in own:
            is_alone = counts.count(value.quantity) == 1
            name = result.body.name
            listed.append((name if is_alone else f'{name}, {value.material}', value))
    return listed


def _coordinates(
    quantity: str, members: Sequence[MaterialValue]
) -> tuple[FloatArray, FloatArray, float]:
    """Return values, errors, and the error that all share, even in the logarithm where it fits."""
    values = np.array([member.value for member in members])
    errors = np.array([member.error for member in members])
    mesh_errors = np.array([member.mesh_error for member in members])
    if quantity in _LOGARITHMIC:
        values, errors, mesh_errors = np.log(values), errors / values, mesh_errors / values
    return values, errors, float(np.sqrt(np.mean(mesh_errors**2)))


def _fit(
    quantity: str, material: str, members: Sequence[tuple[str, MaterialValue]]
) -> MaterialFit:
    own = [value for _, value in members]
    values, errors, shared_error = _coordinates(quantity, own)
    is_outlier = find_outliers(values, errors)
    return MaterialFit(
        quantity=quantity,
        material=material,
        unit=own[0].unit,
        bodies=tuple(name for name, _ in members),
        values=np.array([value.value for value in own]),
        errors=np.array([value.error for value in own]),
        is_outlier=is_outlier,
        effects=fit_random_effects(values[~is_outlier], errors[~is_outlier], shared_error),
    )


def _comparison(first: MaterialFit, second: MaterialFit) -> Comparison:
    one, two = first.effects, second.effects
    variances = one.mean_error**2, two.mean_error**2
    error = math.sqrt(sum(variances))
    freedom = sum(variances) ** 2 / (
        variances[0] ** 2 / (one.count - 1) + variances[1] ** 2 / (two.count - 1)
    )
    difference = two.mean - one.mean
    p = float(2.0 * t.sf(abs(difference) / error, freedom))
    return Comparison(first.quantity, (first.material, second.material), difference, error, p)


def _holm(pairs: Sequence[Comparison]) -> list[Comparison]:
    """Make each chance that of the whole family (Holm 1979)."""
    worst = 0.0
    adjusted: dict[int, float] = {}
    for rank, place in enumerate(sorted(range(len(pairs)), key=lambda k: pairs[k].p)):
        worst = max(worst, min((len(pairs) - rank) * pairs[place].p, 1.0))
        adjusted[place] = worst
    return [
        Comparison(pair.quantity, pair.materials, pair.difference, pair.std_error, adjusted[place])
        for place, pair in enumerate(pairs)
    ]


def _found(quantity: str, members: Sequence[tuple[str, MaterialValue]]) -> FoundMaterials:
    values, errors, _ = _coordinates(quantity, [value for _, value in members])
    found = find_shared_materials(values, errors)
    means = np.exp(found.means) if quantity in _LOGARITHMIC else found.means
    names = [name for name, _ in members]
    return FoundMaterials(
        quantity,
        members[0][1].unit,
        tuple(means.tolist()),
        dict(zip(names, found.places, strict=True)),
    )
