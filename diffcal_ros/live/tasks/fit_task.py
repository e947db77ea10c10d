# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One fit in the background, told step by step."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
import threading

from diffcal_ros.calibration.calibrate import Calibration, with_details
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.result import (
    CalibrationResult,
    FittedParameter,
    IterationRecord,
)
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.live.frames.body_frames import body_frames, BodyFrames
from diffcal_ros.live.frames.release import require_rest
from diffcal_ros.live.inputs import Snapshot
from diffcal_ros.live.picture import draw_picture, Picture
from diffcal_ros.live.tasks.background import Post
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FitRequest:
    """What to fit.

    Attributes:
        scene: the set-up.
        snapshots: one a posture, or one swing; of the last its last observation is shown.
        settings: how to fit.
        start: values to start from in place of the scene's, in SI units by name.
    """

    scene: Scene
    snapshots: tuple[Snapshot, ...]
    settings: CalibrationSettings
    start: dict[str, float]

    def calibration(self) -> Calibration:
        """Prepare the fit.

        Raises:
            InputError: when something given is wrong.
        """
        return self.prepare()[0]

    def prepare(self) -> tuple[Calibration, tuple[str, ...]]:
        """Prepare the fit, and return what a person should know of its inputs beside it.

        Raises:
            InputError: when something given is wrong.
        """
        takes = [snapshot.take(self.scene) for snapshot in self.snapshots]
        observations = [seen for take in takes for seen in take.observations]
        notes = tuple(
            f'{snapshot.name}: {note}'
            for snapshot, take in zip(self.snapshots, takes, strict=True)
            for note in take.notes
        )
        return Calibration(self.scene, observations, self.settings), notes


@dataclass(frozen=True)
class FitStep:
    """An accepted step.

    Attributes:
        record: what is known after it.
        parameters: the same as parameters; standard errors are NaN, they exist at the end only.
        picture: what the model sees.
    """

    record: IterationRecord
    parameters: tuple[FittedParameter, ...]
    picture: Picture


@dataclass(frozen=True)
class FitEnd:
    """A fit that came to its end.

    Attributes:
        request: what was asked for, with what the fit has added to the model.
        result: what was found.
        calibration: the model, for the report; only the background thread may use it. None when
            it has to be made from the request.
        picture: what the model sees in the end.
        frames: where world and body are.
    """

    request: FitRequest
    result: CalibrationResult
    calibration: Calibration | None
    picture: Picture
    frames: BodyFrames


def fit(request: FitRequest, post: Post, stop: threading.Event) -> None:
    """Fit, and post a `FitStep` after every step and a `FitEnd` at the end.

    Raises:
        InputError: when something given is wrong.
    """
    calibration, notes = request.prepare()
    observations = calibration.model.observations
    calibration.go_to(_start(calibration, request.start))
    last = request.snapshots[-1]
    require_rest(calibration)

    def report(record: IterationRecord) -> bool:
        picture = _picture(calibration, observations, last)
        post(FitStep(record, _parameters(calibration, record), picture))
        return not stop.is_set()

    result = with_details(calibration.run(report), notes=list(notes))
    picture = _picture(calibration, observations, last)
    frames = body_frames(request.scene, calibration.model, calibration.coordinates)
    post(FitEnd(_completed(request, calibration), result, calibration, picture, frames))


def _completed(request: FitRequest, calibration: Calibration) -> FitRequest:
    """Return the request with what its fit has added to the model: who goes on needs it, too."""
    scene, settings = calibration.scene, request.settings
    added = tuple(name for name in scene.fit if name not in request.scene.fit)
    if settings.fit is not None:
        settings = replace(settings, fit=(*settings.fit, *added))
    return replace(request, scene=scene, settings=settings)


def _start(calibration: Calibration, values: dict[str, float]) -> FloatArray:
    """Return start coordinates, with those values that the parameters of this fit have."""
    lower, upper = calibration.parameters.bounds()
    start = calibration.parameters.start()
    for index, parameter in enumerate(calibration.parameters):
        if parameter.name in values:
            start[index] = parameter.coordinate(values[parameter.name])
    return np.clip(start, lower, upper)


def _parameters(calibration: Calibration, record: IterationRecord) -> tuple[FittedParameter, ...]:
    unknown = math.nan
    lower, upper = calibration.parameters.bounds()
    at_bound = (calibration.coordinates <= lower) | (calibration.coordinates >= upper)
    return tuple(
        FittedParameter(
            name=p.name,
            value=record.values[p.name],
            std_error=unknown,
            mesh_error=unknown,
            unit=p.unit,
            start=p.quantity.start,
            at_bound=bool(stopped),
            is_nuisance=p.is_nuisance,
        )
        for p, stopped in zip(calibration.parameters, at_bound, strict=True)
    )


def _picture(
    calibration: Calibration, observations: Sequence[Observation], snapshot: Snapshot
) -> Picture:
    model, observation = calibration.model, observations[-1]
    view = model.views(calibration.coordinates)[-1]
    last = len(model.observations) - 1
    read = calibration.objective.read_depth(last, view, calibration.coordinates)
    return draw_picture(
        view,
        view.trace.in_image(read),
        observation.depth,
        model.body(observation).discretisation.surface_triangles,
        observation.camera,
        snapshot.frame_of(observation),
    )
