# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sparse direct solvers of symmetric matrices behind one interface, chosen by name."""

from collections.abc import Callable
import importlib.util
from typing import Any

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError, SparseSolver
from diffcal_ros.fem.linear_solvers.mkl import say_where_mkl_is

__all__ = [
    'SOLVER_NAMES',
    'NotPositiveDefiniteError',
    'SparseSolver',
    'fast_solver',
    'make_solver',
]

# Below this many unknowns a simplicial factorisation is as fast, and needs less to be set up.
_QDLDL_LIMIT = 2000
# From so many unknowns on a GPU factors in less time than the processor beside it.
_GPU_LEAST = 10_000


def _superlu(pattern: SparsePattern, *_: Any) -> SparseSolver:
    from diffcal_ros.fem.linear_solvers.superlu import SuperLuSolver

    return SuperLuSolver(pattern)


def _qdldl(pattern: SparsePattern, *_: Any) -> SparseSolver:
    from diffcal_ros.fem.linear_solvers.qdldl_solver import QdldlSolver

    return QdldlSolver(pattern)


def _cholmod(pattern: SparsePattern, *_: Any) -> SparseSolver:
    from diffcal_ros.fem.linear_solvers.cholmod import CholmodSolver

    return CholmodSolver(pattern)


def _pardiso(pattern: SparsePattern, *_: Any) -> SparseSolver:
    say_where_mkl_is()
    from diffcal_ros.fem.linear_solvers.pardiso import PardisoSolver

    return PardisoSolver(pattern)


def _multifrontal(pattern: SparsePattern, needs_exact: bool | None, _: str) -> SparseSolver:
    from diffcal_ros.fem.linear_solvers.multifrontal import MultifrontalSolver

    # Without a wish large bodies alone are factored in single precision.
    is_exact = {True: True, False: None, None: False}[needs_exact]
    return MultifrontalSolver(pattern, is_exact=is_exact)


def _multifrontal_torch(pattern: SparsePattern, _: bool | None, device: str) -> SparseSolver:
    from diffcal_ros.fem.linear_solvers.multifrontal_torch import TorchMultifrontalSolver

    return TorchMultifrontalSolver(pattern, device)


_MAKERS: dict[str, tuple[str, str, Callable[[SparsePattern, bool | None, str], SparseSolver]]] = {
    'pardiso': ('pypardiso', "pip install 'diffcal_ros[fast]'", _pardiso),
    'cholmod': ('cvxopt', "pip install 'diffcal_ros[cholmod]' (GPL)", _cholmod),
    'qdldl': ('qdldl', 'pip install qdldl', _qdldl),
    'multifrontal': ('scipy', 'pip install scipy', _multifrontal),
    'multifrontal_torch': ('torch', "pip install 'diffcal_ros[torch]'", _multifrontal_torch),
    'superlu': ('scipy', 'pip install scipy', _superlu),
}
SOLVER_NAMES = ('auto', *_MAKERS)


def _is_installed(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def fast_solver() -> str | None:
    """Return the name of the fastest solver beside those that come along; None: not installed."""
    return next((n for n in ('pardiso', 'cholmod') if _is_installed(_MAKERS[n][0])), None)


def make_solver(
    pattern: SparsePattern,
    name: str = 'auto',
    *,
    needs_exact: bool | None = False,
    device: str = 'cpu',
) -> SparseSolver:
    """Make a solver for matrices of one pattern.

    Args:
        pattern: where the entries are.
        name: `auto` takes the fastest that is installed: Pardiso, CHOLMOD, then QDLDL for small
            and multifrontal for larger bodies; for large ones on a GPU, PyTorch there.
        needs_exact: solutions must be good to double precision, see `SparseSolver.is_exact`;
            None: single precision will do for a body of any size.
        device: where the body's elements are; only `multifrontal_torch` factors there.

    Raises:
        ValueError: for an unknown name.
        ImportError: when the named solver is not installed, with the command that installs it.
    """
    if name == 'auto':
        name = _fastest(pattern.size, device)
    if name not in _MAKERS:
        raise ValueError(
            f'sparse solver {name!r} is unknown: use one of {", ".join(SOLVER_NAMES)}'
        )
    module, command, maker = _MAKERS[name]
    if not _is_installed(module):
        raise ImportError(f'sparse solver {name!r} needs {module}: run {command}')
    return maker(pattern, needs_exact, device)


def _fastest(size: int, device: str) -> str:
    if size >= _GPU_LEAST and device.startswith('cuda') and _serves_gpus():
        return 'multifrontal_torch'
    return fast_solver() or ('qdldl' if size < _QDLDL_LIMIT else 'multifrontal')


def _serves_gpus() -> bool:
    """Tell whether PyTorch is here, and built for GPUs."""
    if not _is_installed('torch'):
        return False
    import torch

    return torch.cuda.is_available()
