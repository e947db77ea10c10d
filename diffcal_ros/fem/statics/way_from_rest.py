# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body comes to its first equilibrium: past slack cables, with a clamp that moves."""

from collections.abc import Callable, Sequence
from contextlib import suppress

from diffcal_ros.fem.held_part import HeldPath
from diffcal_ros.fem.statics.cable_tightening import loosen, needs_steps, tighten
from diffcal_ros.fem.statics.equilibrium import Equilibrium, EquilibriumError, EquilibriumSolver
from diffcal_ros.fem.terms.cable import CableTerm
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Where linear elements end [m], shape (N, 3), with the cables as they are or slack.
LinearShape = Callable[[bool], FloatArray]

_FIRST_FRACTION = 0.1  # 18 degrees of a half turn.
_SMALLEST_FRACTION = 0.002


class WayFromRest:
    """Leads one body from its shape at rest to an equilibrium."""

    def __init__(
        self, solver: EquilibriumSolver, rest: FloatArray, cables: Sequence[CableTerm]
    ) -> None:
        """Take what is solved.

        Args:
            solver: of the body.
            rest: its nodes at rest [m], shape (N, 3).
            cables: that pull at it.
        """
        self._solver, self._rest, self._cables = solver, rest, tuple(cables)

    def solve(
        self, loads: FloatArray, held: HeldPath | None, linear: LinearShape | None
    ) -> Equilibrium:
        """Find the equilibrium at the end of the clamp's motion.

        Args:
            loads: external forces [N], shape (N, 3).
            held: motion of the held nodes; None: they stay.
            linear: starts quadratic elements where linear ones end, which take steps 20 times
                faster and end close; None: the elements are linear.

        Raises:
            EquilibriumError: when no equilibrium was found.
        """
        if not needs_steps(self._cables, self._rest):
            return self._with_slack_cables(loads, held, linear)
        if linear is not None:
            # Where that fails, the steps below are slower and surer.
            with suppress(EquilibriumError):
                return self._from(linear(True), loads, held)
        wanted = loosen(self._cables, self._rest)
        slack = self._with_slack_cables(loads, held, linear)
        return tighten(self._cables, wanted, self._solver, loads, slack.positions)

    def _with_slack_cables(
        self, loads: FloatArray, held: HeldPath | None, linear: LinearShape | None
    ) -> Equilibrium:
        if held is None:
            return self._load(loads, None)
        if linear is not None:
            # Where a soft part takes nearly the whole turn, the two elements end far apart.
            with suppress(EquilibriumError):
                return self._from(linear(False), loads, held)
        return self._follow(loads, held)

    def _from(self, start: FloatArray, loads: FloatArray, held: HeldPath | None) -> Equilibrium:
        end = None if held is None else held(1.0)
        return self._solver.solve(loads, start, held_positions=end)

    def _load(self, loads: FloatArray, held: FloatArray | None) -> Equilibrium:
        """Load the body at rest, its held nodes at places [m], shape (H, 3); None: they stay.

        With pressures foreseen some bodies that are far too soft for their load come to rest that
        do not without, and the other way round.
        """
        try:
            return self._solver.solve(loads, self._rest, held_positions=held)
        except EquilibriumError:
            if not self._solver.stiffness.foresees:
                raise
        return self._solver.solve(loads, self._rest, held_positions=held, is_foreseen=False)

    def _follow(self, loads: FloatArray, held: HeldPath) -> Equilibrium:
        """Load the body at rest, then move the clamp in steps that grow while they succeed."""
        state = self._load(loads, held(0.0))
        fraction, step = 0.0, _FIRST_FRACTION
        while fraction < 1.0:
            step = min(step, 1.0 - fraction)
            try:
                state = self._solver.solve(
                    loads, state.positions, held_positions=held(fraction + step)
                )
            except EquilibriumError as error:
                step *= 0.5
                if step < _SMALLEST_FRACTION:
                    raise EquilibriumError(
                        f'the clamp got stuck after {fraction:.0%} of its motion: {error}'
                    ) from error
                continue
            fraction += step
            step *= 1.5
        return state
