# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a diagnosis: one file that needs nothing else."""

from html import escape
import math
from pathlib import Path

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.diagnose import DiagnosisTrace
from diffcal_ros.diagnosis.patch_fits.held_out_frames import told_frame_by_frame
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.effects.registry import EFFECTS, seen_boundary, what_settles
from diffcal_ros.effects.spots import spots_of
from diffcal_ros.report.figures.course_figure import course_figure
from diffcal_ros.report.figures.diagnosis_figure import residual_figure, score_figure
from diffcal_ros.report.figures.figure_png import data_uri, png_bytes
from diffcal_ros.report.figures.spot_figure import spot_figure
from diffcal_ros.report.naming import shown, title
from diffcal_ros.report.pages.page_style import document
from diffcal_ros.report.tables.page_tables import plain, table
from diffcal_ros.report.tables.verdict_text import effect_words, verdict_lines

_KINDS = {Verdict.AGREE: 'good', Verdict.DISAGREE: 'bad'}
_HEADS = {
    Verdict.AGREE: 'simulation and measurement agree',
    Verdict.DISAGREE: 'simulation and measurement disagree',
    Verdict.BELOW_MARGIN: 'a disagreement too small to matter',
    Verdict.CANNOT_TELL: 'the data cannot tell',
}


def write_diagnosis_page(path: Path, name: str, trace: DiagnosisTrace) -> None:
    """Write the page, whole or not at all.

    Args:
        path: HTML file.
        name: of the scene.
        trace: what the diagnosis went through.

    Raises:
        InputError: when the file cannot be written.
    """
    diagnosis = trace.diagnosis
    sections = [
        _headline(name, diagnosis),
        _pictures(trace),
        _spots(trace),
        _courses(diagnosis),
        _gap_table(trace),
        _effects_table(diagnosis),
        _parameters(diagnosis),
        _scores(trace),
        _refits(diagnosis),
    ]
    write_text_atomically(path, document(f'{name}: diagnosis', ''.join(sections)))


def _headline(name: str, diagnosis: Diagnosis) -> str:
    kind = _KINDS.get(diagnosis.verdict, 'care')
    lines = ''.join(
        f'<div class="said">{escape(line)}</div>\n' for line in verdict_lines(diagnosis)
    )
    return (
        f'<h1>{escape(name)}</h1>\n<p class="soft">Diagnosis with diffcal '
        f'{escape(__version__)}, {diagnosis.seconds:.0f} s.</p>\n'
        f'<div class="card outcome {kind}"><div class="label">verdict</div>'
        f'<div class="value">{_HEADS[diagnosis.verdict]}</div>'
        f'{lines}</div>\n'
    )


def _pictures(trace: DiagnosisTrace) -> str:
    picture = data_uri(png_bytes(residual_figure(trace)))
    return (
        '<h2>What is left</h2>\n<figure><img alt="measured depth and residuals" '
        f'src="{picture}"><figcaption>One scale for all residuals. The last column is with the '
        'best model found, whether it was named or not.</figcaption></figure>\n'
    )


def _spots(trace: DiagnosisTrace) -> str:
    """Show the map of what the camera reads otherwise, where one was found."""
    stated = trace.evaluator.model.scene.effects.get(seen_boundary().identifier, {})
    spots = spots_of(stated)
    if spots is None:
        return ''
    picture = data_uri(png_bytes(spot_figure(spots)))
    return (
        '<h2>What is read otherwise</h2>\n<figure><img alt="map of spots on the surface" '
        f'src="{picture}"><figcaption>The surface of the body, unrolled: the camera reads what is '
        'dark too far or too near. It was told from what all poses have in common there; what '
        'none of them sees is left white.</figcaption></figure>\n'
    )


def _courses(diagnosis: Diagnosis) -> str:
    """Show what named effects are in the course of the recording, where they are others in it."""
    when, found = diagnosis.when, list[str]()
    for effect in diagnosis.effects:
        if when is None or not effect.course:
            continue
        picture = data_uri(png_bytes(course_figure(effect, when.times, when.held_out)))
        name = escape(effect.identifier)
        found.append(
            f'<figure><img alt="{name} over time" src="{picture}"><figcaption>{name} in each '
            'frame. Hollow ones no fit has seen: what they are follows from the frames beside '
            'them, or from half of their own patches where frames scatter.</figcaption></figure>\n'
        )
    return f'<h2>What changes in the recording</h2>\n{"".join(found)}' if found else ''


