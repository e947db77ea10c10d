# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The procedure: fit, look for a disagreement, screen, refit, select, name or abstain."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import time

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.diagnosis.detection.disagreement import beside_a_model, Disagreement
from diffcal_ros.diagnosis.examined import examined
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.motion_refit import refitted_there
from diffcal_ros.diagnosis.model_comparison.processes import all_set_aside
from diffcal_ros.diagnosis.model_comparison.refit_pool import processes_begun, Progress
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.screening import Screen
from diffcal_ros.diagnosis.selected import selected
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.form_in_doubt import with_form_in_doubt
from diffcal_ros.diagnosis.verdict.sure_part import with_sure_part
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.one_blas_thread import blas_on_one_thread
from diffcal_ros.scene.model import Scene


@dataclass(frozen=True)
class DiagnosisTrace:
    """Everything that a diagnosis went through, for its page.

    Attributes:
        evaluator: of the nominal model.
        nominal: its fit.
        screen: scores of all candidates.
        disagreement: whether there is one.
        selection: refitted models; None where there was nothing to name.
        diagnosis: the verdict.
    """

    evaluator: PatchEvaluator
    nominal: Refit
    screen: Screen
    disagreement: Disagreement
    selection: Selection | None
    diagnosis: Diagnosis

    def described(self, **details: object) -> 'DiagnosisTrace':
        """Return the trace with the scene, and what else is given, in its verdict's details."""
        path = self.evaluator.model.scene.path
        scene = '' if path is None else str(path.resolve())
        known = {**self.diagnosis.details, 'scene': scene, **details}
        return replace(self, diagnosis=replace(self.diagnosis, details=known))


@blas_on_one_thread()
def diagnose(
    scene: Scene,
    observations: Sequence[Observation],
    settings: DiagnosisSettings | None = None,
    *,
    report: Progress = lambda _: None,
) -> DiagnosisTrace:
    """Find out whether a model lacks something, and what.

    Args:
        scene: the model as it is.
        observations: of one or several poses.
        settings: choices.
        report: called with what is being done.

    Raises:
        InputError: when the nominal model cannot be fitted.
    """
    settings = settings or DiagnosisSettings()
    begun = time.perf_counter()
    report('fitting the model as it is')
    evaluator, nominal = fit_nominal(scene, observations, settings.fit)
    seconds = time.perf_counter() - begun
    # They begin while this process looks at what is off.
    begun_beside = processes_begun(evaluator, nominal, seconds, settings.jobs)
    with begun_beside as processes, all_set_aside():
        judged = examined(evaluator, nominal, settings, report)
        selection = choice = None
        if judged.disagreement.is_worth_naming:
            judged, selection = selected(scene, judged, settings, report, processes)
        evaluator, nominal = judged.evaluator, judged.nominal
        witness = FieldWitness(evaluator, nominal)
        if selection is not None:
            choice = choose(selection, evaluator, nominal)
            if choice is not None:
                choice = with_sure_part(choice, selection, nominal, witness)
                choice = with_form_in_doubt(choice, nominal, witness)
    scores, disagreement = judged.scores, judged.disagreement
    if choice is not None:
        disagreement = beside_a_model(disagreement, choice.hypothesis.fit)
    # A load that is held is as good as at rest.
    if choice is not None and not all(evaluator.discretisation_error.is_slow):
        report('finding what mesh and time step cost there')
        choice = replace(choice, hypothesis=refitted_there(choice.hypothesis))
    seconds = time.perf_counter() - begun
    diagnosis = conclude(
        evaluator,
        nominal,
        scores,
        disagreement,
        selection,
        choice,
        seconds,
        judged.outliers,
        witness,
    )
    return DiagnosisTrace(evaluator, nominal, scores, disagreement, selection, diagnosis)
