# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a recording that nobody has made yet would add to what is known.

Around the fitted values the model predicts the depth of a candidate, and how it follows the
parameters. With H and S the information and the gradient's covariance of what was seen (see
`uncertainty`), and h the information of the candidate, its own camera pose averaged out, the
covariance would be

    C' = (H + h)^-1 (S + r h) (H + h)^-1,

r being how much more the gradient scatters in the fit than its information says.
"""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameter_layout import camera_pose_parameters
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.uncertainty.uncertainty import covariance_of
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.model import ObservationSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SMALLEST = 1e-12  # Of the largest eigenvalue: what is less is not known.


@dataclass(frozen=True)
class Candidate:
    """A recording that could be made.

    Attributes:
        name: short.
        words: what to do.
        setup: posture of the body.
        camera: intrinsics of the depth camera.
        depth_from_world: its pose, shape (4, 4).
        pose_covariance: how well that pose would be known, see `Observation`; None: exactly.
    """

    name: str
    words: str
    setup: ObservationSetup
    camera: PinholeCamera
    depth_from_world: FloatArray
    pose_covariance: FloatArray | None = None


@dataclass(frozen=True)
class Known:
    """What is known after a fit, or expected from recordings that are planned.

    Attributes:
        scene: the set-up.
        parameters: of the fit.
        coordinates: the fitted ones, shape (k,).
        scales: noise and correlation of the residuals.
        information: of the data, shape (k, k), without priors.
        gradient_covariance: of the gradient, shape (k, k), without priors.
    """

    scene: Scene
    parameters: ParameterSet
    coordinates: FloatArray
    scales: Scales
    information: FloatArray
    gradient_covariance: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """Of the coordinates, shape (k, k)."""
        return covariance_of(self.information, self.gradient_covariance, self.parameters)

    @property
    def excess(self) -> float:
        """How much more the gradient scatters than the information says."""
        values, vectors = np.linalg.eigh(self.information)
        seen = values > _SMALLEST * values.max(initial=0.0)
        if not seen.any():
            return 1.0
        own = np.einsum('ij,ik,kj->j', vectors, self.gradient_covariance, vectors)[seen]
        return float(np.median(own / values[seen]))

    def with_candidate(self, candidate: Candidate, *, device: str = 'cpu') -> 'Known':
        """Return what would be known with one more recording.

        Raises:
            EquilibriumError: when the body has no equilibrium there.
            OutOfViewError: when the camera would not see it.
        """
        more = expected_information(self, candidate, device=device)
        return replace(
            self,
            information=self.information + more,
            gradient_covariance=self.gradient_covariance + self.excess * more,
        )


def known_after(fit: Calibration) -> Known:
    """Take what a finished fit with the robust loss knows.

    Raises:
        InputError: for another loss.
    """
    objective = fit.likelihood('what a fit knows')
    linear = objective.linearise(fit.coordinates)
    return Known(
        fit.scene,
        fit.parameters,
        fit.coordinates,
        objective.scales,
        linear.information,
        linear.gradient_covariance,
    )


def expected_information(known: Known, candidate: Candidate, *, device: str = 'cpu') -> FloatArray:
    """Return the information that a candidate would add on the fit's parameters, shape (k, k).

    Raises:
        EquilibriumError: when the body has no equilibrium there.
        OutOfViewError: when the camera would not see it.
    """
    scene = replace(known.scene, observations=(*known.scene.observations, candidate.setup))
    shared = [
        index
        for index, parameter in enumerate(known.parameters)
        if parameter.kind is not Kind.CAMERA_POSE
    ]
    covariance = candidate.pose_covariance
    own = () if covariance is None else tuple(camera_pose_parameters(0))
    parameters = ParameterSet(
        (*(known.parameters.parameters[index] for index in shared), *own),
        () if covariance is None else ((0, covariance),),
    )
    coordinates = np.concatenate([known.coordinates[shared], np.zeros(len(own))])
    objective = _matching_objective(scene, candidate, parameters, coordinates, device)
    information = objective.under(known.scales).linearise(coordinates).information
    result = np.zeros((len(known.parameters), len(known.parameters)))
    result[np.ix_(shared, shared)] = _averaged(information, len(shared), covariance)
    return result


def _matching_objective(
    scene: Scene,
    candidate: Candidate,
    parameters: ParameterSet,
    coordinates: FloatArray,
    device: str,
) -> RobustObjective:
    """Compare the candidate with the very depth that the model expects of it."""
    blank = Observation(
        name=candidate.name,
        setup_index=len(scene.observations) - 1,
        depth=np.full((candidate.camera.height, candidate.camera.width), np.nan, dtype=np.float32),
        camera=candidate.camera,
        depth_from_world=candidate.depth_from_world,
        pose_covariance=candidate.pose_covariance,
    )
    model = ForwardModel(scene, [blank], parameters, device=device)
    objective = RobustObjective(model, device=device)
    (view,), (comparer,) = model.views(coordinates), objective.comparers
    read = comparer.read(view.trace, model.sensor(coordinates, 0))
    comparer.show(view.trace.in_image(read).astype(np.float32))
    return objective


def _averaged(
    information: FloatArray, shared_count: int, pose_covariance: FloatArray | None
) -> FloatArray:
    """Average out the candidate's own camera pose, whose prior is its covariance."""
    ours = information[:shared_count, :shared_count]
    if pose_covariance is None:
        return ours
    cross = information[:shared_count, shared_count:]
    pose = information[shared_count:, shared_count:] + np.linalg.inv(pose_covariance)
    return ours - cross @ np.linalg.solve(pose, cross.T)
