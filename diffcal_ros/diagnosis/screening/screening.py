# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Score every candidate by tangents at the nominal fit: one factorisation, no refit.

Residuals and tangents are whitened and the nuisances (modulus, density, pose, edges, mesh) are
projected out. What is left says how much each candidate could explain to first order. This
screens, it does not judge: an amplitude that is not small has another signature.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.led_there import lead_to
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import tangent_slack
from diffcal_ros.diagnosis.patches.patch_group import columns_of, PatchGroup, Rows, with_columns
from diffcal_ros.diagnosis.screening.candidates import Candidate, shown_effects
from diffcal_ros.diagnosis.screening.screen_sight import ScreenSight, seen_through
from diffcal_ros.diagnosis.screening.usual_sizes import sized
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

FloatArray = NDArray[np.float64]

_DETECTABLE_SIGMAS = 4.0
# The size of an effect and its amplitudes are found by turns.
_SIZINGS = 3


@dataclass(frozen=True)
class Score:
    """What a candidate could explain.

    Attributes:
        candidate: which.
        gain: fall of chi-square to first order.
        plain_gain: the same without allowance for the error of tangents.
        gain_by_pose: the same with amplitudes of its own in each pose, less their price.
        log_evidence: half of the gain less the price of its freedom.
        amplitudes: expected, SI units, in the order of the candidate's components.
        detectable: smallest amplitudes that would be seen, SI units.
        direction: what it would explain, whitened, nuisances projected out, shape (n,).
        columns: what its amplitudes do, likewise, shape (n, k).
        plain_columns: the same without allowance for the error of tangents.
        plain_residual: what there is to explain, likewise, shape (n,).
        follows: by how much a fit without it moves the parameters by unit of its amplitudes, where
            tangents tell, shape (p, k).
    """

    candidate: Candidate
    gain: float
    plain_gain: float
    gain_by_pose: float
    log_evidence: float
    amplitudes: FloatArray
    detectable: FloatArray
    direction: FloatArray
    columns: FloatArray
    plain_columns: FloatArray
    plain_residual: FloatArray
    follows: FloatArray

    @property
    def times_detectable(self) -> float:
        """Expected amplitude over the smallest detectable one.

        Of one amplitude the ratio is the root of what it explains in detectable standard
        deviations, and so it is of what stands in for an effect without a tangent.
        """
        if not self.candidate.effect.has_tangent:
            return float(np.sqrt(max(self.gain, 0.0))) / _DETECTABLE_SIGMAS
        return float(np.max(np.abs(self.amplitudes) / self.detectable))


@dataclass(frozen=True)
class Screen:
    """All scores at one set of coordinates.

    Attributes:
        scores: best first.
        chi_square: of the model as it is.
        noise_scale: chi-square per patch that no effect and no smooth mode explains, at least 1.
        patch_count: patches looked at.
        project: takes out of whitened patches, shape (n, ...), what nuisances explain.
    """

    scores: tuple[Score, ...]
    chi_square: float
    noise_scale: float
    patch_count: int
    project: Callable[[FloatArray], FloatArray]


def library_parameters(
    scene: Scene, nominal: ParameterSet, listed: Sequence[Candidate]
) -> ParameterSet:
    """Return the nominal parameters followed by every amplitude that has a tangent at zero."""
    extra = [
        name
        for candidate in listed
        if candidate.effect.has_tangent and not candidate.effect.screened_at
        for name in candidate.effect.fit_names(candidate.components)
    ]
    if not extra:
        return nominal
    more = make_parameters(scene, tuple(dict.fromkeys(extra)), with_edge_bias=False)
    return ParameterSet((*nominal.parameters, *more.parameters), nominal.pose_covariances)


def library_groups(
    evaluator: PatchEvaluator, coordinates: FloatArray, listed: Sequence[Candidate]
) -> tuple[tuple[str, ...], list[PatchGroup]]:
    """Return patches with tangents of all that may be missing, after those of the parameters.

    Args:
        evaluator: of the nominal model.
        coordinates: of its fit, shape (k,).
        listed: candidates.

    Returns:
        Names of the amplitudes, and of the effects whose stand-ins follow, and the patches.
    """
    nominal, scene = evaluator.model.parameters, evaluator.model.scene
    wide = library_parameters(scene, nominal, listed)
    start = wide.start()
    start[: len(nominal)] = coordinates
    model = evaluator.model.with_parameters(scene, wide)
    owners, changes = _stand_ins(model)
    lead_to(model, start)
    groups = evaluator.of(model).groups(start, model.tangents_of(changes, start))
    return (*wide.names[len(nominal) :], *owners), groups


