# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Adam with decaying momentum (Demon; Chen et al. 2022), the optimiser of the paper, in torch.

The momentum of step t of T is beta_t = beta (1 - t/T) / ((1 - beta) + beta (1 - t/T)). The
gradient comes from the adjoint of simulator and tracer; torch sees one function.
"""

from collections.abc import Callable
from typing import Any, TYPE_CHECKING

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.errors import InputError
from diffcal_ros.least_squares.levenberg_marquardt import Iteration, Minimum, Stop
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import torch

FloatArray = NDArray[np.float64]

_SETTLED = 0.01
_STEP_LENGTH = 1e-3  # Of the body's nodes, RMS [m].
_BETA_1, _BETA_2, _EPSILON = 0.9, 0.999, 1e-8


def import_torch() -> Any:
    """Import torch, or say how to install it."""
    try:
        import torch
    except ImportError as error:
        raise InputError(
            "the optimizer adam_demon needs torch: run pip install 'diffcal_ros[torch]', or use "
            '--optimizer gauss_newton, which needs nothing and fewer iterations'
        ) from error
    return torch


def differentiable_loss(objective: ImageObjective, coordinates: 'torch.Tensor') -> 'torch.Tensor':
    """Return the loss as a torch scalar that knows its gradient.

    Args:
        objective: a whole-image loss.
        coordinates: float64, shape (k,).
    """
    torch = import_torch()

    class _Loss(torch.autograd.Function):  # type: ignore[misc, name-defined]
        @staticmethod
        def forward(ctx: Any, point: Any) -> Any:
            value, gradient = objective.gradient(point.detach().cpu().numpy())
            ctx.save_for_backward(torch.from_numpy(gradient))
            return torch.tensor(value, dtype=torch.float64)

        @staticmethod
        def backward(ctx: Any, upstream: Any) -> Any:
            (gradient,) = ctx.saved_tensors
            return upstream * gradient

    return _Loss.apply(coordinates)


def learning_rates(model: ForwardModel, start: FloatArray, longest: FloatArray) -> FloatArray:
    """Choose steps that each move the body by a millimetre, shape (k,).

    The paper's rates, 0.1 to 1e7, were found by trying: its parameters have units, and how far the
    body follows them differs from case to case. The model's tangents know it.

    Args:
        model: with its tangents.
        start: coordinates, shape (k,).
        longest: step of each coordinate that is not to be exceeded, shape (k,).
    """
    moved = np.concatenate(model.tangents(start), axis=1)
    sensitivity = np.sqrt((moved**2).sum(axis=2).mean(axis=1))
    return np.minimum(_STEP_LENGTH / np.maximum(sensitivity, 1e-12), longest)


def minimise_with_demon(
    objective: ImageObjective,
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    step_sizes: FloatArray,
    *,
    max_iterations: int = 100,
    on_iteration: Callable[[Iteration], bool] | None = None,
) -> Minimum:
    """Minimise a whole-image loss as the paper does.

    Args:
        objective: the loss.
        start: coordinates, shape (k,).
        bounds: lower and upper, shape (k,) each; steps are clipped to them.
        step_sizes: learning rate of each coordinate, shape (k,).
        max_iterations: T; the momentum has decayed to 0 after as many.
        on_iteration: told of every step; returns False to stop.
    """
    torch = import_torch()
    report = on_iteration or (lambda _: True)
    lower, upper = (torch.from_numpy(np.ascontiguousarray(bound)) for bound in bounds)
    point = torch.from_numpy(np.clip(start, *bounds)).requires_grad_(True)
    rate = torch.from_numpy(step_sizes)
    momentum, square = torch.zeros_like(point), torch.zeros_like(point)
    best_loss, best = float('inf'), point.detach().numpy().copy()
    stop, step, path = Stop.EXHAUSTED, 0, []
    for step in range(max_iterations):
        loss = differentiable_loss(objective, point)
        path.append(point.detach().numpy().copy())
        if loss.item() < best_loss:
            best_loss, best = loss.item(), path[-1]
        if not report(Iteration(step, path[-1], loss.item())):
            stop = Stop.INTERRUPTED
            break
        point.grad = None
        loss.backward()  # type: ignore[no-untyped-call]
        left = 1.0 - step / max_iterations
        beta = _BETA_1 * left / ((1.0 - _BETA_1) + _BETA_1 * left)
        with torch.no_grad():
            momentum = beta * momentum + point.grad
            square = _BETA_2 * square + (1.0 - _BETA_2) * point.grad**2
            scale = (square / (1.0 - _BETA_2 ** (step + 1))).sqrt() + _EPSILON
            # The momentum sums 1 / (1 - beta) gradients: take that out of the step.
            moved = point - rate * (1.0 - beta) * momentum / scale
            point.copy_(torch.minimum(torch.maximum(moved, lower), upper))
    if stop is Stop.EXHAUSTED and _has_settled(path):
        stop = Stop.CONVERGED
    return Minimum(best, objective.linearise(best), step, stop)


def _has_settled(path: list[FloatArray]) -> bool:
    """Tell whether the last tenth of the steps moved nothing by more than 1 %."""
    last = np.stack(path[-max(2, len(path) // 10) :])
    return bool(np.ptp(last, axis=0).max(initial=0.0) < _SETTLED)
