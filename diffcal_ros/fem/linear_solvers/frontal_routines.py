# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Compiled code of a multifrontal factorisation on a processor: one call a factorisation.

A body of some thousand unknowns has some hundred fronts, of a few microseconds each: called one
by one from Python most of the time went into the calls, and threads waited for one another there.
Warp compiles what is written here in C++; its dense algebra is that of SciPy's BLAS.
"""

import ctypes
from enum import IntEnum
from functools import cache

from diffcal_ros.fem.linear_solvers.blas_addresses import routine_address
import numpy as np
import warp as wp

wp.set_module_options({'enable_backward': False})

# Of so many columns the triangle's inverse takes less time than smaller products.
AT_ONCE = 48
_ROUTINES = ('potrf', 'trtri', 'trmm', 'gemm', 'syrk', 'trsv', 'trsm', 'gemv')


class Task(IntEnum):
    """What the compiled code is to do."""

    FACTOR = 0
    SOLVE_ONE = 1
    SOLVE_SOME = 2


class Given(ctypes.Structure):
    """What the compiled code is given: numbers, and addresses of arrays and routines.

    Attributes:
        task: a `Task`.
        first: front that is begun with.
        end: the one after the last.
        width: unknowns of a node.
        sides: right-hand sides.
        failed: out: pivot that is not positive, from 1 on; 0: none.
        place: out: its front.
        table: int32 (fronts, 11), see `FrontalPlan.table`.
        children: int32, of all fronts.
        unknowns: int32, of all fronts their own, then their border.
        into: int32, places of the nodes of all borders in their parents.
        store: factors.
        stacks: what children left, by their depth.
        scratch: numbers for one front.
        x: right-hand sides, and in their place solutions; shape (n, sides) by rows.
    """

    _fields_ = [
        *((name, ctypes.c_int64) for name in ('task', 'first', 'end', 'width', 'sides')),
        *((name, ctypes.c_int64) for name in ('failed', 'place')),
        *((name, ctypes.c_void_p) for name in ('table', 'children', 'unknowns', 'into')),
        *((name, ctypes.c_void_p) for name in ('store', 'stack_0', 'stack_1', 'scratch', 'x')),
        *((name, ctypes.c_void_p) for name in _ROUTINES),
    ]

    def find_routines(self, number: type[np.floating]) -> None:
        """Enter the addresses of the routines for numbers of one precision."""
        for name in _ROUTINES:
            setattr(self, name, routine_address(name, number))


# The structure above, and a front as a row of the table; NUMBER is double or float.
_TYPES = """
    typedef NUMBER T;
    typedef void (*Potrf)(const char*, const int*, T*, const int*, int*);
    typedef void (*Trtri)(const char*, const char*, const int*, T*, const int*, int*);
    typedef void (*Trm)(const char*, const char*, const char*, const char*, const int*,
        const int*, const T*, const T*, const int*, T*, const int*);
    typedef void (*Gemm)(const char*, const char*, const int*, const int*, const int*, const T*,
        const T*, const int*, const T*, const int*, const T*, T*, const int*);
    typedef void (*Syrk)(const char*, const char*, const int*, const int*, const T*, const T*,
        const int*, const T*, T*, const int*);
    typedef void (*Trsv)(const char*, const char*, const char*, const int*, const T*, const int*,
        T*, const int*);
    typedef void (*Gemv)(const char*, const int*, const int*, const T*, const T*, const int*,
        const T*, const int*, const T*, T*, const int*);
    struct Front {
        int parent, n, m, into, update, pivots, panel, stack, own_columns, child, unknowns;
    };
    struct Given {
        long long task, first, end, width, sides, failed, place;
        const Front* table;
        const int *children, *unknowns, *into;
        T *store, *stacks[2], *scratch, *x;
        Potrf potrf;
        Trtri trtri;
        Trm trmm;
        Gemm gemm;
        Syrk syrk;
        Trsv trsv;
        Trm trsm;
        Gemv gemv;
    };
    Given& g = *(Given*)address;
