# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effective moduli of a fit, read from its `result.json` and put in place of the material's."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
    """

    moduli: Mapping[str, float]
    poissons_ratios: Mapping[str, float]


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
            moduli={
                name.partition('.')[2]: float(own['effective']['value'])
                for name, own in fit['moduli'].items()
            },
            poissons_ratios={
                name: float(own['effective']) for name, own in fit['poissons_ratios'].items()
            },
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f'{path} is no result of `diffcal calibrate` ({error}): fit again, or give the scene '
            'file alone'
        ) from error


def with_effective(body: ExportedBody, numbers: EffectiveNumbers) -> ExportedBody:
    """Return the body with effective numbers; a field keeps its shape within each region."""
    modulus, ratio = body.youngs_modulus.copy(), body.poissons_ratio.copy()
    for number, name in enumerate(body.region_names):
        own = body.region == number
        value = numbers.moduli.get(name, numbers.moduli.get(''))
        ratio[own] = numbers.poissons_ratios.get(name, ratio[own])
        if value is not None:
            modulus[own] *= value / body.region_moduli[number]
    # Damping is a force of its own: it does not follow the stiffness.
    return replace(
        body,
        youngs_modulus=modulus,
        poissons_ratio=ratio,
        region_moduli=tuple(
            float(numbers.moduli.get(name, numbers.moduli.get('', own)))
            for name, own in zip(body.region_names, body.region_moduli, strict=True)
        ),
    )
