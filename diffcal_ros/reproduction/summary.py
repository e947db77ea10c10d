# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What all starts of an experiment found together, read from their files."""

from collections.abc import Sequence
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.reproduction.row import Row, Variant
from diffcal_ros.reproduction.run_row import start_files
from diffcal_ros.reproduction.start_fit import is_done
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_RIG = 'rigid_offset'


@dataclass(frozen=True)
class Found:
    """One parameter over the starts.

    Attributes:
        name: as in the scene.
        unit: SI.
        values: at the end of each fit, shape (n,).
        starts: where each began, shape (n,).
        std_error: that the fits state, in the middle; NaN where none does.
    """

    name: str
    unit: str
    values: FloatArray
    starts: FloatArray
    std_error: float

    @property
    def mean(self) -> float:
        """Mean over the starts."""
        return float(np.mean(self.values))

    @property
    def deviation(self) -> float:
        """Standard deviation over the starts."""
        return float(np.std(self.values))

    @property
    def spread(self) -> float:
        """Largest less smallest value over the size of the mean."""
        return float(np.ptp(self.values) / max(abs(self.mean), 1e-300))


@dataclass(frozen=True)
class Summary:
    """One variant of a row.

    Attributes:
        variant: what was done.
        folder: where its files are.
        results: content of the starts' files that hold a fit.
        failures: why other starts have none.
        missing: starts that are not done yet.
    """

    variant: Variant
    folder: Path
    results: tuple[dict[str, Any], ...]
    failures: tuple[str, ...]
    missing: int

    @property
    def fitted(self) -> tuple[dict[str, Any], ...]:
        """Results whose parameters may be used."""
        return tuple(r for r in self.results if Outcome(r['outcome']).is_fitted)

    def parameters(self) -> list[Found]:
        """What was asked for, rig and sensor's nuisances aside, over the fits that may be used."""
        results = self.fitted or self.results
        if not results:
            return []
        first = results[0]['parameters']
        names = [name for name in first if not (name.startswith(_RIG) or first[name]['nuisance'])]
        return [
            Found(
                name,
                first[name]['unit'],
                _column(results, 'parameters', name, 'value'),
                _column(results, 'parameters', name, 'start'),
                float(np.median(_column(results, 'parameters', name, 'std_error'))),
            )
            for name in names
        ]

    def middle(self, *keys: str) -> float:
        """Return the median of one number over the fits that may be used; NaN without any."""
        results = self.fitted or self.results
        return float(np.median(_column(results, *keys))) if results else float('nan')

    def as_dict(self) -> dict[str, Any]:
        """Return what reproduce.json holds."""
        return {
            'name': self.variant.name,
            'title': self.variant.title,
            'starts': len(self.results) + len(self.failures) + self.missing,
            'fitted': len(self.fitted),
            'outcomes': [r['outcome'] for r in self.results],
            'failures': list(self.failures),
            'missing': self.missing,
            'parameters': {
                p.name: {
                    'unit': p.unit,
                    'mean': p.mean,
                    'deviation': p.deviation,
                    'spread': p.spread,
                    'std_error': p.std_error,
                    'values': p.values.tolist(),
                    'starts': p.starts.tolist(),
                }
                for p in self.parameters()
            },
            'iterations': self.middle('iterations'),
            'loss': {end: self.middle('loss', end) for end in ('start', 'end')},
            'gap': {
                end: {
                    key: self.middle('gap', end, key)
                    for key in ('median_mm', 'rms_mm', 'coverage')
                }
                for end in ('start', 'end')
            },
            'members': {
                own.name: {
                    key: self.middle('members', own.name, key)
                    for key in ('median_mm', 'rms_mm', 'coverage')
                }
                for own in self.variant.members
            },
            'seconds': self.middle('seconds'),
            'paper': dict(self.variant.paper),
        }


def summarise(row: Row, out: Path, starts: int) -> list[Summary]:
    """Read what is there of a row's variants."""
    return [_summary(row, variant, out, starts) for variant in row.variants]


def _summary(row: Row, variant: Variant, out: Path, starts: int) -> Summary:
    files = start_files(row, variant, out, starts)
    done = [path for path in files if is_done(path, variant, row.name)]
    contents = [json.loads(path.read_text(encoding='utf-8')) for path in done]
    return Summary(
        variant=variant,
        folder=out / row.name / variant.name,
        results=tuple(content for content in contents if 'failure' not in content),
        failures=tuple(content['failure'] for content in contents if 'failure' in content),
        missing=len(files) - len(done),
    )


def _column(results: Sequence[dict[str, Any]], *keys: str) -> FloatArray:
    """Return one number of each result, NaN where it is not known, shape (n,)."""
    column = []
    for result in results:
        value: Any = result
        for key in keys:
            value = value[key]
        column.append(float('nan') if value is None else float(value))
    return np.array(column)