def _gap_table(trace: DiagnosisTrace) -> str:
    """Write the held-out gap of each pose."""
    best = trace.selection.best if trace.selection is not None else None
    left = [] if best is None else told_frame_by_frame(best.fit.groups, best.fit)
    rows = []
    for number, observation in enumerate(trace.evaluator.model.observations):
        own = [group for group in trace.nominal.groups if group.view == number]
        before = patch_gap(own, Part.REPORT)
        if before.count == 0:  # A frame that was fitted.
            continue
        cells = [escape(observation.name), plain(1e3 * before.rms)]
        if best is not None:
            after = patch_gap([b for b in left if b.view == number], Part.REPORT)
            cells.append(plain(1e3 * after.rms))
        else:
            cells.append('–')
        cells += [plain(1e3 * before.floor), plain(1e3 * before.mesh), str(before.count)]
        rows.append(cells)
    header = ['pose', 'as it was', 'with what was added', 'sensor floor', 'mesh floor', 'patches']
    return (
        '<h2>Held-out gap</h2>\n<p>Root mean square in millimetres on patches that no fit has '
        f'seen.</p>\n{table(header, rows)}\n'
    )


def _effects_table(diagnosis: Diagnosis) -> str:
    names = dict.fromkeys(
        [effect.identifier for effect in diagnosis.effects] + list(diagnosis.ambiguity_set)
    )
    if not names:
        return ''
    words = {effect.identifier: effect_words(effect) for effect in diagnosis.effects}
    rows = []
    for name in names:
        effect = EFFECTS[name]
        twins = ', '.join((*effect.twins, *effect.outside_twins))
        cosine = diagnosis.largest_cosine.get(name)
        rows.append(
            [
                escape(words.get(name, name)),
                escape(effect.sentence),
                escape(twins),
                '–' if cosine is None else plain(cosine),
                escape(what_settles([name])),
            ]
        )
    header = ['effect', 'it means', 'its twins', 'likeness', 'what would settle it']
    return f'<h2>What it may be</h2>\n{table(header, rows, first_number=9)}\n'


def _parameters(diagnosis: Diagnosis) -> str:
    rows = []
    for name, old in diagnosis.parameters['before'].items():
        new = diagnosis.parameters['after'].get(name, old)
        cells = [escape(title(name))]
        for entry in (old, new):
            value, error = float(entry['value']), float(entry['std_error'])
            words = shown(value, error, str(entry['unit'])).text('±')
            cells.append(escape(words if math.isfinite(error) else 'not known'))
        rows.append(cells)
    header = ['parameter', 'as it was', 'with what was added']
    return f'<h2>Parameters before and after</h2>\n{table(header, rows)}\n'


def _scores(trace: DiagnosisTrace) -> str:
    picture = data_uri(png_bytes(score_figure(trace.screen)))
    return (
        '<h2>Scores</h2>\n<p>What each effect could explain to first order. A score screens, it '
        'does not judge: names come from refits.</p>\n<figure><img alt="scores" '
        f'src="{picture}"></figure>\n'
    )


def _refits(diagnosis: Diagnosis) -> str:
    rows = [
        [
            escape(' and '.join(entry['effects'])),
            escape('; '.join(', '.join(names) for names in entry['components'])),
            plain(entry['log_evidence']),
            plain(entry['chi_square']),
            'yes' if entry['at_bound'] else '',
        ]
        for entry in diagnosis.details.get('refits', [])
    ]
    if not rows:
        return ''
    header = ['effects', 'amplitudes', 'log evidence', 'chi-square', 'at a bound']
    return (
        '<h2>Refits</h2>\n<details><summary>every model that was refitted, best first</summary>'
        f'{table(header, rows, first_number=2)}</details>\n'
    )
