# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sparse matrices under PETSc's names, for jax-fem where petsc4py has no wheel.

jax-fem puts every stiffness into a PETSc matrix, even where SciPy solves with it. What it then
calls is here on a SciPy matrix; nothing is solved here. Only for use by `jax_fem_peer.py`.
"""

import sys
from types import ModuleType
from typing import Any

import numpy as np
import scipy.sparse


class Mat:
    """A square sparse matrix by rows."""

    def createAIJ(self, size: Any, csr: Any) -> 'Mat':  # noqa: N802
        """Take (row starts, columns, values)."""
        starts, columns, values = csr
        self._rows = scipy.sparse.csr_matrix((values, columns, starts), shape=size)
        return self

    def zeroRows(self, rows: Any) -> None:  # noqa: N802
        """Make rows those of the identity."""
        kept = np.ones(self._rows.shape[0])
        kept[rows] = 0.0
        scaled = scipy.sparse.diags(kept) @ self._rows + scipy.sparse.diags(1.0 - kept)
        self._rows = scaled.tocsr()

    def transpose(self) -> 'Mat':
        """Turn rows into columns, in place as PETSc does."""
        self._rows = self._rows.T.tocsr()
        return self

    def getValuesCSR(self) -> tuple[Any, Any, Any]:  # noqa: N802
        """Return (row starts, columns, values)."""
        return self._rows.indptr, self._rows.indices, self._rows.data

    def getSize(self) -> Any:  # noqa: N802
        """Return rows and columns."""
        return self._rows.shape


class PETSc:
    """The names that jax-fem looks up."""

    Mat = Mat
    IntType = np.int32


def stand_in() -> None:
    """Let `from petsc4py import PETSc` find this."""
    module = ModuleType('petsc4py')
    module.PETSc = PETSc  # type: ignore[attr-defined]
    sys.modules['petsc4py'] = module
