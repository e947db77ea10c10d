# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the body in a depth image: a place for it, its modulus, and where its clamp begins."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.proposal.bent_shape import bent_shapes
from diffcal_ros.proposal.hold import possible_holds
from diffcal_ros.proposal.level import level_placement
from diffcal_ros.proposal.place_fit import fit_place, PlaceFit, WIDE
from diffcal_ros.proposal.place_search import Candidate, PlaceSearch
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Tell = Callable[[str], None]

# Places nearer than this are one part of space [m]; so many parts are fitted, so often each.
_PART, _PARTS, _FITS = 0.05, 4, 5
# What is not covered or not explained counts so much of it.
_UNEXPLAINED = 0.5
# A fit that did not settle, and one that would bend no less if it were stiffer, count against a
# place by so much.
_UNSETTLED, _UNBENT = 0.05, 0.12
_SETTLED = (Outcome.CONVERGED, Outcome.MODEL_DISAGREES, Outcome.AMBIGUOUS)
# The clamp's plane and the fit follow each other until the plane moves by less [m].
_PLANE_SETTLED, _ROUNDS = 0.0008, 4
# A pattern along a body, such as ribs, fits again a little farther on [m].
_SLIDES, _MOST_SLID = (-0.024, -0.016, -0.008, 0.0, 0.008, 0.016, 0.024), 2
_FEWEST_HELD = 3
# Another place is told where its merit comes this near.
_ALIKE = 0.1
# A pixel of the body that a person names is at most so far from where it is found [px].
_NEAR_PIXEL = 12.0


@dataclass(frozen=True)
class FoundBody:
    """Where the body is.

    Attributes:
        fit: of its place, with the elements of the scene.
        merit: how well image and fit speak for the place, 1 at best.
        rivals: merit and middle [m], shape (3,), of other places that come near, in the camera's
            frame.
        slides: plane of the clamp [m] in quick fits of the same place and of others along the body
            that come near.
    """

    fit: PlaceFit
    merit: float
    rivals: tuple[tuple[float, FloatArray], ...]
    slides: tuple[float, ...]


def find_body(
    scene: Scene,
    observation: Observation,
    *,
    pixel: tuple[float, float] | None = None,
    tell: Tell = lambda _: None,
) -> FoundBody | None:
    """Find a body in a depth image; None where nothing looks like it.

    Args:
        scene: mesh, material and gravity; its placement and clamp are not used.
        observation: the depth image, and the camera's pose.
        pixel: column and row of a pixel on the soft body; None: not known.
        tell: told what is being done.
    """
    setup = scene.observations[0]
    gravity = observation.depth_from_world[:3, :3] @ setup.gravity
    gravity /= np.linalg.norm(gravity)
    search = PlaceSearch(
        scene.mesh, observation.depth, observation.camera, gravity, _marker(scene, observation)
    )
    shapes = bent_shapes(
        scene.mesh, possible_holds(scene.mesh), scene.regions[0].density.start, tell
    )
    candidates = search.candidates(shapes, tell)
    if pixel is not None:
        candidates = [own for own in candidates if _shows(own, observation, pixel)]
    fits = _fitted(scene, observation, search, candidates, tell)
    if not fits:
        return None
    merit, best = fits[0]
    middle = best.points.mean(axis=0)
    rivals = tuple(
        (own, fit.points.mean(axis=0))
        for own, fit in fits[1:]
        if own > merit - _ALIKE and np.linalg.norm(fit.points.mean(axis=0) - middle) > _PART
    )
    tell('sliding the body along itself, where a pattern on it may fit as well')
    slid = _slid(scene, observation, search, fits)
    merit, best = slid[0]
    tell('fitting the place with the elements of the scene, and looking where the clamp begins')
    settled = _settled(scene, observation, best)
    return FoundBody(settled, merit, rivals, _slides_alike(slid))


def _marker(scene: Scene, observation: Observation) -> FloatArray | None:
    """Return the middle of the marker in the camera's frame [m], shape (3,); None: none."""
    if scene.marker is None:
        return None
    return apply(observation.depth_from_world, scene.marker.world_from_marker[:3, 3])


def _fitted(
    scene: Scene,
    observation: Observation,
    search: PlaceSearch,
    candidates: Sequence[Candidate],
    tell: Tell,
) -> list[tuple[float, PlaceFit]]:
    """Fit the best candidates of some parts of space; return them with merits, the best first."""
    chosen = [own for part in _parts(candidates)[:_PARTS] for own in part[:_FITS]]
    world_from_depth = inverse(observation.depth_from_world)
    found = []
    for number, own in enumerate(chosen, start=1):
        if number % 5 == 0 or number == len(chosen):
            tell(f'fitted {number} of {len(chosen)} places')
        placed = world_from_depth @ own.depth_from_object
        modulus = own.shape.youngs_modulus
        fit = fit_place(
            scene, observation, own.shape.hold, placed, modulus, is_quick=True, offset=WIDE
        )
        if fit is not None:
            found.append((_merit(scene, observation, search, fit), fit))
    return sorted(found, key=lambda one: -one[0])


