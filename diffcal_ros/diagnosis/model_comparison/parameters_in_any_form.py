# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a motion where its effects are of whatever form the data favour.

Models of a motion are held against one another in the library's form, since what they leave is
their mesh's and time step's more than a form's. What a form that is off has drawn of the chosen
one's parameters is found all the same: of stamps that fall behind more and more, taken for late
ones, 4 % of a modulus.
"""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, with_tolerance
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.errors import NotSimulatedError

# Where forms lead, tangents are others: so many times it is looked at anew.
_STEPS = 3


def in_any_form(model: Hypothesis, base: Refit) -> Refit:
    """Return a model's fit with parameters, and their errors, as by effects of whatever form.

    Bodies at rest have been judged so, and what is free in time was fitted so. Another motion is
    led on, step by step, from where its fit in the library's form ended.

    Args:
        model: the chosen one.
        base: fit of the model without its effects.
    """
    evaluator = model.evaluator
    is_judged_so = model.is_free_in_time or not evaluator.model.is_moving
    if is_judged_so or not evaluator.is_measured:
        return model.in_any_form
    basis = FormBasis.of(evaluator, model.fit, base)
    best = with_tolerance(model, basis, is_brief=True)
    for _ in range(_STEPS):
        try:
            fit = refit(evaluator, best.in_any_form.coordinates, max_iterations=1)
        except NotSimulatedError:
            break
        led = with_tolerance(replace(model, fit=fit), basis, is_brief=True)
        if led.log_evidence <= best.log_evidence:
            break
        best = led
    return best.in_any_form