"""

_FACTOR = """
    struct Routines {
        // Adds columns of what a child left, a lower triangle, to its parent: node by node.
        static void add(const Given& g, const Front& child, int first, int end) {
            const Front& to = g.table[child.parent];
            const int width = (int)g.width, size = child.m / width, own = to.n / width;
            const int* into = g.into + child.into / width;
            const T* left = g.stacks[child.stack] + child.update;
            for (int column = first; column < end; ++column) {
                int row = column / width;
                const int at = into[row] * width + column % width;
                const T* from = left + (size_t)column * child.m + row * width;
                T* into_own = g.store + to.pivots + (size_t)at * to.n;
                T* rest = g.store + to.panel + (size_t)at * to.m - to.n;
                if (at >= to.n)
                    rest = g.stacks[to.stack] + to.update + (size_t)(at - to.n) * to.m - to.n;
                for (; row < size && into[row] < own; ++row)
                    for (int d = 0; d < width; ++d) into_own[into[row] * width + d] += *from++;
                for (; row < size; ++row)
                    for (int d = 0; d < width; ++d) rest[into[row] * width + d] += *from++;
            }
        }
        // Solves X L' = panel in place for columns: products take half the time of `trsm`.
        static void divide(const Given& g, const Front& f, int start, int end) {
            T *pivots = g.store + f.pivots, *panel = g.store + f.panel;
            const T one = 1, minus = -1;
            if (end - start <= AT_ONCE) {
                // Of so many columns the triangle's inverse does.
                const int n = end - start;
                int failed = 0;
                for (int c = 0; c < n; ++c)
                    for (int r = c; r < n; ++r)
                        g.scratch[c * n + r] = pivots[(size_t)(start + c) * f.n + start + r];
                g.trtri("L", "N", &n, g.scratch, &n, &failed);
                g.trmm("R", "L", "T", "N", &f.m, &n, &one, g.scratch, &n,
                    panel + (size_t)start * f.m, &f.m);
                return;
            }
            const int middle = (start + end) / 2, before = middle - start, after = end - middle;
            divide(g, f, start, middle);
            g.gemm("N", "T", &f.m, &after, &before, &minus, panel + (size_t)start * f.m, &f.m,
                pivots + (size_t)start * f.n + middle, &f.n, &one,
                panel + (size_t)middle * f.m, &f.m);
            divide(g, f, middle, end);
        }
    };
    const T zero = 0, minus = -1;
    for (int i = (int)g.first; i < g.end; ++i) {
        const Front& f = g.table[i];
        const int* children = g.children + f.child;
        const int count = g.table[i + 1].child - f.child;
        for (int c = 0; c < count; ++c) {
            const Front& child = g.table[children[c]];
            Routines::add(g, child, 0, child.own_columns);
        }
        int failed = 0;
        g.potrf("L", &f.n, g.store + f.pivots, &f.n, &failed);
        if (failed) {
            g.failed = failed;
            g.place = i;
            return;
        }
        if (!f.m) continue;
        Routines::divide(g, f, 0, f.n);
        T* left = g.stacks[f.stack] + f.update;
        g.syrk("L", "N", &f.m, &f.n, &minus, g.store + f.panel, &f.m, &zero, left, &f.m);
        for (int c = 0; c < count; ++c) {
            const Front& child = g.table[children[c]];
            Routines::add(g, child, child.own_columns, child.m);
        }
    }
