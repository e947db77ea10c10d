# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the amplitudes that were fitted may as well be zero.

Wald's test, amplitudes over their standard errors, falls again as an amplitude grows whose effect
levels off or is taken up by a parameter (Hauck and Donner, *Wald's test as applied to hypotheses
in logit analysis*, J. Am. Stat. Assoc. 72, 1977): a stiffening that no fit can do without may be
25 +- 10. The likelihood ratio of the models with and without does not depend on how an amplitude
is counted (Wilks, Ann. Math. Stat. 9, 1938), so it decides; an amplitude whose own 95 % interval
holds zero has no name all the same. Against another name it speaks for all that: data that cannot
do without either of two do not tell which.
"""

from collections.abc import Callable, Sequence

from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.model_comparison.guessed_floor import noise_scale
from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import full_names, FullName, only
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import Candidate, identifiers_of, parameters_of
import numpy as np

# Noise alone makes amplitudes as large with this chance; as far from zero, by their own errors.
_BY_CHANCE, _BY_CHANCE_ALONE = 0.003, 0.05


def has_doubtful_effect(
    hypothesis: Hypothesis, nominal: Refit, singles: Sequence[Hypothesis] = ()
) -> bool:
    """Tell whether one of a model's effects may as well be absent.

    Args:
        hypothesis: the model.
        nominal: fit of the model without its effects.
        singles: models with one effect, best first: a pair without the other one.
    """
    return _is_so_of_any(_may_be_absent, hypothesis, nominal, singles)


def has_needless_effect(
    hypothesis: Hypothesis, nominal: Refit, singles: Sequence[Hypothesis] = ()
) -> bool:
    """Tell whether data do as well without one of a model's effects; see `has_doubtful_effect`.

    However wide the interval of its amplitude is: that of what levels off holds zero, and no fit
    without it comes near.
    """
    return _is_so_of_any(_is_needless, hypothesis, nominal, singles)


def _is_so_of_any(
    is_so: Callable[[Hypothesis, Candidate, Refit | None], bool],
    hypothesis: Hypothesis,
    nominal: Refit,
    singles: Sequence[Hypothesis],
) -> bool:
    """Tell whether something is so of any of a model's effects beside the fit without that."""
    return any(
        is_so(hypothesis, one, _without(hypothesis, one, nominal, singles))
        for one in hypothesis.added
        # What has no tangent at zero is there at zero.
        if one.effect.has_tangent
    )


def has_nothing_in_common(hypothesis: Hypothesis, one: Candidate) -> bool:
    """Tell whether a property was fitted as another one in each posture, and is in none of all.

    Args:
        hypothesis: the model.
        one: of its effects.
    """
    own = {part.effect for part in hypothesis.freed if part.posture is not None}
    if not one.effect.has_common_part or one.effect.identifier not in own:
        return False
    return _chance_of_zero(hypothesis, one, in_common=True) > _BY_CHANCE


def spread_of_amount(hypothesis: Hypothesis, one: Candidate) -> float:
    """Return by how much of itself an effect is more or less of it in each posture.

    A mass may slide or dry, and is there in all of them; a force that is upward in some is none.

    Args:
        hypothesis: the model.
        one: of its effects.
    """
    model, coordinates = hypothesis.evaluator.model, hypothesis.fit.coordinates
    found = [
        one.effect.amount(model.effects.amplitudes(coordinates, posture)[one.identifier])
        for posture in sorted(model.bodies)
    ]
    amounts = np.array([amount for amount in found if amount is not None])
    if len(amounts) == 0 or (amounts == amounts[0]).all():
        return 0.0
    mean = float(np.mean(amounts))
    return float(np.std(amounts) / mean) if mean > 0.0 else np.inf


def differing_by_pose(hypothesis: Hypothesis) -> Candidate | None:
    """Return the first effect that is another one in each posture with hardly anything in common.

    Such an effect has no name.
    """
    return next(
        (
            one
            for one in hypothesis.added
            if has_nothing_in_common(hypothesis, one)
            or spread_of_amount(hypothesis, one) > FARTHEST_FORM
        ),
        None,
    )


def _without(
    hypothesis: Hypothesis, one: Candidate, nominal: Refit, singles: Sequence[Hypothesis]
) -> Refit | None:
    """Return the fit without one of the effects, None where there is none."""
    others = identifiers_of(own for own in hypothesis.added if own is not one)
    if not others:
        return nominal
    return next((single.fit for single in singles if single.identifiers == others), None)


def _may_be_absent(hypothesis: Hypothesis, one: Candidate, without: Refit | None) -> bool:
    is_held_to_errors = hypothesis.evaluator.is_measured and without is not None
    if is_held_to_errors and _chance_of_zero(hypothesis, one) > _BY_CHANCE_ALONE:
        return True
    return _is_needless(hypothesis, one, without)


def _is_needless(hypothesis: Hypothesis, one: Candidate, without: Refit | None) -> bool:
    if not hypothesis.evaluator.is_measured:
        # The ratio is one of maxima, and robust fits are none of what patches say. What they
        # leave is the only measure of their noise.
        left = whiten(hypothesis.fit.groups, Part.FIT).values
        return hypothesis.chance_of_zero(one, noise_scale(left)) > _BY_CHANCE
    if without is None:
        return hypothesis.chance_of_zero(one) > _BY_CHANCE
    fall = deviance(without, hypothesis.fit) / max(1.0, hypothesis.fit.chi_square_per_patch)
    count = hypothesis.freedom_of(parameters_of(hypothesis.fit.parameters, [one]))
    return float(chance_beyond(fall, count)) > _BY_CHANCE


def _chance_of_zero(hypothesis: Hypothesis, one: Candidate, *, in_common: bool = False) -> float:
    """Return the chance of amplitudes as large by their own errors if all were zero.

    Of what is never negative noise gives half of the times nothing (Chernoff, Ann. Math. Stat. 25,
    1954).

    Args:
        hypothesis: the model.
        one: of its effects.
        in_common: of what all postures have in common alone.
    """
    chance = hypothesis.chance_of_zero(one, in_common=in_common)
    own = one.names if in_common else parameters_of(hypothesis.fit.parameters, [one])
    is_never_negative = len(own) == 1 and one.parts[0].lower == 0.0
    return 0.5 * chance if is_never_negative else chance


def deviance(without: Refit, fit: Refit) -> float:
    """Return by how much twice the log posterior density rises with what a fit has besides.

    On the patches that both see: others come and go with the outline.

    Args:
        without: fit of the smaller model.
        fit: of the larger one.
    """
    names = set(full_names(without.groups)) & set(full_names(fit.groups))
    return _twice_the_cost(without, names) - _twice_the_cost(fit, names)


def _twice_the_cost(fit: Refit, names: set[FullName]) -> float:
    seen = whiten(only(fit.groups, names), Part.FIT)
    # What a model leaves uneven within patches, or far off, makes their variance larger: by
    # chi-square alone the one that is farther off would be held to less. Where all patches of a
    # view are off by the same, what they share would be told by far more than their noise.
    return seen.chi_square + seen.volume + seen.tolerance + fit.prior_chi_square
