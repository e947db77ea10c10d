# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One fit from one random start, kept in a file so that it is never done twice."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import hashlib
import json
from pathlib import Path
from typing import Any
import zlib

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import Calibration, with_details
from diffcal_ros.calibration.field.fit import fit_field
from diffcal_ros.calibration.joint import JointCalibration
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.results.result import CalibrationResult, save_result
from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.offline.calibrate_recordings import describe_inputs, OfflineInputs
from diffcal_ros.reproduction.row import Variant
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
OnFitted = Callable[[Calibration, CalibrationResult], None]


def fit_from_start(
    inputs: Sequence[OfflineInputs],
    variant: Variant,
    number: int,
    path: Path,
    *,
    seed: str,
    on_fitted: OnFitted,
) -> None:
    """Fit from one start and write the result, or why there is none.

    Args:
        inputs: scene and recordings, of each member where there are several.
        variant: how to fit.
        number: of the start, from 0.
        path: JSON file to write.
        seed: name that the random numbers follow from; variants of a row share their starts.
        on_fitted: told of a single body's result before it is written.
    """
    mark = {'start': number, 'fingerprint': fingerprint(variant, seed)}
    try:
        calibration = _calibration(inputs, variant)
        start = start_coordinates(calibration.parameters, variant, random_of(seed, number))
        calibration.go_to(start)
        result = _with_own_start(_fitted(calibration, variant))
    except SceneError:
        raise
    except InputError as error:
        document = {'reproduce': mark, 'failure': str(error)}
        write_text_atomically(path, json.dumps(document, indent=2) + '\n')
        return
    described = describe_inputs(inputs[0], variant.settings) if len(inputs) == 1 else {}
    result = with_details(result, reproduce=mark, **described)
    if isinstance(calibration, Calibration):
        on_fitted(calibration, result)
    save_result(result, path)


def _fitted(calibration: Calibration | JointCalibration, variant: Variant) -> CalibrationResult:
    result = calibration.run()
    if not variant.modulus_field or isinstance(calibration, JointCalibration):
        return result
    field = fit_field(calibration, result)
    return with_details(field.result, field=field.as_dict())


def _calibration(
    inputs: Sequence[OfflineInputs], variant: Variant
) -> Calibration | JointCalibration:
    calibrations = [Calibration(own.scene, own.observations, variant.settings) for own in inputs]
    if not variant.members:
        return calibrations[0]
    names = [own.name for own in variant.members]
    return JointCalibration(dict(zip(names, calibrations, strict=True)), variant.shared)


def is_done(path: Path, variant: Variant, seed: str) -> bool:
    """Tell whether a file holds a finished fit of this very experiment."""
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError):
        return False
    mark = content.get('reproduce', {})
    return bool(mark.get('fingerprint') == fingerprint(variant, seed))


def random_of(seed: str, number: int) -> np.random.Generator:
    """Return the source of one start's numbers, the same on every machine."""
    return np.random.default_rng([zlib.crc32(seed.encode()), number])


def start_coordinates(
    parameters: ParameterSet, variant: Variant, random: np.random.Generator
) -> FloatArray:
    """Draw a start within the variant's ranges and the parameters' bounds, shape (k,)."""
    coordinates = parameters.start()
    lower, upper = parameters.bounds()
    for index, parameter in enumerate(parameters):
        limits = variant.start.get(
            parameter.name, variant.start.get(parameter.name.partition('.')[0])
        )
        # Every parameter takes a number, so that what one draws does not change the others'.
        fraction = random.uniform()
        if limits is not None:
            low, high = (parameter.coordinate(float(end)) for end in limits)
            coordinates[index] = low + fraction * (high - low)
    return np.clip(coordinates, lower, upper)


def fingerprint(variant: Variant, seed: str) -> str:
    """Return what changes when the experiment does, and not when there is more to say in rows."""
    content: dict[str, Any] = {**vars(variant), 'seed': seed}
    content['settings'] = {name: value for name, value in vars(variant.settings).items() if value}
    content['members'] = [fingerprint(own, seed) for own in variant.members]
    for words in ('title', 'paper', 'starts'):
        content.pop(words)
    stated = {name: value for name, value in content.items() if value}
    text = json.dumps(stated, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _with_own_start(result: CalibrationResult) -> CalibrationResult:
    """Say where this fit started, which is not where the scene does."""
    first = result.history[0].values
    own = tuple(replace(p, start=first[p.name]) for p in result.parameters)
    return replace(result, parameters=own)