"""

_SOLVE_ONE = """
    const int step = 1;
    const T one = 1, zero = 0, minus = -1;
    for (int i = (int)g.first; i < g.end; ++i) {
        const Front& f = g.table[i];
        const int *own = g.unknowns + f.unknowns, *border = own + f.n;
        T *b = g.scratch, *c = b + f.n;
        for (int r = 0; r < f.n; ++r) b[r] = g.x[own[r]];
        g.trsv("L", "N", "N", &f.n, g.store + f.pivots, &f.n, b, &step);
        for (int r = 0; r < f.n; ++r) g.x[own[r]] = b[r];
        if (!f.m) continue;
        g.gemv("N", &f.m, &f.n, &one, g.store + f.panel, &f.m, b, &step, &zero, c, &step);
        for (int r = 0; r < f.m; ++r) g.x[border[r]] -= c[r];
    }
    for (int i = (int)g.end - 1; i >= g.first; --i) {
        const Front& f = g.table[i];
        const int *own = g.unknowns + f.unknowns, *border = own + f.n;
        T *b = g.scratch, *c = b + f.n;
        for (int r = 0; r < f.n; ++r) b[r] = g.x[own[r]];
        if (f.m) {
            for (int r = 0; r < f.m; ++r) c[r] = g.x[border[r]];
            g.gemv("T", &f.m, &f.n, &minus, g.store + f.panel, &f.m, c, &step, &one, b, &step);
        }
        g.trsv("L", "T", "N", &f.n, g.store + f.pivots, &f.n, b, &step);
        for (int r = 0; r < f.n; ++r) g.x[own[r]] = b[r];
    }
"""

# The same on several sides: rows of x are columns of its transpose, so all turns around.
_SOLVE_SOME = """
    struct Routines {
        static void gather(const Given& g, const int* rows, int count, T* to) {
            const int k = (int)g.sides;
            for (int r = 0; r < count; ++r)
                for (int s = 0; s < k; ++s) to[(size_t)r * k + s] = g.x[(size_t)rows[r] * k + s];
        }
        static void put(const Given& g, const int* rows, int count, const T* from) {
            const int k = (int)g.sides;
            for (int r = 0; r < count; ++r)
                for (int s = 0; s < k; ++s) g.x[(size_t)rows[r] * k + s] = from[(size_t)r * k + s];
        }
    };
    const int k = (int)g.sides;
    const T one = 1, zero = 0, minus = -1;
    for (int i = (int)g.first; i < g.end; ++i) {
        const Front& f = g.table[i];
        const int *own = g.unknowns + f.unknowns, *border = own + f.n;
        T *b = g.scratch, *c = b + (size_t)f.n * k;
        Routines::gather(g, own, f.n, b);
        g.trsm("R", "L", "T", "N", &k, &f.n, &one, g.store + f.pivots, &f.n, b, &k);
        Routines::put(g, own, f.n, b);
        if (!f.m) continue;
        g.gemm("N", "T", &k, &f.m, &f.n, &one, b, &k, g.store + f.panel, &f.m, &zero, c, &k);
        for (int r = 0; r < f.m; ++r)
            for (int s = 0; s < k; ++s) g.x[(size_t)border[r] * k + s] -= c[(size_t)r * k + s];
    }
    for (int i = (int)g.end - 1; i >= g.first; --i) {
        const Front& f = g.table[i];
        const int *own = g.unknowns + f.unknowns, *border = own + f.n;
        T *b = g.scratch, *c = b + (size_t)f.n * k;
        Routines::gather(g, own, f.n, b);
        if (f.m) {
            Routines::gather(g, border, f.m, c);
            g.gemm("N", "N", &k, &f.n, &f.m, &minus, c, &k, g.store + f.panel, &f.m, &one, b, &k);
        }
        g.trsm("R", "L", "N", "N", &k, &f.n, &one, g.store + f.pivots, &f.n, b, &k);
        Routines::put(g, own, f.n, b);
    }
"""


@cache
def frontal_kernel(number: type[np.floating]) -> wp.Kernel:
    """Return the kernel for factors of one precision; its argument is the address of a `Given`.

    One for all tasks: most of the time that it takes to compile goes into what comes before them.
    """
    name = 'double' if number is np.float64 else 'float'
    factor = _FACTOR.replace('AT_ONCE', str(AT_ONCE))
    tasks = {Task.FACTOR: factor, Task.SOLVE_ONE: _SOLVE_ONE, Task.SOLVE_SOME: _SOLVE_SOME}
    bodies = [f'if (g.task == {task.value}) {{{body}}}' for task, body in tasks.items()]
    snippet = '\n'.join([_TYPES.replace('NUMBER', name), *bodies])

    @wp.func_native(snippet)
    def work(address: wp.uint64): ...

    @wp.kernel(enable_backward=False, module='unique')
    def run_fronts(address: wp.uint64):
        work(address)

    return run_fronts
