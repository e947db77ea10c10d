# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a second effect adds that no form of the first one explains.

Two effects of the library's form can imitate one of another form: a camera off along its axis
with a bias of depth is a lens that is longer; an error of depth that drifts from pose to pose is,
in part, a camera that is off. So a pair in whatever form it may have is held against each of its
effects alone, likewise in any form (`any_form`). And what really is there is there in every pose:
a second effect must tell each pose from the others better than the first one alone does.

How large the sensor's smooth error is was found with the tangents of all effects projected out, so
that just what a second effect explains was never the sensor's. So its size is integrated out anew
beside each model (`smooth_sizes`): by a worse camera than was believed one effect may be all. So
is one that a scene states: it may be misstated, and what a model is off by beside its effects (its
mesh, its law, its poses) is as smooth.

All is linear around each fit, those of single effects where forms lead them (`form_fits`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.model_comparison.any_form import in_form, Sight
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import Ways, ways_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.shared_patches import on_shared_patches
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.smooth_sizes import (
    log_beliefs,
    size_factors,
    with_larger_error,
)
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import Candidate, parameters_of
import numpy as np
from scipy.special import logsumexp

# A second effect must be better by so much log evidence, per unit of noise scale.
PAIR_GAIN = 8.0


@dataclass(frozen=True)
class Explained:
    """How well some effects explain patches, in whatever form they may have.

    Attributes:
        log_evidence: of the patches that were fitted.
        log_transfer: log density of each view given all others, summed; 0 of a single view.
        larger: by what factor the sensor's smooth error is larger than is believed, as is to be
            expected beside them.
    """

    log_evidence: float
    log_transfer: float
    larger: float = 1.0

    def above(self, others: Sequence['Explained']) -> 'Explained':
        """Return by how much it is above the best of others, each figure for itself."""
        return replace(
            self,
            log_evidence=self.log_evidence - max(other.log_evidence for other in others),
            log_transfer=self.log_transfer - max(other.log_transfer for other in others),
        )


def most_gain(hypothesis: Hypothesis) -> float:
    """Return how much log evidence a further effect could gain that costs nothing.

    It would leave noise alone, pull no parameter from where it is likely, and need no tolerance
    for the form of the effects that are there, which has gained some of that before.
    """
    fit = hypothesis.fit
    noise = fit.patch_count - len(fit.coordinates)
    left = fit.chi_square - noise + fit.prior_chi_square
    return 0.5 * left - hypothesis.leaning


def most_added(one: Hypothesis, basis: FormBasis) -> float:
    """Return how much log evidence a second effect could add that leaves noise alone.

    Args:
        one: a model with a single effect.
        basis: of the model without it.
    """
    fit = one.fit
    ways = ways_of(one.evaluator.model, fit, basis, one.added)
    sight = in_form(fit, ways).sight
    noise = len(sight.values) - len(fit.coordinates)
    best = -0.5 * (noise + sight.known_volume)
    return best - sight.level()


def second_adds(singles: Sequence[Hypothesis], two: Hypothesis, basis: FormBasis) -> Explained:
    """Return what a pair explains above each of its effects, and above the best single one.

    A single view tells nothing of others; what is transferred to them is taken for enough then.

    Args:
        singles: models with one effect, best first.
        two: the model with two.
        basis: of the model without.
    """
    names = [own.identifier for own in two.added]
    best = [next((h for h in singles if h.identifiers == (name,)), None) for name in names]
    rivals = dict.fromkeys(id(h) for h in (singles[0], *best) if h is not None)
    two, *ones = on_shared_patches([two, *(h for h in singles if id(h) in rivals)])
    alone = [_Shares.of(one, one.added, basis) for one in ones]
    # What was not found alone is taken from the pair, to first order.
    alone += [
        _Shares.of(two, [own], basis)
        for own, single in zip(two.added, best, strict=True)
        if single is None
    ]
    both = _Shares.of(two, two.added, basis)
    found = both.explained([1.0]).above([own.explained([1.0]) for own in alone])
    factors = size_factors(two.evaluator.noises)
    if len(factors) > 1 and found.log_evidence > 0.0:
        found = both.explained(factors).above([own.explained(factors) for own in alone])
    has_others = len({group.view for group in two.fit.groups}) > 1
    return found if has_others else replace(found, log_transfer=np.inf)


@dataclass(frozen=True)
class _Shares:
    """Some of a model's effects.

    Attributes:
        model: with all of its effects.
        kept: those that stay; the others are taken to zero.
        ways: in which those may differ from the library's form.
    """

    model: Hypothesis
    kept: Sequence[Candidate]
    ways: Ways

    @classmethod
    def of(cls, model: Hypothesis, kept: Sequence[Candidate], basis: FormBasis) -> '_Shares':
        """Return some effects of a model, by what their forms are told by."""
        return cls(model, kept, ways_of(model.evaluator.model, model.fit, basis, kept))

    def explained(self, factors: Sequence[float]) -> Explained:
        """Return how well they explain the patches of the model's fit; see `explained`."""
        model = self.model
        noises = model.evaluator.noises
        return explained(model.fit, model.added, self.kept, self.ways, noises, factors)


def explained(
    fit: Refit,
    added: Sequence[Candidate],
    kept: Sequence[Candidate],
    ways: Ways,
    noises: Sequence[NoiseModel] = (),
    factors: Sequence[float] = (1.0,),
) -> Explained:
    """Return how well some of a model's effects explain the patches, around its fit.

    Args:
        fit: of the model.
        added: its effects.
        kept: those that stay; the others are taken to zero.
        ways: in which those may differ from the library's form.
        noises: of all views; they are asked for where smooth errors may be larger.
        factors: by which these may be larger than is believed.
    """
    gone = parameters_of(fit.parameters, [own for own in added if own not in kept])
    known = [with_larger_error(fit.groups, noises, own) for own in factors]
    sights = [_sights(replace(fit, groups=groups), ways, gone) for groups in known]
    levels = np.array([[sight.level() for sight in own] for own in sights])
    noise = np.array([[sight.noise for sight in own] for own in sights])
    # What is expected to scatter more is less likely to be where it is.
    weighed = levels - 0.5 * (noise - noise[0]) + log_beliefs(noises, factors)[:, None]
    whole, every, *lacking = logsumexp(weighed, axis=0)
    chances = np.exp(weighed[:, 0] - whole)
    larger = float(np.sqrt(chances @ np.square(factors)))
    return Explained(float(whole), float(sum(every - own for own in lacking)), larger)


def _sights(fit: Refit, ways: Ways, gone: Sequence[str]) -> list[Sight]:
    """Return patches, those of views apart, and of all views but each."""
    counted = in_form(fit, ways, gone)
    seen = whiten(counted.groups, Part.FIT, is_apart=True)
    apart = Sight.of(fit, seen, ways.pose_count, gone)
    views = np.unique(apart.views)
    lacking = [apart.without(view) for view in views] if len(views) > 1 else []
    return [counted.sight, apart, *lacking]
