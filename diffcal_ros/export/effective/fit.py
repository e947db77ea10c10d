# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit what a simulator needs to the recordings that the material's numbers were fitted to."""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.body_factory import instants
from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import Posture, RestingPosture
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.export.effective.effective_fit import EffectiveFit, EffectiveValue
from diffcal_ros.export.effective.run_motion import RunMotion
from diffcal_ros.export.effective.run_posture import RunPosture
from diffcal_ros.export.effective.shape_match import choose, match_shapes, match_swing
from diffcal_ros.export.effective.simulators import find_run, find_swing, Simulator
from diffcal_ros.export.effective.target_scene import placed_observations, target_scene
from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.fem.laws import USUAL_LAW
from diffcal_ros.scene.model import Region, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_NOTHING = Gap(float('nan'), float('nan'), 0.0, 0)


@dataclass(frozen=True)
class _TargetFit:
    """What every fit with a simulator's elements shares.

    Attributes:
        settings: of these fits.
        observations: of the calibration, with the cameras where that found them.
        own: the calibrated vertices as each camera sees them [m], shape (V, 3) each.
        names: of the moduli.
        dampings: names of what the simulator's swings are fitted by besides.
        simulator: the moduli are for.
        is_run: the simulator itself is; else this package's model of its elements stands in.
    """

    settings: CalibrationSettings
    observations: tuple[Observation, ...]
    own: list[FloatArray]
    names: tuple[str, ...]
    dampings: tuple[str, ...]
    simulator: Simulator
    is_run: bool

    @classmethod
    def after(
        cls,
        calibration: Calibration,
        result: CalibrationResult,
        simulator: Simulator,
        *,
        is_run: bool,
    ) -> '_TargetFit':
        """Prepare them after a calibration and its result."""
        names, given = _fitted_moduli(calibration), calibration.settings
        final = _coordinates(calibration, result)
        dampings = tuple(
            own.name for own in calibration.parameters if is_run and own.kind is Kind.DAMPING
        )
        return cls(
            CalibrationSettings(
                fit=(*names, *dampings),
                solver=given.solver,
                device=given.device,
                with_mesh_error=False,
                search=False,
            ),
            placed_observations(calibration, final),
            calibrated_points(calibration, final),
            names,
            dampings,
            simulator,
            is_run,
        )

    def prepared(self, scene: Scene) -> Calibration:
        """Return a fit of moduli, and dampings, in the simulator's scene."""

        def stand_in(index: int, own: Posture[Any]) -> Posture[Any]:
            return self._stand_in(scene, index, own)

        return Calibration(
            scene, self.observations, self.settings, stand_in=stand_in if self.is_run else None
        )

    def _stand_in(self, scene: Scene, index: int, own: Posture[Any]) -> Posture[Any]:
        """Return the simulator in the place of one observation's body."""
        setup = scene.observations[index]
        body = exported_body(scene, setup)
        if isinstance(own, RestingPosture):
            run = find_run(self.simulator)
            assert run is not None
            return RunPosture(own, body, run)
        assert isinstance(own, MovingPosture)
        swing = find_swing(self.simulator)
        assert swing is not None
        times = instants(self.observations, index)
        own_law = replace(scene, law=self.simulator.law)
        return RunMotion(own, own_law, setup, times, body, swing)

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

    def swung(self, target: Calibration, start: FloatArray) -> tuple[Outcome, dict[str, float]]:
        """Match the calibrated motion by the simulator's; return how that went, and its numbers.

        Not by images: linear elements leave millimetres in them, of which a robust loss makes
        little, and a swing that is too fast or too lively less still.
        """
        found = match_swing(target, self.own, start)
        if found is None:
            raise InputError(
                f"{self.simulator.name} finds no motion with the numbers that this package's "
                'linear elements need: take a finer mesh'
            )
        target.go_to(found.coordinates)
        values = target.parameters.values(found.coordinates)
        names = (*self.names, *self.dampings)
        outcome = Outcome.CONVERGED if found.is_settled else Outcome.NOT_CONVERGED
        return outcome, {name: values[name] for name in names}

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
    is_run, notes = _choose(fitted, simulator)
    target_fit = _TargetFit.after(calibration, result, simulator, is_run=is_run)
    way = _way(simulator, is_run=is_run)
    report(f'{simulator.name}: the gap with the material, by {way}')
    # Where the simulator itself is run, the law only says where it begins.
    material = target_scene(fitted, USUAL_LAW if is_run else simulator.law)
    target = target_fit.prepared(material)
    start = _materials(target, result)
    gap_material, off_material = target_fit.look(target, start)
    report(f'{simulator.name}: linear elements in the shape of the calibrated body')
    scene, begin = target_fit.matched(material)
    report(f'{simulator.name}: fitting the effective modulus')
    fitter = target_fit.prepared(scene)
    outcome, values, errors = _fitted_from(target_fit, fitter, _begin(fitter, begin))
    gap_effective, off_effective = target_fit.look(fitter, fitter.coordinates)
    return EffectiveFit(
        simulator=simulator.name,
        way=way,
        is_run=is_run,
        moduli=tuple(
            _modulus(target, start, result[name], values[name], errors[name])
            for name in target_fit.names
        ),
        dampings=tuple(_damping(result[name], values[name]) for name in target_fit.dampings),
        poissons_ratios=_ratios(material, scene),
        gap_material=gap_material,
        gap_effective=gap_effective,
        gap_own=result.gap_end,
        off_material=off_material,
        off_effective=off_effective,
        outcome=outcome,
        notes=notes,
    )


