# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name is as sure as its form is: what data want in another one, or see too little of to tell.

How far an effect is off from the library's form is expected of the data (`Tolerated.fraction`):
by next to nothing where they confirm it, by what is believed beforehand where they say nothing.
What is in a form of its own they have told that already: yet another one is for them to ask for.
"""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, USUAL_FORM
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.verdict.doubts import is_spoken_for, off_in_form
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.verdict_figures import closed_by

# Of twelve names that were given so in eight sealed sets six were right (of sixty others 55). Of
# ten single ones that were kept back since, on data that nobody had looked at, nine were: by the
# rule of succession 16 of 24. Of two effects at once no more is known than of the first fifteen.
_RIGHT, _RIGHT_OF_TWO = 0.67, 0.59


def with_form_in_doubt(
    choice: Choice, nominal: Refit, witness: FieldWitness | None = None
) -> Choice:
    """Return a choice no surer than its effects' form allows, and why.

    Args:
        choice: the favoured model.
        nominal: fit of the model without effects.
        witness: who may speak for a form that is off; None: nobody does.
    """
    hypothesis = choice.hypothesis
    share = _may_be_off_by(hypothesis)
    if share <= USUAL_FORM:
        return choice
    if is_spoken_for(hypothesis, closed_by(nominal, hypothesis), witness):
        return choice
    unsure = (
        f'{" with ".join(hypothesis.identifiers)} came nearest, in a form that may be off by '
        f'{share:.0%} of what it does: of twenty-two names like this fifteen were right, so that '
        'it may be something else'
    )
    most = _RIGHT if len(hypothesis.added) == 1 else _RIGHT_OF_TWO
    confidences = {name: min(own, most) for name, own in choice.confidences.items()}
    return replace(choice, confidences=confidences, unsure=unsure)


def _may_be_off_by(hypothesis: Hypothesis) -> float:
    """Return by what share of what they do effects may be off in form, as far as is known."""
    judged = hypothesis.judged
    if judged is None:
        return 0.0
    return off_in_form(hypothesis) if hypothesis.is_free_in_form else judged.fraction
