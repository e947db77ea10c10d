# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The one effect of two that is sure, where the two together may not be named.

Beside the cause something small is off as well, in a form that the library does not have: a rope
that bears a body also draws it to one side. The pair that comes nearest then has no name. What
every model has that comes near is there all the same, whatever is beside it.
"""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.choice import Choice, ONE_POSE_AS_WELL
from diffcal_ros.diagnosis.model_comparison.hypothesis import FORM_DOUBT, Hypothesis
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness


def with_sure_part(
    choice: Choice,
    selection: Selection,
    nominal: Refit,
    witness: FieldWitness | None = None,
) -> Choice:
    """Return the choice of the sure one of two effects; the choice as it is where none is.

    Args:
        choice: the favoured model.
        selection: all models.
        nominal: fit of the model without effects.
        witness: see `doubts_about`.
    """
    pair = choice.hypothesis
    if len(pair.added) < 2 or not doubts_about(pair, nominal, selection.singles, witness):
        return choice
    for name in pair.identifiers:
        alone = next((h for h in selection.singles if h.identifiers == (name,)), None)
        if alone is None or not _is_sure(name, alone, pair, selection, nominal):
            continue
        if not doubts_about(alone, nominal, selection.singles, witness):
            other = next(n for n in pair.identifiers if n != name)
            return replace(
                choice, hypothesis=alone, confidences={name: 1.0}, alike=(name,), beside=other
            )
    return choice


def _is_sure(
    name: str, alone: Hypothesis, pair: Hypothesis, selection: Selection, nominal: Refit
) -> bool:
    """Tell whether no model without an effect comes near, nor a single one near it alone."""
    if alone.is_at_bound:
        return False
    without = [h.level for h in selection.singles if name not in h.identifiers]
    without.append(nominal.log_evidence)
    pairs = [h.level for h in selection.pairs if name not in h.identifiers]
    ahead = min(
        alone.level - max(without) - FORM_DOUBT * alone.leaning,
        pair.level - max(without + pairs) - FORM_DOUBT * pair.leaning,
    )
    # As far as with one pose: something of another form is known to be there.
    return ahead > ONE_POSE_AS_WELL * selection.noise_scale
