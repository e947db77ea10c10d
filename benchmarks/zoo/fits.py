# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit a case from its far start and from the truth, and judge both answers."""

from collections.abc import Iterator, Mapping
import time
from typing import Any

from diffcal_ros import calibrate
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Scene
import numpy as np

from benchmarks.zoo.cases import Case

MODULUS = 'youngs_modulus'
CLAIM = 'converged'
_CLOSE = 0.03  # An answer this near is right, however small its interval.


def run_case(case: Case, settings: CalibrationSettings | None = None) -> dict[str, Any]:
    """Return what is kept of a case."""
    true = case.truth.youngs_modulus
    far = fit(case.scene, case.observation, true, settings)
    near = fit(*case.from_truth(), true, settings)
    return {
        'case': case.name,
        'body': case.truth.solid.name,
        'clutter': list(case.kinds),
        'youngs_modulus': true,
        'poissons_ratio': case.truth.poissons_ratio,
        'sag': case.truth.sag,
        'seen_share': case.view.seen_share,
        'offset_mm_deg': [
            *(1e3 * case.offset[:3]).round(2).tolist(),
            *np.rad2deg(case.offset[3:]).round(2).tolist(),
        ],
        'start': case.scene.regions[0].youngs_modulus.start,
        'far': far,
        'near': near,
        'verdict': verdict(far),
        'is_tellable': verdict(near) == 'right',
    }


def fit(
    scene: Scene, observation: Observation, true: float, settings: CalibrationSettings | None
) -> dict[str, Any]:
    """Return outcome and answer of one fit; a refusal by an error is an outcome, too."""
    begun = time.perf_counter()
    try:
        result = calibrate(scene, [observation], settings)
    except InputError as error:
        return _refused('input_error', error, begun)
    except Exception as error:  # One that breaks is to be counted, not to end the study.
        return _refused('crashed', error, begun)
    modulus = result[MODULUS]
    alternatives = list(_moduli(getattr(result, 'alternatives', ())))
    return {
        'outcome': result.outcome.value,
        'value': modulus.value,
        'std_error': modulus.std_error,
        'mesh_error': getattr(modulus, 'mesh_error', float('nan')),
        'fine_value': modulus.fine_value,
        'interval_95': modulus.interval_95,
        'error': modulus.value / true - 1.0,
        'is_right': is_right(modulus.value, modulus.interval_95, true),
        'alternatives': alternatives,
        'has_truth': any(abs(np.log(value / true)) < _CLOSE for value in alternatives)
        or is_right(modulus.value, modulus.interval_95, true),
        'gap_median_mm': 1e3 * result.gap_end.median,
        'coverage': result.gap_end.coverage,
        'iterations': result.iterations,
        'seconds': time.perf_counter() - begun,
    }


def is_right(value: float, interval: tuple[float, float], true: float) -> bool:
    """Tell whether the truth lies in the 95 % interval or within 3 % of the value."""
    return bool(interval[0] <= true <= interval[1] or abs(value / true - 1.0) <= _CLOSE)


def verdict(answer: Mapping[str, Any]) -> str:
    """Return `right`, `wrong` (and said with confidence), `refused` or `crashed`."""
    if answer['outcome'] == 'crashed':
        return 'crashed'
    if answer['outcome'] != CLAIM:
        return 'refused'
    return 'right' if answer['is_right'] else 'wrong'


def _refused(outcome: str, error: Exception, begun: float) -> dict[str, Any]:
    return {
        'outcome': outcome,
        'message': f'{type(error).__name__}: {error}'[:400],
        'has_truth': False,
        'seconds': time.perf_counter() - begun,
    }


def _moduli(alternatives: Any) -> Iterator[float]:
    """Read the moduli of other answers, whichever way they are told."""
    for other in alternatives or ():
        values = other if isinstance(other, Mapping) else getattr(other, 'values', None)
        values = values() if callable(values) else values
        if isinstance(values, Mapping) and MODULUS in values:
            found = values[MODULUS]
            yield float(getattr(found, 'value', found))