def screen(
    evaluator: PatchEvaluator,
    coordinates: FloatArray,
    listed: Sequence[Candidate],
    beside: Rows | None = None,
) -> Screen:
    """Score candidates around a fit.

    Args:
        evaluator: of the nominal model.
        coordinates: of its fit, shape (k,).
        listed: candidates.
        beside: what else may move patches, in independent columns of size one [m], by the names
            of the patches: it is projected out, too. Found again a state shows the same patches
            but for some at the outline.
    """
    nominal = evaluator.model.parameters
    names, groups = library_groups(evaluator, coordinates, listed)
    if beside is not None:
        groups = with_columns(groups, columns_of(beside, groups))
    beyond = _beyond_prior(
        nominal, coordinates + evaluator.discretisation_error.shifts_of(nominal)
    )
    plain = seen_through(groups, nominal, names, beyond, 0.0)
    slack = tangent_slack(groups)
    held = plain if slack == 0.0 else seen_through(groups, nominal, names, beyond, slack)
    scores = [_seen_both_ways(candidate, held, plain) for candidate in listed]
    scores.sort(key=lambda score: -score.log_evidence)
    return Screen(
        scores=tuple(scores),
        chi_square=float(plain.residual @ plain.residual),
        noise_scale=_noise_scale(plain, len(nominal)),
        patch_count=len(plain.residual),
        project=plain.project,
    )


def _seen_both_ways(candidate: Candidate, held: ScreenSight, plain: ScreenSight) -> Score:
    score, other = _score(candidate, held), _score(candidate, plain)
    return replace(
        score,
        plain_gain=other.gain,
        plain_columns=other.columns,
        plain_residual=plain.residual,
        follows=other.follows,
    )


def _beyond_prior(parameters: ParameterSet, coordinates: FloatArray) -> FloatArray:
    """Return how far the coordinates are off their priors' means; 0 without one, shape (k,)."""
    mean, precision = parameters.prior()
    return np.where(np.diag(precision) > 0.0, coordinates - mean, 0.0)


def _stand_ins(
    model: ForwardModel,
) -> tuple[list[str], Callable[[int, StaticBody], list[Change]]]:
    """Return what stands in for effects in a posture, and whose each is.

    Those that are no candidates are there, too: the noise is what nothing explains.
    """
    shown = shown_effects(model.scene, ())

    def of_all(index: int, body: StaticBody) -> list[tuple[str, Change]]:
        site = model.effects.site(index, body.discretisation.rest_nodes)
        return [(own.identifier, change) for own in shown for change in own.stand_ins(site)]

    index, posture = next(iter(model.bodies.items()))
    owners = [owner for owner, _ in of_all(index, posture.body)]
    return owners, lambda index, body: [change for _, change in of_all(index, body)]


def _score(candidate: Candidate, sight: ScreenSight) -> Score:
    if not candidate.effect.has_tangent:
        return _one_sided_score(candidate, sight)
    own = sight.of(candidate)
    candidate = _as_large_as_seen(candidate, own, sight.residual)
    scales = candidate.likely_scales
    information = own.T @ own + np.diag(1.0 / scales**2)
    amplitudes = expected_amplitudes(candidate, own, sight.residual)
    gain = float(gains(candidate, own, sight.residual))
    volumes = float(np.linalg.slogdet(information * np.outer(scales, scales))[1])
    sensitivity = np.sqrt(np.maximum(np.diag(own.T @ own), 1e-300))
    return Score(
        candidate=candidate,
        gain=gain,
        plain_gain=gain,
        gain_by_pose=_gain_by_pose(candidate, own, sight) - volumes,
        log_evidence=0.5 * (gain - volumes),
        amplitudes=amplitudes,
        detectable=_DETECTABLE_SIGMAS / sensitivity,
        direction=own @ amplitudes,
        columns=own,
        plain_columns=own,
        plain_residual=sight.residual,
        follows=sight.follows_of(candidate),
    )


def _as_large_as_seen(
    candidate: Candidate, columns: FloatArray, residual: FloatArray
) -> Candidate:
    """Return a candidate of the size that is likeliest for what it explains."""
    for _ in range(_SIZINGS):
        amplitudes = expected_amplitudes(candidate, columns, residual)
        larger = sized(candidate, dict(zip(candidate.names, amplitudes, strict=True)))
        if larger.size <= candidate.size:
            break
        candidate = larger
    return candidate


