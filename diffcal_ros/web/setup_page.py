# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of `diffcal init --web`: move the body and its clamp, try a modulus, fit, save."""

from collections.abc import Callable
from pathlib import Path
import threading
import traceback
from typing import Any

from diffcal_ros.calibration.results.result import IterationRecord
from diffcal_ros.errors import InputError
from diffcal_ros.report.palette import FITTED
from diffcal_ros.rigid_transform import apply
from diffcal_ros.web.arrangement import Arrangement, ends
from diffcal_ros.web.latest_worker import LatestWorker
from diffcal_ros.web.setup_controls import Edit, SetupControls
from diffcal_ros.web.setup_handles import SetupHandles
from diffcal_ros.web.setup_words import fitted_words, step_words, trial_words
from diffcal_ros.web.stage import draw_surface
from diffcal_ros.web.trial import FittedTrial, Trial

FIT, STOP, TAKE, BACK, SAVE = 'fit', 'stop', 'take what was fitted', 'back to the start', 'save'
_TRY = 'try'
_MOST_STEPS = 30
# Whatever is done for a page that is closed may end for so long [s].
_GRACE = 5.0
_FITTED_NODE = '/fitted'


class SetupPage:
    """Keeps fields, handles and the drawn body together.

    Attributes:
        arrangement: as it is now.
        controls: fields, buttons and lines of text.
        worker: simulates, fits and saves, beside the threads of the page.
        fitted: what the last fit found; None before.
    """

    def __init__(
        self,
        server: Any,
        trial: Trial,
        start: Arrangement,
        save: Callable[[Arrangement], Path],
    ) -> None:
        """Show an arrangement.

        Args:
            server: of viser, with what was measured drawn.
            trial: simulates and fits.
            start: what is shown first.
            save: writes the scene and returns its file.
        """
        self._server, self._trial, self._start, self._save = server, trial, start, save
        self._mesh = trial.scene.mesh
        self.arrangement = start
        self.fitted: FittedTrial | None = None
        self._is_stopped = threading.Event()
        self.worker = LatestWorker(self._tell)
        self.controls = SetupControls(
            server.gui,
            ends(self._mesh, start.hold),
            trial.scene.regions[0].youngs_modulus,
            self.edit,
            {
                FIT: self.ask_fit,
                STOP: self._is_stopped.set,
                TAKE: self.take_fitted,
                BACK: lambda: self.edit(lambda _: self._start),
                SAVE: self.ask_save,
            },
        )
        self.controls.buttons[STOP].disabled = True
        self.controls.buttons[TAKE].disabled = True
        self._handles = SetupHandles(server.scene, self._mesh, start, self.edit)
        self.edit(lambda own: own)

    def edit(self, change: Edit, source: str = '') -> None:
        """Change the arrangement, show it, and have it simulated.

        Args:
            change: returns another one.
            source: name of the handle that is being dragged, which is left alone.
        """
        self.arrangement = arrangement = change(self.arrangement)
        held_count = len(arrangement.hold.vertices(self._mesh))
        with self._server.atomic():
            self.controls.show(arrangement, held_count)
            self._handles.show(arrangement, source)
        self.worker.ask(_TRY, self._try)

    def ask_fit(self) -> None:
        """Have the arrangement fitted."""
        self._is_stopped.clear()
        self.worker.ask(FIT, self._fit)

    def take_fitted(self) -> None:
        """Put the body where the last fit has it, with the fitted modulus."""
        if self.fitted is not None:
            fitted = self.fitted.arrangement
            self.edit(lambda _: fitted)

    def ask_save(self) -> None:
        """Have the scene written as it is arranged now."""
        arrangement = self.arrangement
        self.worker.ask(SAVE, lambda: self._write(arrangement))

    def close(self) -> None:
        """End what is being done for the page, and wait a little for it."""
        self._is_stopped.set()
        self.worker.end()
        self.worker.wait(_GRACE)

    def _try(self) -> None:
        """Simulate quickly, then well, unless the arrangement has changed again."""
        arrangement = self.arrangement
        problem = arrangement.problem(self._mesh)
        if problem:
            raise InputError(problem)
        for is_coarse in (True, False):
            if self.worker.is_outdated(_TRY):
                return
            body = self._trial.simulate(arrangement, is_coarse=is_coarse)
            with self._server.atomic():
                self._handles.draw_body(body)
                self.controls.status.content = trial_words(body.gap, is_coarse=is_coarse)

    def _fit(self) -> None:
        arrangement, controls = self.arrangement, self.controls
        problem = arrangement.problem(self._mesh)
        if problem:
            raise InputError(problem)
        controls.news.content = 'fitting'
        controls.progress.value, controls.progress.visible = 0.0, True
        self._allow(FIT, False)
        try:
            self.fitted = fitted = self._trial.fit(arrangement, self._step)
        finally:
            controls.progress.visible = False
            self._allow(FIT, True)
        there = apply(fitted.arrangement.world_from_object, fitted.body.vertices)
        draw_surface(self._server.scene, _FITTED_NODE, there, fitted.body.triangles, FITTED, 0.6)
        controls.news.content = fitted_words(fitted.result)
        controls.buttons[TAKE].disabled = False

    def _step(self, record: IterationRecord) -> bool:
        self.controls.progress.value = 100.0 * min(1.0, record.number / _MOST_STEPS)
        self.controls.news.content = step_words(record)
        return not self._is_stopped.is_set()

    def _allow(self, button: str, is_allowed: bool) -> None:
        self.controls.buttons[button].disabled = not is_allowed
        self.controls.buttons[STOP].disabled = is_allowed

    def _write(self, arrangement: Arrangement) -> None:
        problem = arrangement.problem(self._mesh)
        if problem:
            raise InputError(f'not saved: {problem}')
        self.controls.news.content = f'saved as `{self._save(arrangement)}`'

    def _tell(self, error: Exception) -> None:
        """Say on the page what went wrong; a fault of this program in the terminal, too."""
        if not isinstance(error, InputError):
            traceback.print_exception(error)
        self.controls.news.content = f'**{error}**'