def _fitted_from(
    target_fit: _TargetFit, fitter: Calibration, start: FloatArray
) -> tuple[Outcome, dict[str, float], dict[str, float]]:
    """Fit from a start; return how it ended, values by name, and errors of the moduli."""
    if target_fit.dampings:
        outcome, values = target_fit.swung(fitter, start)
        return outcome, values, dict.fromkeys(values, 0.0)
    fitter.go_to(start)
    found = fitter.run()
    errors = {name: found[name].std_error for name in target_fit.names}
    return found.outcome, found.values(), errors


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


def _choose(scene: Scene, simulator: Simulator) -> tuple[bool, tuple[str, ...]]:
    """Tell whether the simulator itself is run, or why not."""
    if find_run(simulator) is None:
        if not simulator.package:
            return False, (f'{simulator.name} itself was not run: only its elements are modelled',)
        return False, (
            f'{simulator.name} is not installed, so only its elements are modelled: '
            f"`pip install 'diffcal_ros[{simulator.package}]'` runs it",
        )
    reason = _beyond_runs(scene)
    if reason:
        return False, (f'{simulator.name} itself was not run: {reason}',)
    return True, ()


def _beyond_runs(scene: Scene) -> str:
    """Say what of a scene no simulator is given; empty for nothing."""
    motions = [own.motion for own in scene.observations if own.motion is not None]
    if any(motion.is_slow for motion in motions):
        return 'the body creeps, and simulators are given no creep'
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
    target: Calibration, start: FloatArray, material: FittedParameter, value: float, error: float
) -> EffectiveValue:
    """Put both moduli together.

    The simulator's own fit knows cameras as the calibration found them, so its error lacks their
    doubt. What moves one modulus moves the other in proportion: the relative error is at least
    the statistical one of the material.
    """
    index = target.parameters.names.index(material.name)
    own = target.parameters.parameters[index].value(start[index])
    relative = max(material.error_in_model / material.value, error / value)
    return EffectiveValue(
        name=material.name,
        material=own,
        material_std=material.std_error * own / material.value,
        effective=value,
        effective_std=relative * value,
        unit='Pa',
    )


def _damping(material: FittedParameter, value: float) -> EffectiveValue:
    """Put both dampings together; errors as for moduli."""
    return EffectiveValue(
        name=material.name,
        material=_fine(material),
        material_std=material.std_error,
        effective=value,
        effective_std=material.error_in_model / material.value * value,
        unit='Pa s',
    )
