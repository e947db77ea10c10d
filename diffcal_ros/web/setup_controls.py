# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fields and buttons of the set-up page."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from diffcal_ros.proposal.hold import Hold
from diffcal_ros.scene.model import Quantity
from diffcal_ros.web.arrangement import Arrangement
import numpy as np

Edit = Callable[[Arrangement], Arrangement]
OnEdit = Callable[[Edit, str], None]

FIELDS = 'fields'
# The step of a field's arrows [mm, deg] says how many decimals the browser keeps of it.
_STEP, _DIGITS = 0.05, 2


class SetupControls:
    """Fields that show an arrangement and change it, buttons, and lines of text."""

    def __init__(
        self,
        gui: Any,
        ends: Mapping[str, Hold],
        modulus: Quantity,
        on_edit: OnEdit,
        on_button: Mapping[str, Callable[[], None]],
    ) -> None:
        """Add them, empty.

        Args:
            gui: of viser.
            ends: at which the body may be held, by name.
            modulus: its bounds [Pa].
            on_edit: called with how a field changes the arrangement, and `FIELDS`.
            on_button: what each button does, by its label.
        """
        self._ends, self._on_edit = dict(ends), on_edit
        gui.set_panel_label('diffcal init')
        self.status = gui.add_markdown('')
        with gui.add_folder('body, world_from_object'):
            self._position = gui.add_vector3('position [mm]', (0.0, 0.0, 0.0), step=_STEP)
            self._turn = gui.add_vector3('turn [deg]', (0.0, 0.0, 0.0), step=_STEP)
        with gui.add_folder('clamp'):
            self._end = gui.add_dropdown('held end', list(self._ends))
            self._plane = gui.add_number('begins at [mm]', 0.0, step=_STEP)
            self._held = gui.add_markdown('')
        with gui.add_folder("start of Young's modulus"):
            least, most = 1e-3 * modulus.lower, 1e-3 * modulus.upper
            self._modulus = gui.add_number('in kPa', least, min=least, max=most, step=0.1)
            low, high = (round(float(np.log10(1e3 * own)), 2) for own in (least, most))
            self._log_modulus = gui.add_slider('log10 of Pa', low, high, 0.01, low)
        self.buttons = {label: gui.add_button(label) for label in on_button}
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.news = gui.add_markdown('')
        self._bind(on_button)

    def _bind(self, on_button: Mapping[str, Callable[[], None]]) -> None:
        self._bind_field(
            self._position, lambda own, value: own.placed(1e-3 * np.array(value), own.turn)
        )
        self._bind_field(
            self._turn, lambda own, value: own.placed(own.translation, np.deg2rad(value))
        )
        self._bind_field(self._end, lambda own, value: replace(own, hold=self._ends[value]))
        self._bind_field(self._plane, lambda own, value: own.held_from(1e-3 * value))
        self._bind_field(
            self._modulus, lambda own, value: replace(own, youngs_modulus=1e3 * value)
        )
        self._bind_field(
            self._log_modulus, lambda own, value: replace(own, youngs_modulus=10.0**value)
        )
        for label, act in on_button.items():
            self.buttons[label].on_click(_clicked(act))

    def _bind_field(self, field: Any, edit: Callable[[Arrangement, Any], Arrangement]) -> None:
        # Handlers that are coroutines are called in the order of what was typed.
        async def changed(event: Any) -> None:
            if event.client_id is not None:  # Else `show` has set the value.
                value = field.value
                self._on_edit(lambda own: edit(own, value), FIELDS)

        field.on_update(changed)

    def show(self, arrangement: Arrangement, held_count: int) -> None:
        """Show an arrangement, and how many vertices the clamp holds."""
        self._position.value = _rounded(1e3 * arrangement.translation)
        self._turn.value = _rounded(np.rad2deg(arrangement.turn))
        for name, end in self._ends.items():
            if end.direction @ arrangement.hold.direction > 1.0 - 1e-6:
                self._end.value = name
        self._plane.value = round(1e3 * arrangement.hold.plane, _DIGITS)
        self._held.content = f'holds {held_count} vertices of the mesh'
        self._modulus.value = round(1e-3 * arrangement.youngs_modulus, 1)
        self._log_modulus.value = round(float(np.log10(arrangement.youngs_modulus)), 2)


def _rounded(values: Any) -> tuple[float, ...]:
    # No -0.0 in a field.
    return tuple(round(float(value), _DIGITS) + 0.0 for value in values)


def _clicked(act: Callable[[], None]) -> Callable[[Any], Any]:
    async def clicked(_: Any) -> None:
        act()

    return clicked
