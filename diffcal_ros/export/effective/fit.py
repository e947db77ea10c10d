# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the moduli that a simulator needs to the recordings that the material's were fitted to."""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.posture import Posture, RestingPosture
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.export.effective.run_posture import RunPosture
from diffcal_ros.export.effective.shape_match import choose, match_shapes
from diffcal_ros.export.effective.simulators import find_run, Run, Simulator
from diffcal_ros.export.effective.target_scene import placed_observations, target_scene
from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.fem.laws import USUAL_LAW
from diffcal_ros.scene.model import Region, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_NOTHING = Gap(float('nan'), float('nan'), 0.0, 0)


@dataclass(frozen=True)
class EffectiveModulus:
    """One modulus as the material has it and as a simulator needs it.

    Attributes:
        name: as in the fit.
        material: of the material, the mesh's error taken off, as a small stretch measures it [Pa].
        material_std: standard error, the mesh's part included [Pa].
        effective: for the simulator's elements on this very mesh [Pa].
        effective_std: standard error [Pa].
    """

    name: str
    material: float
    material_std: float
    effective: float
    effective_std: float


@dataclass(frozen=True)
class EffectiveFit:
    """What a simulator needs, and what it leaves.

    Attributes:
        simulator: its name.
        way: what was simulated with, in words.
        is_run: the simulator itself was.
        moduli: one a fitted modulus.
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
    moduli: tuple[EffectiveModulus, ...]
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
            'moduli': {
                own.name: {
                    'material': {'value': own.material, 'std_error': own.material_std},
                    'effective': {'value': own.effective, 'std_error': own.effective_std},
                    'unit': 'Pa',
                }
                for own in self.moduli
            },
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


@dataclass(frozen=True)
class _TargetFit:
    """What every fit with a simulator's elements shares.

    Attributes:
        settings: of these fits.
        observations: of the calibration, with the cameras where that found them.
        own: the calibrated vertices as each camera sees them [m], shape (V, 3) each.
        names: of the moduli.
        run: the simulator; None: this package's model of its elements.
    """

    settings: CalibrationSettings
    observations: tuple[Observation, ...]
    own: list[FloatArray]
    names: tuple[str, ...]
    run: Run | None

    @classmethod
    def after(
        cls, calibration: Calibration, result: CalibrationResult, run: Run | None
    ) -> '_TargetFit':
        """Prepare them after a calibration and its result."""
        names, given = _fitted_moduli(calibration), calibration.settings
        final = _coordinates(calibration, result)
        return cls(
            CalibrationSettings(
                fit=names,
                solver=given.solver,
                device=given.device,
                with_mesh_error=False,
                search=False,
            ),
            placed_observations(calibration, final),
            calibrated_points(calibration, final),
            names,
            run,
        )

    def prepared(self, scene: Scene) -> Calibration:
        """Return a fit of the moduli in the simulator's scene."""

        def stand_in(index: int, own: Posture[Any]) -> Posture[Any]:
            assert isinstance(own, RestingPosture)
            assert self.run is not None
            return RunPosture(own, exported_body(scene, scene.observations[index]), self.run)

        return Calibration(
            scene, self.observations, self.settings, stand_in=stand_in if self.run else None
        )

    def matched(self, material: Scene) -> tuple[Scene, dict[str, float]]:
        """Return the scene with ratios for linear elements, and moduli to start from [Pa]."""
        both = (*self.names, Kind.POISSONS_RATIO.value)
        scene = replace(material, law=USUAL_LAW)
        linear = Calibration(scene, self.observations, replace(self.settings, fit=both))
        matches = match_shapes(linear, self.own)
        if not matches:
            raise InputError(
                'linear elements find no equilibrium with the calibrated moduli: take a finer mesh'
            )
        chosen = choose(matches)
        values = linear.parameters.values(chosen.coordinates)
        regions = tuple(_lowered(region, chosen.ceiling) for region in material.regions)
        return replace(material, regions=regions), values

    def look(self, target: Calibration, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap that the simulator leaves, and how far it is from the calibrated body."""
        try:
            gap = target.objective.gap(coordinates)
        except NotSimulatedError:
            return _NOTHING, float('nan')
        pairs = zip(target.model.views(coordinates), self.own, strict=True)
        return gap, max(
            float(np.linalg.norm(view.points - mine, axis=1).max()) for view, mine in pairs
        )


def _lowered(region: Region, ceiling: float) -> Region:
    """Return a region whose Poisson's ratio is not above a ceiling, and may be fitted below."""
    ratio = region.poissons_ratio
    lowered = replace(ratio, start=min(ratio.start, ceiling), lower=0.0)
    return replace(region, poissons_ratio=lowered)


def fit_effective(
    calibration: Calibration,
    result: CalibrationResult,
    fitted: Scene,
    simulator: Simulator,
    *,
    report: Callable[[str], None] = lambda _: None,
) -> EffectiveFit:
    """Fit the moduli that a simulator's elements need on the mesh of a fit.

    The simulator itself is run where it is installed and knows all that the scene has; this
    package's own model of its elements stands in for it elsewhere. Cameras and all the rest stay
    where the calibration found them; Poisson's ratio is lowered as far as the elements need it to
    take the calibrated shape, see `shape_match`.

    Args:
        calibration: that was run, with the robust loss.
        result: of it.
        fitted: its scene with fitted values as start values.
        simulator: that the moduli are for.
        report: called with what is being done.

    Raises:
        InputError: when no modulus was fitted, the loss has no likelihood, or the simulator finds
            no state to start from.
    """
    run, notes = _choose(fitted, simulator)
    target_fit = _TargetFit.after(calibration, result, run)
    way = _way(simulator, is_run=run is not None)
    report(f'{simulator.name}: the gap with the material, by {way}')
    # Where the simulator itself is run, the law only says where it begins.
    material = target_scene(fitted, simulator.law if run is None else USUAL_LAW)
    target = target_fit.prepared(material)
    start = _materials(target, result)
    gap_material, off_material = target_fit.look(target, start)
    report(f'{simulator.name}: linear elements in the shape of the calibrated body')
    scene, begin = target_fit.matched(material)
    report(f'{simulator.name}: fitting the effective modulus')
    fitter = target_fit.prepared(scene)
    fitter.go_to(_begin(fitter, begin))
    found = fitter.run()
    gap_effective, off_effective = target_fit.look(fitter, fitter.coordinates)
    return EffectiveFit(
        simulator=simulator.name,
        way=way,
        is_run=run is not None,
        moduli=tuple(
            _modulus(target, start, result[name], found[name]) for name in target_fit.names
        ),
        poissons_ratios=_ratios(material, scene),
        gap_material=gap_material,
        gap_effective=gap_effective,
        gap_own=result.gap_end,
        off_material=off_material,
        off_effective=off_effective,
        outcome=found.outcome,
        notes=notes,
    )


def _way(simulator: Simulator, *, is_run: bool) -> str:
    """Say what the moduli are fitted with."""
    if is_run:
        return f'{simulator.name} itself, derivatives by differences'
    return f"this package's linear elements under {simulator.law} ({simulator.kinship})"


def _begin(fitter: Calibration, values: dict[str, float]) -> FloatArray:
    start = fitter.parameters.start()
    for index, parameter in enumerate(fitter.parameters):
        if parameter.kind is Kind.YOUNGS_MODULUS:
            start[index] = parameter.coordinate(values[parameter.name])
    return start


def _ratios(material: Scene, scene: Scene) -> dict[str, tuple[float, float]]:
    pairs = zip(material.regions, scene.regions, strict=True)
    return {
        first.name: (first.poissons_ratio.start, second.poissons_ratio.start)
        for first, second in pairs
    }


def _fitted_moduli(calibration: Calibration) -> tuple[str, ...]:
    calibration.likelihood('--for')
    names = tuple(own.name for own in calibration.parameters if own.kind is Kind.YOUNGS_MODULUS)
    if not names:
        raise InputError(
            "no Young's modulus was fitted, and --for fits what a simulator needs in its place: "
            "add youngs_modulus to 'fit'"
        )
    return names


def _choose(scene: Scene, simulator: Simulator) -> tuple[Run | None, tuple[str, ...]]:
    """Return how the simulator is run, or None and why not."""
    run = find_run(simulator)
    if run is None:
        if not simulator.package:
            return None, (f'{simulator.name} itself was not run: only its elements are modelled',)
        return None, (
            f'{simulator.name} is not installed, so only its elements are modelled: '
            f"`pip install 'diffcal_ros[{simulator.package}]'` runs it",
        )
    reason = _beyond_runs(scene)
    if reason:
        return None, (f'{simulator.name} itself was not run: {reason}',)
    return run, ()


def _beyond_runs(scene: Scene) -> str:
    """Say what of a scene no simulator is given; empty for nothing."""
    if any(setup.motion is not None for setup in scene.observations):
        return 'the body moves, and simulators are run to rest only'
    if any(part.turn is not None for setup in scene.observations for part in setup.held):
        return 'the clamp turns, and simulators are given one that stays'
    if scene.cables:
        return 'the scene has cables'
    others = [name for name in scene.effects if EFFECTS[name].group != 'sensor']
    return f'the scene has effects ({", ".join(others)})' if others else ''


def _coordinates(calibration: Calibration, result: CalibrationResult) -> FloatArray:
    """Return where the calibration ended, shape (k,)."""
    return np.array([own.coordinate(result[own.name].value) for own in calibration.parameters])


def calibrated_points(calibration: Calibration, coordinates: FloatArray) -> list[FloatArray]:
    """Return the calibrated vertices as each camera sees them [m], shape (V, 3) each."""
    count = calibration.scene.mesh.vertex_count
    return [view.points[:count].copy() for view in calibration.model.views(coordinates)]


def _materials(target: Calibration, result: CalibrationResult) -> FloatArray:
    """Return the coordinates of the material itself: the mesh's error is not in its moduli."""
    start = target.parameters.start()
    for index, parameter in enumerate(target.parameters):
        if parameter.kind is Kind.YOUNGS_MODULUS:
            start[index] += math.log(_fine(result[parameter.name]) / result[parameter.name].value)
    return start


def _fine(fitted: FittedParameter) -> float:
    return fitted.fine_value if math.isfinite(fitted.fine_value) else fitted.value


def _modulus(
    target: Calibration, start: FloatArray, material: FittedParameter, found: FittedParameter
) -> EffectiveModulus:
    """Put both moduli together.

    The simulator's own fit knows cameras as the calibration found them, so its error lacks their
    doubt. What moves one modulus moves the other in proportion: the relative error is at least
    the statistical one of the material.
    """
    index = target.parameters.names.index(found.name)
    value = target.parameters.parameters[index].value(start[index])
    relative = max(material.error_in_model / material.value, found.std_error / found.value)
    return EffectiveModulus(
        name=found.name,
        material=value,
        material_std=material.std_error * value / material.value,
        effective=found.value,
        effective_std=relative * found.value,
    )