def _parts(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Sort candidates, the best first, into parts of space."""
    parts: list[tuple[FloatArray, list[Candidate]]] = []
    for own in candidates:
        middle = own.points.mean(axis=0)
        near = [part for there, part in parts if np.linalg.norm(there - middle) < _PART]
        if near:
            near[0].append(own)
        else:
            parts.append((middle, [own]))
    return [part for _, part in parts]


def _merit(scene: Scene, observation: Observation, search: PlaceSearch, fit: PlaceFit) -> float:
    result, gap = fit.result, fit.result.gap_end
    merit = search.score(fit.candidate(scene.observations[0].gravity)) + 0.5 * (
        gap.coverage_in_sight * gap.explained - 1.0
    )
    if result.outcome not in _SETTLED:
        merit -= _UNSETTLED
    if result.outcome in (Outcome.NOT_IDENTIFIABLE, Outcome.AT_BOUND):
        merit -= _UNBENT
    return float(merit) if np.isfinite(merit) else -np.inf


def _slid(
    scene: Scene,
    observation: Observation,
    search: PlaceSearch,
    fits: Sequence[tuple[float, PlaceFit]],
) -> list[tuple[float, PlaceFit]]:
    """Fit the best places anew, level, and slid along themselves while the clamp stays.

    Returns:
        Merits and fits, the best first.
    """
    gravity = scene.observations[0].gravity
    found = list(fits[:1])
    for _, fit in [one for one in fits if one[0] > fits[0][0] - _ALIKE][:_MOST_SLID]:
        level = level_placement(
            fit.world_from_object, fit.hold.direction, gravity, _pivot(scene, fit)
        )
        for slide in _SLIDES:
            along = fit.hold.direction * slide
            placed = level.copy()
            placed[:3, 3] += level[:3, :3] @ along
            hold = fit.hold.moved(fit.clamp.plane - slide)
            if len(hold.vertices(scene.mesh)) < _FEWEST_HELD:
                continue
            again = fit_place(
                scene,
                observation,
                hold,
                placed,
                fit.youngs_modulus,
                is_quick=True,
                offset=scene.rigid_offset,
            )
            if again is not None:
                found.append((_merit(scene, observation, search, again), again))
    return sorted(found[1:] or found, key=lambda one: -one[0])


def _slides_alike(slid: Sequence[tuple[float, PlaceFit]]) -> tuple[float, ...]:
    """Return the clamp of the best slide, and of those of the same place that come near [m].

    Each fit sees its clamp sharply, but where the body itself is along its axis, none of them
    tells: what the plane may be is what they say together.
    """
    merit, best = slid[0]
    middle = best.points.mean(axis=0)
    return tuple(
        fit.clamp.plane
        for own, fit in slid
        if own > merit - _ALIKE
        and fit.clamp.is_seen
        and float(fit.hold.direction @ best.hold.direction) > 0.5
        and np.linalg.norm(fit.points.mean(axis=0) - middle) < _PART
    )


def _settled(scene: Scene, observation: Observation, first: PlaceFit) -> PlaceFit:
    """Let the clamp's plane and the fit with the scene's own elements follow each other."""
    fit, gravity = first, scene.observations[0].gravity
    for _ in range(_ROUNDS):
        hold = fit.hold.moved(fit.clamp.plane)
        if len(hold.vertices(scene.mesh)) < _FEWEST_HELD:
            break
        again = fit_place(
            scene,
            observation,
            hold,
            level_placement(fit.world_from_object, hold.direction, gravity, _pivot(scene, fit)),
            fit.youngs_modulus,
            is_quick=False,
            offset=scene.rigid_offset,
        )
        if again is None:
            break
        fit = again
        if abs(fit.clamp.plane - hold.plane) < _PLANE_SETTLED:
            break
    return fit


def _pivot(scene: Scene, fit: PlaceFit) -> FloatArray:
    """Return the middle of the held part, object frame [m], shape (3,)."""
    held = scene.mesh.rest_positions[fit.hold.vertices(scene.mesh)]
    middle: FloatArray = held.mean(axis=0)
    return middle


def _shows(candidate: Candidate, observation: Observation, pixel: tuple[float, float]) -> bool:
    seen = observation.camera.project(candidate.points)
    return bool(np.linalg.norm(seen - np.array(pixel), axis=1).min() < _NEAR_PIXEL)
