# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The same fit under each energy law, ranked by the gap on pixels that the fit has not seen.

All laws have the same parameters, so none wins by having more of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.held_out import held_out_gap
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.fem.laws import law_names
from diffcal_ros.scene.law_choice import with_law
from diffcal_ros.scene.model import Scene


@dataclass(frozen=True)
class LawFit:
    """One law's fit.

    Attributes:
        law: its name.
        calibration: under it, at its end; None where it could not even start.
        result: of the calibration, over all pixels; None likewise.
        held_out: gap where fits to a half of the pixels have not looked; None likewise.
        failure: why there is none; empty where there is one.
    """

    law: str
    calibration: Calibration | None = None
    result: CalibrationResult | None = None
    held_out: Gap | None = None
    failure: str = ''

    @property
    def is_fitted(self) -> bool:
        """Tell whether its parameters may be used."""
        return self.result is not None and self.result.outcome.is_fitted


def rank_laws(
    scene: Scene,
    observations: Sequence[Observation],
    settings: CalibrationSettings,
    *,
    laws: Sequence[str] | None = None,
    report: Callable[[str], None] = lambda _: None,
) -> tuple[LawFit, ...]:
    """Fit under each law and rank: what fits first, and of that the smallest held-out RMS gap.

    Args:
        scene: under any law.
        observations: that every law is fitted to.
        settings: how to fit; the loss must be the robust one.
        laws: names; default: all there are.
        report: called with what is being done.

    Raises:
        InputError: when the loss is another, or no law can be fitted.
    """
    if settings.loss != 'robust':
        raise InputError(
            f'laws are ranked by the robust loss, not {settings.loss!r}: leave --loss out'
        )
    fits = []
    for law in law_names() if laws is None else laws:
        report(f'fitting under {law}')
        fits.append(_fit(with_law(scene, law), observations, settings))
    if all(fit.result is None for fit in fits):
        raise InputError('no law can be fitted: ' + '; '.join(fit.failure for fit in fits))
    return tuple(sorted(fits, key=_order))


def _fit(
    scene: Scene, observations: Sequence[Observation], settings: CalibrationSettings
) -> LawFit:
    try:
        calibration = Calibration(scene, observations, settings)
        fit = LawFit(scene.law, calibration, calibration.run())
        gap = held_out_gap(scene, observations, settings, calibration.coordinates)
    except InputError as error:
        # One law may have no equilibrium where another has: that is a result, too.
        return LawFit(scene.law, failure=str(error))
    return replace(fit, held_out=gap)


def _order(fit: LawFit) -> tuple[bool, bool, float]:
    gap = float('inf') if fit.held_out is None else fit.held_out.rms
    return fit.held_out is None, not fit.is_fitted, gap
