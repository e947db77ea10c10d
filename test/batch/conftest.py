# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies with results, made without any fit."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from diffcal_ros.batch.body_result import BodyResult
from diffcal_ros.batch.job import Account
from diffcal_ros.batch.manifest import Body
import pytest


@pytest.fixture
def fitted() -> Callable[..., BodyResult]:
    """Make a body whose modulus was fitted: `fitted(name, material, value, error)`."""
    return _fitted


def _fitted(
    name: str,
    material: str | dict[str, str],
    value: float,
    error: float,
    *,
    mesh_error: float = 0.0,
    outcome: str = 'converged',
    parameter: str = 'youngs_modulus',
) -> BodyResult:
    by_region = {'': material} if isinstance(material, str) else material
    body = Body(name, 'calibrate', Path('scene.yaml'), (), by_region, ())
    account = Account(name, 0, 1.5, 1.2, 'here 1', 'now', ('calibrate',), 'abc')
    own: dict[str, Any] = {
        'value': 0.9 * value,
        'fine_mesh_value': value,
        'std_error': (error**2 + mesh_error**2) ** 0.5,
        'mesh_error': mesh_error,
        'interval_95': [value - 2.0 * error, value + 2.0 * error],
        'unit': 'Pa',
        'nuisance': False,
    }
    gap = {'end': {'median_mm': 0.4, 'rms_mm': 0.9, 'coverage': 0.95}}
    content = {'outcome': outcome, 'parameters': {parameter: own}, 'gap': gap}
    return BodyResult(body, account, content)
