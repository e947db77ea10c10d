# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Progress of a fit on standard error: a bar on a terminal, plain lines elsewhere."""

import sys
from types import TracebackType
from typing import Any

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import IterationRecord
from diffcal_ros.report.naming import short_values

_BAR = '{desc:<12} |{bar:10}| {n_fmt}/{total_fmt} [{elapsed}]{postfix}'


class Progress:
    """Follows one fit; use it in a `with` block."""

    def __init__(self, most_iterations: int) -> None:
        """Start following.

        Args:
            most_iterations: after which the fit gives up; most fits need far fewer.
        """
        self.last: IterationRecord | None = None
        self._total = most_iterations
        self._bar: Any = None

    def __enter__(self) -> 'Progress':
        if sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(
                total=self._total, desc='preparing', bar_format=_BAR, dynamic_ncols=True
            )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.set_description_str('done' if kind is None else 'stopped')
            self._bar.close()

    def say(self, text: str) -> None:
        """Print a line, above the bar where there is one."""
        if self._bar is not None:
            self._bar.write(text, file=sys.stderr)
        else:
            print(text, file=sys.stderr, flush=True)

    def step(self, record: IterationRecord) -> bool:
        """Show the state after a step; the fit goes on."""
        self.last = record
        text = f'{_gap_words(record.gap)}, {short_values(record.values)}'
        if self._bar is None:
            self.say(f'iteration {record.number}: loss {record.loss:.5g}, {text}')
        else:
            self._bar.n = record.number
            self._bar.set_description_str('fitting', refresh=False)
            self._bar.set_postfix_str(text)
        return True


def _gap_words(gap: Gap) -> str:
    if gap.pixels == 0:
        return 'body not found'
    return f'gap {1e3 * gap.median:.2f} mm on {gap.coverage:.0%}'
