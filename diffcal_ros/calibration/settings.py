# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Choices of a calibration that are not part of the scene."""

from dataclasses import dataclass

from diffcal_ros.errors import InputError

LOSSES = ('robust', 'paper', 'l1')
OPTIMIZERS = ('gauss_newton', 'adam_demon')


@dataclass(frozen=True)
class CalibrationSettings:
    """How to fit.

    Attributes:
        fit: names of the parameters; None: as the scene says.
        loss: `robust` (masked, default), `paper` (whole-image L2) or `l1`.
        optimizer: `gauss_newton` (with Levenberg-Marquardt damping) or `adam_demon` (the
            paper's).
        max_iterations: of either; None: 30, or 100 for Adam.
        solver: name of the sparse solver.
        device: Warp device.
        with_mesh_error: estimate what halving the mesh size, and a motion's time step, would
            change.
        profile: names of parameters whose likelihood is profiled after the fit.
        search: look over the whole range of modulus and placement for where to start, and for
            other places that explain the data about as well; of bodies at rest and the robust
            loss.
        looks_farther: where the search ends at nothing that can be used, try whether the depth
            camera reads one of several materials too far or too near, and whether the placement
            is stated wrongly.
        patience: steps on end that lead nowhere before the robust fit of a motion ends, for who
            fits on from there; None: as long as a step promises a tenth of an error.
    """

    fit: tuple[str, ...] | None = None
    loss: str = 'robust'
    optimizer: str = 'gauss_newton'
    max_iterations: int | None = None
    solver: str = 'auto'
    device: str = 'cpu'
    with_mesh_error: bool = True
    profile: tuple[str, ...] = ()
    search: bool = True
    looks_farther: bool = True
    patience: int | None = None

    def __post_init__(self) -> None:
        if self.loss not in LOSSES:
            raise InputError(f'loss is {self.loss!r}: use one of {", ".join(LOSSES)}')
        if self.optimizer not in OPTIMIZERS:
            raise InputError(
                f'optimizer is {self.optimizer!r}: use one of {", ".join(OPTIMIZERS)}'
            )
        if self.max_iterations is not None and self.max_iterations < 1:
            raise InputError(f'max_iterations is {self.max_iterations}: give at least 1')
        if self.optimizer == 'adam_demon' and self.loss == 'robust':
            raise InputError(
                "adam_demon minimises the whole-image losses 'paper' and 'l1': choose one of "
                'them with --loss, or gauss_newton for the robust loss'
            )
