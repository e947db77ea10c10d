# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ranked energy laws in a few lines of plain text."""

from collections.abc import Sequence
import textwrap

from diffcal_ros.calibration.law_ranking import LawFit
from diffcal_ros.report.naming import shown

_HEAD = ('law', "Young's modulus", 'gap median / RMS', 'held out', 'outcome')
# RMS gaps that differ by less than this share do not tell two laws apart: halving the mesh size
# changes them by more.
_SAME = 0.05


def law_lines(ranking: Sequence[LawFit]) -> list[str]:
    """Write one line a law, the best first, and say when the first two are alike."""
    rows = [_HEAD, *(_row(fit) for fit in ranking if fit.result is not None)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEAD))]
    lines = [
        '  '.join(f'{text:<{width}}' for text, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    for fit in ranking:
        if fit.failure:
            lines += textwrap.wrap(f'{fit.law}: {fit.failure}', 96, subsequent_indent='  ')
    gaps = [fit.held_out.rms for fit in ranking if fit.held_out is not None]
    if len(gaps) > 1 and gaps[1] < (1.0 + _SAME) * gaps[0]:
        lines.append(
            f'{ranking[0].law} and {ranking[1].law} fit equally well: a load that strains the '
            'body more, such as a stretch, would tell them apart'
        )
    return lines


def _row(fit: LawFit) -> tuple[str, ...]:
    assert fit.result is not None
    moduli = [
        shown(p.value, p.std_error, p.unit).text()
        for p in fit.result.parameters
        if p.name.startswith('youngs_modulus')
    ]
    gap, held_out = fit.result.gap_end, fit.held_out
    return (
        fit.law,
        ', '.join(moduli) or '-',
        f'{1e3 * gap.median:.3f} / {1e3 * gap.rms:.3f} mm',
        '-' if held_out is None else f'{1e3 * held_out.rms:.3f} mm',
        fit.result.outcome.value.replace('_', ' '),
    )
