# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The figures of a verdict: gaps, amplitudes, parameters, and how it came to them."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.diagnosis.detection.limits import Drawn, drawn_parameters
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.held_out_frames import told_frame_by_frame
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import is_strained, unstrained
from diffcal_ros.diagnosis.patches.patch_gap import closed_fraction, patch_gap, PatchGap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Screen, screen
from diffcal_ros.diagnosis.verdict.effect_course import course_of
from diffcal_ros.diagnosis.verdict.poses_in_doubt import with_poses_in_doubt
from diffcal_ros.diagnosis.verdict.verdict import GapFigures, NamedEffect
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Less of its usual size is nothing to speak of.
_LEAST_OF_FORM = 0.01


def named_effects(
    hypothesis: Hypothesis, confidences: Mapping[str, float]
) -> tuple[NamedEffect, ...]:
    """Describe those effects of a model that have a confidence, by identifier."""
    found = []
    for candidate in hypothesis.added:
        if candidate.identifier not in confidences:
            continue
        amplitudes = hypothesis.amplitudes(candidate)
        found.append(
            NamedEffect(
                identifier=candidate.identifier,
                group=candidate.effect.group,
                amplitude={a.name: a.value for a in amplitudes},
                std_error={a.name: a.std_error for a in amplitudes},
                unit={a.name: a.unit for a in amplitudes},
                setting=settings_of(hypothesis, candidate),
                frame=frame_of(
                    candidate.identifier, hypothesis.evaluator.model, hypothesis.fit.coordinates
                ),
                confidence=min(
                    confidences[candidate.identifier], candidate.effect.most_confidence
                ),
                sentence=candidate.effect.sentence,
                outside_twins=candidate.effect.outside_twins,
                form=form_of(hypothesis, candidate),
                course=course_of(hypothesis, candidate),
            )
        )
    return tuple(found)


def settings_of(hypothesis: Hypothesis, candidate: Candidate) -> dict[str, float]:
    """Return the fixed numbers that go with an effect: those found and those screened."""
    found = hypothesis.scene.effects.get(candidate.identifier, {})
    return {name: value for name, value in found.items() if name in candidate.effect.settings}


def form_of(hypothesis: Hypothesis, candidate: Candidate) -> dict[str, float]:
    """Return what an effect is more in another form than the library's, SI units by name."""
    fit = hypothesis.fit
    return {
        part.amplitude: float(value)
        for part, value in zip(fit.parameters, fit.coordinates, strict=True)
        if part.is_freed and part.is_in_all and part.effect == candidate.identifier
    }


def of_another_form(hypothesis: Hypothesis) -> list[str]:
    """Say which effects were fitted in another form than the library's, and where it is most."""
    said = []
    for candidate in hypothesis.added:
        most = _largest_part(candidate, form_of(hypothesis, candidate))
        if most is not None:
            words = f'{candidate.identifier} is of another form than the library has'
            said.append(f'{words}: {candidate.effect.form} (most of all {most})')
    return said


def _largest_part(candidate: Candidate, form: Mapping[str, float]) -> str | None:
    """Return the part of an effect's form that is most of its usual size, with how large it is.

    None: what was free to be of another form is of the library's.
    """
    parts = {name: candidate.part(name) for name in form}
    shares = {name: abs(value) / parts[name].scale for name, value in form.items()}
    name = max(shares, key=lambda own: shares[own], default=None)
    if name is None or shares[name] < _LEAST_OF_FORM:
        return None
    return parts[name].shown(form[name])


def spread_over_poses(hypothesis: Hypothesis) -> list[str]:
    """Say by how much effects are other ones in each pose, where they were fitted so.

    Root mean square of what an amplitude is more in one pose than in all.
    """
    more: dict[tuple[str, str], list[float]] = {}
    for part, value in zip(hypothesis.fit.parameters, hypothesis.fit.coordinates, strict=True):
        if part.posture is not None:
            more.setdefault((part.effect, part.amplitude), []).append(float(value))
    said = []
    for candidate in hypothesis.added:
        words = []
        for name in candidate.components:
            own = more.get((candidate.identifier, name))
            if own is not None:
                part = candidate.part(name)
                size = part.shown_factor * float(np.sqrt(np.mean(np.square(own))))
                words.append(f'{name} by {size:.2g} {part.shown_unit}')
        if any((candidate.identifier, part.name) in more for part in candidate.effect.forms):
            words.append('and so is its form')
        if words:
            said.append(
                f'{candidate.identifier} is another one in each pose: {", ".join(words)}; the '
                'model takes what all have in common'
            )
    return said


