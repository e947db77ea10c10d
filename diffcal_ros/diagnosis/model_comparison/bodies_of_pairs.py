# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies as pairs have them, without what a camera reads otherwise beside their other effect.

A reading that is free in form follows one with sharp borders about, and the other effect of the
pair comes about right beside it: nearer than any effect alone, which the reading draws. What
pixels are off by from that body is the reading.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.kept_of_pairs import kept_alone
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.effect import Effect

# Of so many of the best pairs.
_MOST = 2


def bodies_of_pairs(
    nominal: PatchEvaluator, base: Refit, pairs: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return one effect of each of the best pairs where the pair has it, best first.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        pairs: with two effects each, best first.

    Returns:
        Those of pairs whose other effect is how a camera reads the body, and which leave more than
        noise: what leaves no more has what is read about right. None where the floor is a guess,
        and what noise leaves with it.
    """
    found = list[Hypothesis]()
    if not nominal.is_measured:
        return found
    for pair in pairs[:_MOST]:
        read = [own for own in pair.added if _is_reading(own.effect)]
        others = [own for own in pair.added if not _is_reading(own.effect)]
        if pair.leaves_noise or not read or not others:
            continue
        body = kept_alone(nominal, base, pair, others[0])
        if body is not None:
            found.append(body)
    return found


def _is_reading(effect: Effect) -> bool:
    """Tell whether an effect is how a camera reads a part of the body, or of the picture."""
    return effect.group == 'sensor' and (effect.has_boundary or effect.has_edge)
