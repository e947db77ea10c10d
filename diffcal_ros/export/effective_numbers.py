# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effective moduli of a fit, read from its `result.json` and put in place of the material's."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import json
from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.export.exported_body import ExportedBody


@dataclass(frozen=True)
class EffectiveNumbers:
    """What a simulator needs in place of the material's numbers.

    Attributes:
        moduli: of each region by name, or of all under an empty name [Pa].
        poissons_ratios: of each region by name.
        dampings: by the rate of strain, of each region by name, or of all under an empty name
            [Pa s]; where there is none, swings die out as the material's do.
    """

    moduli: Mapping[str, float]
    poissons_ratios: Mapping[str, float]
    dampings: Mapping[str, float] = field(default_factory=dict)


def read_effective(path: Path, simulator: str) -> EffectiveNumbers | None:
    """Read what a fit found for a simulator; None where it was not asked for.

    Args:
        path: `result.json`.
        simulator: its name.

    Raises:
        InputError: when the file is there and no result.
    """
    if not path.is_file():
        return None
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        fit: dict[str, Any] | None = document.get('effective', {}).get(simulator)
        if fit is None:
            return None
        return EffectiveNumbers(
            moduli=_effective(fit['moduli']),
            poissons_ratios={
                name: float(own['effective']) for name, own in fit['poissons_ratios'].items()
            },
            dampings=_effective(fit.get('dampings', {})),
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f'{path} is no result of `diffcal calibrate` ({error}): fit again, or give the scene '
            'file alone'
        ) from error


def _effective(found: Mapping[str, Any]) -> dict[str, float]:
    """Return effective values by region: `youngs_modulus.tip` is of `tip`."""
    return {
        name.partition('.')[2]: float(own['effective']['value']) for name, own in found.items()
    }


def with_effective(body: ExportedBody, numbers: EffectiveNumbers) -> ExportedBody:
    """Return the body with effective numbers; a field keeps its shape within each region.

    Rayleigh's factor on the stiffness stays the material's where no damping was found: effective
    numbers make the simulator's body as stiff as the real one, so that the factor, which is
    damping over stiffness, is the same in both.
    """
    modulus, ratio = body.youngs_modulus.copy(), body.poissons_ratio.copy()
    for number, name in enumerate(body.region_names):
        own = body.region == number
        value = numbers.moduli.get(name, numbers.moduli.get(''))
        ratio[own] = numbers.poissons_ratios.get(name, ratio[own])
        if value is not None:
            modulus[own] *= value / body.region_moduli[number]
    stiff = replace(body, youngs_modulus=modulus, poissons_ratio=ratio)
    damping = body.stiffness_damping * stiff.damping_of_stiffness
    for number, name in enumerate(body.region_names):
        found = numbers.dampings.get(name, numbers.dampings.get(''))
        if found is not None:
            damping[body.region == number] = found
    return replace(
        stiff,
        damping=damping,
        region_moduli=tuple(
            float(numbers.moduli.get(name, numbers.moduli.get('', own)))
            for name, own in zip(body.region_names, body.region_moduli, strict=True)
        ),
    )
