# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a simulator needs, and what it leaves: the result of a fit for it."""

from dataclasses import dataclass
from typing import Any

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome


@dataclass(frozen=True)
class EffectiveValue:
    """One modulus or damping as the material has it and as a simulator needs it.

    Attributes:
        name: as in the fit.
        material: of the material, the mesh's error taken off; a modulus as a small stretch
            measures it [unit].
        material_std: standard error, the mesh's part included [unit].
        effective: for the simulator's elements on this very mesh [unit].
        effective_std: standard error [unit].
        unit: Pa or Pa s.
    """

    name: str
    material: float
    material_std: float
    effective: float
    effective_std: float
    unit: str

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds of it."""
        return {
            'material': {'value': self.material, 'std_error': self.material_std},
            'effective': {'value': self.effective, 'std_error': self.effective_std},
            'unit': self.unit,
        }


@dataclass(frozen=True)
class EffectiveFit:
    """What a simulator needs, and what it leaves.

    Attributes:
        simulator: its name.
        way: what was simulated with, in words.
        is_run: the simulator itself was.
        moduli: one a fitted modulus.
        dampings: by the rate of strain, at the effective moduli, as the exported body damps by
            them: one a fitted damping, where the simulator itself was let swing.
        poissons_ratios: of the material and for the simulator, by region.
        gap_material: that the simulator leaves with the material's moduli.
        gap_effective: with the effective ones.
        gap_own: that the calibration left with its own elements.
        off_material: how far its vertices are from the calibrated body's with the material's
            moduli, the largest [m].
        off_effective: with the effective ones.
        outcome: how the fit ended.
        notes: sentences for a person.
    """

    simulator: str
    way: str
    is_run: bool
    moduli: tuple[EffectiveValue, ...]
    dampings: tuple[EffectiveValue, ...]
    poissons_ratios: dict[str, tuple[float, float]]
    gap_material: Gap
    gap_effective: Gap
    gap_own: Gap
    off_material: float
    off_effective: float
    outcome: Outcome
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds of it."""
        return {
            'simulated_with': self.way,
            'simulator_was_run': self.is_run,
            'outcome': self.outcome.value,
            'moduli': {own.name: own.as_dict() for own in self.moduli},
            'dampings': {own.name: own.as_dict() for own in self.dampings},
            'poissons_ratios': {
                name: {'material': first, 'effective': second}
                for name, (first, second) in self.poissons_ratios.items()
            },
            'gap_with_material': self.gap_material.as_dict(),
            'gap_with_effective': self.gap_effective.as_dict(),
            'gap_of_calibration': self.gap_own.as_dict(),
            'largest_offset_with_material_mm': 1e3 * self.off_material,
            'largest_offset_with_effective_mm': 1e3 * self.off_effective,
            'notes': list(self.notes),
        }