def frame_of(
    identifier: str, model: ForwardModel, coordinates: FloatArray
) -> dict[str, list[float]]:
    """Return points [m] and unit vectors, each of three numbers, by name.

    Args:
        identifier: of the effect.
        model: that has it.
        coordinates: of the model's parameters, shape (k,).
    """
    own = model.effects.amplitudes(coordinates).get(identifier, {})
    site = model.effects.site(0, camera_pivot=model.cameras.offset_pivot)
    vectors = EFFECTS[identifier].frame(own, site)
    return {name: [round(float(x), 9) for x in vector] for name, vector in vectors.items()}


def gap_figures(nominal: Refit, added: Refit) -> GapFigures:
    """Measure the gap on the patches that no fit has seen.

    What hides in a parameter or pose of which better is known belongs to the gap.
    """
    before, after = _gaps(nominal, added, Part.REPORT)
    return GapFigures(
        nominal=1e3 * before.rms,
        added=1e3 * after.rms,
        floor_sensor=1e3 * before.floor,
        floor_numerics=1e3 * before.mesh,
        median_nominal=1e3 * before.median,
        median_added=1e3 * after.median,
    )


def judged_part(nominal: Refit, *, is_moving: bool) -> Part:
    """Return the patches that tell whether a gap is there and closes: those no fit has seen.

    What hides in a parameter of a motion is a gap that no fit has closed on any patch, and the few
    frames that are held out show a swing at a few phases, at which it may be nothing.
    """
    return Part.ALL if is_moving and is_strained(nominal) else Part.REPORT


def closure_of(nominal: Refit, added: Refit, is_measured: bool, part: Part = Part.REPORT) -> float:
    """Return (nominal - added) / (nominal - floor) on the patches of a part."""
    before, after = _gaps(nominal, added, part)
    floor = before.whole_floor
    old, new = before.size(is_measured=is_measured), after.size(is_measured=is_measured)
    return closed_fraction(old, new, floor)


def _gaps(nominal: Refit, added: Refit, part: Part) -> tuple[PatchGap, PatchGap]:
    """Return the gap of a model and that with effects added, with what hides in parameters.

    What differs from frame to frame is found in each, by patches of it that do not count.
    """
    left = told_frame_by_frame(unstrained(added, nominal.parameters), added)
    return patch_gap(unstrained(nominal), part), patch_gap(left, part)


def closed_by(nominal: Refit, added: Hypothesis) -> float:
    """Return what a model closes in the library's form, on the patches by which it is judged.

    Args:
        nominal: fit of the model without its effects.
        added: the model.
    """
    evaluator = added.evaluator
    part = judged_part(nominal, is_moving=evaluator.model.is_moving)
    return closure_of(nominal, added.fit, evaluator.is_measured, part)


def closed_in_its_form(nominal: Refit, added: Hypothesis, closure: float) -> float:
    """Return what a model closes on the report's patches in the form that the data favour.

    A form that is another thing closes nothing for it.

    Args:
        nominal: fit of the model without its effects.
        added: the model.
        closure: what it closes in the library's form.
    """
    if added.judged is None or added.judged.fraction > FARTHEST_FORM:
        return closure
    before = patch_gap(unstrained(nominal), Part.REPORT)
    own = closed_fraction(before.rms, added.judged.left, before.whole_floor)
    return float(np.fmax(closure, own))


def weight_doubt(hypothesis: Hypothesis) -> float:
    """Return what causes that have a model's names may add to the weight, as a share of it.

    What swings tells its stiffness by its mass, whatever pushes it.
    """
    if hypothesis.evaluator.model.is_moving:
        return 0.0
    known = hypothesis.evaluator.model.effects.amplitudes(hypothesis.fit.coordinates)
    own = [c.effect.weight_doubt(known[c.identifier]) for c in hypothesis.added]
    return float(np.linalg.norm(own))