def _gain_by_pose(candidate: Candidate, own: FloatArray, sight: ScreenSight) -> float:
    """Return how much chi-square falls with amplitudes of its own in each pose.

    Only of what may be another one in each pose by all of itself; else as if it were the same.
    """
    views = np.unique(sight.views)
    if candidate.effect.most_by_pose < 1.0 or len(views) < 2:
        return float(gains(candidate, own, sight.residual))
    scaled = own * candidate.likely_scales
    apart = np.hstack([scaled, *(scaled * (sight.views == view)[:, None] for view in views)])
    information = apart.T @ apart + np.eye(apart.shape[1])
    pull = apart.T @ sight.residual
    fall = float(pull @ np.linalg.solve(information, pull))
    return fall - float(np.linalg.slogdet(information)[1])


def expected_amplitudes(
    candidate: Candidate, columns: FloatArray, residuals: FloatArray
) -> FloatArray:
    """Return the amplitudes that explain residuals best within their priors and bounds.

    Args:
        candidate: with amplitudes that have tangents.
        columns: see `Score`, shape (n, k).
        residuals: one or several, shape (n, ...).

    Returns:
        SI units, shape (k, ...).
    """
    parts = candidate.parts
    precision = np.diag(1.0 / candidate.likely_scales**2)
    found = np.linalg.solve(columns.T @ columns + precision, columns.T @ residuals)
    if len(parts) == 1 or parts[0].lower == 0.0:
        found[0] = np.clip(found[0], parts[0].lower, parts[0].upper)
    return np.asarray(found)


def gains(candidate: Candidate, columns: FloatArray, residuals: FloatArray) -> FloatArray:
    """Return how much chi-square falls with the expected amplitudes, shape (...)."""
    scales = candidate.likely_scales
    amplitudes = expected_amplitudes(candidate, columns, residuals)
    left = residuals - columns @ amplitudes
    price = ((amplitudes.T / scales).T ** 2).sum(axis=0)
    return np.asarray((residuals**2).sum(axis=0) - (left**2).sum(axis=0) - price)


def _one_sided_score(candidate: Candidate, sight: ScreenSight) -> Score:
    """Score non-negative amounts of what stands in for an effect without a tangent."""
    columns = sight.of(candidate)
    # A pose that does not feel it feels nothing: each has amounts of its own.
    own = np.hstack([columns * (sight.views == view)[:, None] for view in np.unique(sight.views)])
    unit = own / np.maximum(np.linalg.norm(own, axis=0), 1e-300)
    amplitudes, _ = nnls(unit, sight.residual)
    explained = unit @ amplitudes
    gain = float(2.0 * explained @ sight.residual - explained @ explained)
    free = int((amplitudes > 0.0).sum())
    return Score(
        candidate=candidate,
        gain=gain,
        plain_gain=gain,
        gain_by_pose=gain,
        log_evidence=0.5 * gain - free * float(np.log(1.0 + np.sqrt(max(gain, 0.0)))),
        amplitudes=np.zeros(len(candidate.components)),
        detectable=np.full(len(candidate.components), np.nan),
        direction=explained,
        columns=own,
        plain_columns=own,
        plain_residual=sight.residual,
        follows=np.zeros((len(sight.follows), 0)),
    )


def _noise_scale(sight: ScreenSight, nuisances: int) -> float:
    """Estimate how much larger the noise is than said, from what nothing explains."""
    basis, values, _ = np.linalg.svd(sight.columns, full_matrices=False)
    basis = basis[:, values > 1e-9 * values.max()]
    left = sight.residual - basis @ (basis.T @ sight.residual)
    freedom = len(left) - basis.shape[1] - nuisances
    return max(1.0, float(left @ left) / freedom) if freedom > 0 else 1.0


def largest_cosines(scores: Sequence[Score]) -> dict[str, float]:
    """Return, by effect, the share of what it explains that another effect could explain too.

    The cosine is that between the direction of an effect's best variant and the space of all
    amplitudes of the other effect's.
    """
    best: dict[str, Score] = {}
    for score in scores:
        best.setdefault(score.candidate.identifier, score)
    found = {}
    for name, score in best.items():
        size = float(np.linalg.norm(score.direction))
        if size == 0.0:
            continue
        others = [_reach(other.columns, score.direction) for n, other in best.items() if n != name]
        found[name] = max(others, default=0.0) / size
    return found


def _reach(columns: FloatArray, direction: FloatArray) -> float:
    basis, values, _ = np.linalg.svd(columns, full_matrices=False)
    basis = basis[:, values > 1e-9 * max(float(values.max(initial=0.0)), 1e-300)]
    return float(np.linalg.norm(basis.T @ direction))
