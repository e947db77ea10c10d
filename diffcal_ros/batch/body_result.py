# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What became of one body: its account, and the numbers of its result."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import json
import math
from typing import Any

from diffcal_ros.batch.job import Account, Job
from diffcal_ros.batch.manifest import Body
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.scene.reading.quantities import QUANTITY_RULES

_FILES = {'calibrate': 'result.json', 'diagnose': 'verdict.json'}


@dataclass(frozen=True)
class MaterialValue:
    """A material's number as one body has it.

    Attributes:
        quantity: such as `youngs_modulus`.
        material: name that the manifest gives it; empty where it gives none.
        value: of the body itself, the error of its mesh taken off, in `unit`.
        error: standard error that other bodies do not share, in `unit`.
        mesh_error: standard error of mesh and time step, which bodies cut alike share.
        unit: SI.
    """

    quantity: str
    material: str
    value: float
    error: float
    mesh_error: float
    unit: str


@dataclass(frozen=True)
class BodyResult:
    """One body after the batch.

    Attributes:
        body: as the manifest has it.
        account: of its command; None where nobody could do it.
        content: of its result.json or verdict.json; empty without.
        fault: why nobody could do it.
    """

    body: Body
    account: Account | None
    content: Mapping[str, Any] = field(default_factory=dict)
    fault: str = ''

    @property
    def ending(self) -> str:
        """The fit's outcome, the verdict, or `failed`."""
        return str(self.content.get('outcome') or self.content.get('verdict') or 'failed')

    @property
    def words(self) -> str:
        """Why it failed; empty where it did not."""
        return self.fault or (self.account.words if self.account else '')

    @property
    def is_usable(self) -> bool:
        """Tell whether its numbers may be used without a look."""
        return bool(self.content) and self.ending == Outcome.CONVERGED.value

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return the fitted parameters that were asked for, by name."""
        if self.body.command != 'calibrate':
            return {}
        found: dict[str, dict[str, Any]] = self.content.get('parameters', {})
        return {name: own for name, own in found.items() if not own['nuisance']}

    def material_values(self) -> list[MaterialValue]:
        """Return the numbers of its materials; those without an error are left out."""
        values = []
        for name, own in self.parameters().items():
            quantity, _, region = name.partition('.')
            if quantity not in QUANTITY_RULES:
                continue
            value = own['fine_mesh_value'] or own['value']
            whole, mesh = own['std_error'] or 0.0, own['mesh_error'] or 0.0
            error = math.sqrt(max(whole**2 - mesh**2, 0.0))
            if value and error > 0.0:
                material = self._material(region)
                values.append(MaterialValue(quantity, material, value, error, mesh, own['unit']))
        return values

    def _material(self, region: str) -> str:
        stated = self.body.material
        names = set(stated.values())
        # A number of all regions is of one material only where all are.
        only = names.pop() if len(names) == 1 and (not region or '' in stated) else ''
        return stated.get(region, only)


def read_result(body: Body, job: Job, account: Account | None, fault: str = '') -> BodyResult:
    """Read what a body's command has written."""
    if fault or account is None or not account.is_done:
        return BodyResult(body, account, fault=fault)
    try:
        text = (job.folder / _FILES[body.command]).read_text(encoding='utf-8')
        return BodyResult(body, account, json.loads(text))
    except (OSError, ValueError) as error:
        return BodyResult(body, account, fault=f'its result cannot be read ({error})')