def parameter_table(
    fit: Refit,
    asked: Refit,
    *,
    weight_doubt: float = 0.0,
    is_known: bool = True,
    error_factor: float = 1.0,
) -> dict[str, dict[str, float | str]]:
    """Return value, standard error and unit of the parameters that were asked for.

    Those of a motion are fitted to this mesh and time step: what they took up of these is put
    back.

    Args:
        fit: where they are.
        asked: a fit of those that are wanted.
        weight_doubt: standard error of the weight, as a share of it. A body at rest tells its
            moduli by that.
        is_known: whether what the model lacks is; else it may have drawn them by any amount, and
            they have no standard error: NaN.
        error_factor: how much larger the errors of sensor and poses may be than is stated of
            them.
    """
    wanted = set(asked.parameters.names)
    fit = with_poses_in_doubt(fit) if is_known else fit
    table: dict[str, dict[str, float | str]] = {}
    for index, parameter in enumerate(fit.parameters):
        if parameter.is_nuisance or parameter.name not in wanted:
            continue
        coordinate, std_error = fit.of_the_body(index)
        value = parameter.value(coordinate)
        if parameter.kind is Kind.YOUNGS_MODULUS:
            std_error = float(np.hypot(std_error, weight_doubt))
        std_error = error_factor * std_error if is_known else float('nan')
        table[parameter.name] = {
            'value': value,
            'std_error': value * std_error if parameter.is_logarithmic else std_error,
            'unit': parameter.unit,
        }
    return table


def drawn_beside(hypothesis: Hypothesis, scores: Screen) -> Drawn:
    """Return how far parameters beside named effects may be off by what hides there.

    Of bodies at rest: to follow a motion by all that may be missing takes as long as a refit.

    Args:
        hypothesis: the model whose effects are named.
        scores: of all candidates at the nominal fit.
    """
    model, known = hypothesis.evaluator.model, hypothesis.identifiers
    if model.is_moving:
        return {}
    others = [s.candidate for s in scores.scores if s.candidate.identifier not in known]
    try:
        beside = screen(hypothesis.evaluator, hypothesis.fit.coordinates, others)
    except NotSimulatedError:
        return {}  # No steps lead there again, see `lead_to`.
    return drawn_parameters(beside, hypothesis.fit.parameters)


def times_detectable(scores: Screen) -> dict[str, float]:
    """Return the expected amplitude over the smallest detectable one, by effect."""
    found: dict[str, float] = {}
    for score in scores.scores:
        found.setdefault(score.candidate.identifier, score.times_detectable)
    return found


def details_of(
    nominal: Refit, scores: Screen, selection: Selection | None, choice: Choice | None
) -> dict[str, Any]:
    """Return scores and refits, for whoever wants to know how it came to a verdict."""
    return {
        'patches': nominal.patch_count,
        'chi_square_per_patch': nominal.chi_square / max(nominal.patch_count, 1),
        'scores': [
            {
                'identifier': score.candidate.identifier,
                'components': list(score.candidate.components),
                'at': score.candidate.at,
                'log_evidence': score.log_evidence,
                'gain': score.gain,
            }
            for score in scores.scores
        ],
        'candidates': [] if selection is None else _candidate_table(selection, choice),
        'refits': [] if selection is None else _refit_table(selection),
    }


def _candidate_table(selection: Selection, choice: Choice | None) -> list[dict[str, Any]]:
    """Return every effect that has been refitted, with its amplitudes, the favoured first."""
    found: dict[str, NamedEffect] = {}
    favoured = [] if choice is None else [choice.hypothesis]
    for hypothesis in (*favoured, *selection.singles):
        confidences: Mapping[str, float] = dict.fromkeys(hypothesis.identifiers, 0.0)
        if choice is not None and hypothesis is choice.hypothesis:
            confidences = choice.confidences
        for effect in named_effects(hypothesis, confidences):
            found.setdefault(effect.identifier, effect)
    return [asdict(effect) for effect in found.values()]


def _refit_table(selection: Selection) -> list[dict[str, object]]:
    return [
        {
            'effects': list(h.identifiers),
            'components': [list(c.components) for c in h.added],
            'at': [c.at for c in h.added],
            'log_evidence': h.log_evidence,
            'tolerance': None if h.judged is None else h.judged.fraction,
            'by_pose': None if h.judged is None else h.judged.by_pose,
            'doubtful': h.leaning,
            'chi_square': h.fit.chi_square,
            'at_bound': h.is_at_bound,
            'evaluations': h.fit.evaluations,
        }
        for h in (*selection.singles, *selection.pairs)
    ]
