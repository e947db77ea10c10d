# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ratios of time, and whether the answers agree: a time says little without its answer."""

from typing import Any

import numpy as np

_LINEAR = 'equilibrium_linear'
Figures = dict[str, Any]
Arrays = dict[str, Any]


def compare(ours: Figures, peers: Figures, arrays: dict[str, Arrays], case: Arrays) -> None:
    """Add ratios and agreement to the figures of each study, in place.

    Args:
        ours: our figures by study.
        peers: figures by peer and study.
        arrays: by package ('ours' among them) and `study.name`.
        case: what all were given.
    """
    for package, figures in {'ours': ours, **peers}.items():
        for study, row in figures.items():
            if not isinstance(row, dict) or 'failed' in row or study == 'versions':
                continue
            own = arrays.get(package, {})
            if study.startswith('equilibrium'):
                row['agreement'] = _equilibrium(study, row, own, arrays['ours'], ours, case)
            elif study == 'motion':
                row['agreement'] = _motion(row, own, arrays['ours'], ours, case)
            elif study == 'depth':
                _depth(row, own, arrays['ours'])
            if package != 'ours':
                _ratios(row, ours[study])


def _ratios(row: Figures, mine: Figures) -> None:
    """Tell how many times our processor time each kind of call takes."""
    if 'rows' in row:
        for each in row['rows'].values():
            _ratios(each, mine['rows']['ours'])
        return
    for kind in ('forward', 'both'):
        if kind in row and kind in mine:
            row[kind]['ratio'] = row[kind]['cpu_s'] / mine[kind]['cpu_s']


def _is_other_law(row: Figures) -> bool:
    return 'St. Venant' in row['law']


def _equilibrium(
    study: str, row: Figures, own: Arrays, mine: Arrays, ours: Figures, case: Arrays
) -> Figures:
    """Compare with our answer for the same element and the same law."""
    suffix = '_st_venant_kirchhoff' if _is_other_law(row) else ''
    moved = own[f'{study}.displacement']
    same = mine[f'{study}.displacement{suffix}']
    slope = ours[study][f'tip_slope{suffix}_mm']
    tip = int(case['tip'])
    return {
        'sag_mm': 1e3 * float(moved[tip, 1]),
        'our_sag_with_this_law_mm': 1e3 * float(same[tip, 1]),
        'largest_difference_mm': 1e3 * float(np.abs(moved - same).max()),
        'gradient_over_ours_less_1': row['tip_slope_mm'] / slope - 1.0,
    }


def _motion(row: Figures, own: Arrays, mine: Arrays, ours: Figures, case: Arrays) -> Figures:
    """Compare where the tip ends with our limit of short steps under the same law."""
    suffix = '_st_venant_kirchhoff' if _is_other_law(row) else ''
    limit = mine[f'motion.fine_tip{suffix}']
    found: Figures = {
        'off_our_limit_mm': 1e3 * float(np.linalg.norm(own['motion.tip'] - limit)),
        'own_limit_off_ours_mm': 1e3 * float(np.linalg.norm(own['motion.fine_tip'] - limit)),
    }
    slope = row.get('tip_slope_mm')
    if 'motion.by_start' in own:
        # The peer takes its start as given; ours moves with E, and that share is added here.
        share = float((own['motion.by_start'] * case['start_by_log_modulus']).sum())
        slope = row['tip_slope_at_fixed_start_mm'] + 1e3 * share
        row['tip_slope_mm'] = slope
    if slope is not None:
        limit_slope = ours['motion']['fine_tip_slope_mm']
        found['gradient_over_our_limit_less_1'] = slope / limit_slope - 1.0
    return found


def _depth(row: Figures, own: Arrays, mine: Arrays) -> None:
    """Judge each gradient by our converged one, and by differences of the loss."""
    exact, differences = mine['depth.exact'], mine['depth.differences']
    for name, each in row['rows'].items():
        gradient = own[f'depth.gradient_{name}']
        moved = gradient.sum(axis=0)
        each['agreement'] = {
            'error_by_vertex': float(np.linalg.norm(gradient - exact) / np.linalg.norm(exact)),
            'error_of_translation_by_differences': float(
                np.linalg.norm(moved - differences) / np.linalg.norm(differences)
            ),
        }
