# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Factor and solve on one thread and on two at once: multifrontal beside QDLDL.

    OPENBLAS_NUM_THREADS=1 PYTHONPATH=.:test python benchmarks/factorisation.py [--before FILE]

FILE is what the same command printed at an older state of the code.
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
import json
from pathlib import Path
import statistics
from typing import Any

from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.linear_solvers import make_solver
from measuring import timed, write
import numpy as np
from support.beams import beam_mesh, held_end

_BEAMS = {
    'linear': [(12, 2, 2), (20, 4, 3), (30, 6, 5)],
    'quadratic': [(10, 2, 2), (16, 3, 2), (22, 4, 3), (40, 9, 6)],
}
_QDLDL_AT_MOST = 10_000


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--before', type=Path)
    given = parser.parse_args()
    now = [
        measure(cells, Element(name), solver)
        for name, beams in _BEAMS.items()
        for cells in beams
        for solver in ('multifrontal', 'qdldl')
    ]
    found: dict[str, Any] = {'now': [own for own in now if own is not None]}
    if given.before is not None:
        before = json.loads(given.before.read_text())
        found['before'] = {
            'machine': before['machine'],
            'figures': before['figures']['now'],
        }
    write('factorisation', found)


def measure(cells: tuple[int, int, int], element: Element, solver: str) -> dict[str, Any] | None:
    """Measure one beam with one solver."""
    mesh = beam_mesh(cells, (0.12, 0.03, 0.02))
    pattern = make_pattern(discretise(mesh, element), held_end(mesh, 0.012))
    if solver == 'qdldl' and pattern.size > _QDLDL_AT_MOST:
        return None
    random = np.random.default_rng(0)
    values = random.normal(size=pattern.entry_count)
    values[pattern.diagonal_slots] += 200.0
    side, sides = random.normal(size=pattern.size), random.normal(size=(pattern.size, 9))
    one, other = (make_solver(pattern, solver) for _ in range(2))

    def steps(own: Any) -> None:
        own.factor(values)
        for _ in range(5):
            own.solve(side)

    with ThreadPoolExecutor(2) as pool:
        both = _seconds(lambda: list(pool.map(steps, (one, other))))
    alone = _seconds(lambda: steps(one))
    return {
        'unknowns': pattern.size,
        'element': element.value,
        'solver': solver,
        'factor_ms': 1e3 * _seconds(lambda: one.factor(values)),
        'solve_ms': 1e3 * _seconds(lambda: one.solve(side)),
        'nine_sides_ms': 1e3 * _seconds(lambda: one.solve(sides)),
        'two_bodies_on_two_threads_by_one_body': both / alone,
    }


def _seconds(work: Callable[[], Any]) -> float:
    return statistics.median(timed(work, repeats=7)['median_s'] for _ in range(3))


if __name__ == '__main__':
    main()
