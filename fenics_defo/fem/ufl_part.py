"""Laws whose energy is a UFL expression: forms that DOLFINx compiles."""

from functools import cached_property

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.algorithms import extract_coefficients
from ufl.core.expr import Expr

from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.cell_kernels import add_kernel
from fenics_defo.fem.cell_points import BATCH, cell_points
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.forms import EnergyForms
from fenics_defo.fem.jit import compiled, compiled_at_points, differentiated

Array = NDArray[np.float64]
_CELL = dolfinx.fem.IntegralType.cell


class UflPart:
    """Energy, force and tangent of UFL laws; each form is compiled on its first use.

    Args:
        forms: the laws' forms, and the displacement they are taken at.
    """

    def __init__(self, forms: EnergyForms) -> None:
        self._forms = forms

    @cached_property
    def _energy(self) -> "dolfinx.fem.Form":
        return compiled(self._forms.energy)

    @cached_property
    def _force(self) -> "dolfinx.fem.Form":
        return compiled(self._forms.force)

    @cached_property
    def _tangents(self) -> "list[_LawTangent]":
        degree = self._forms.degree
        space = self._forms.displacement.function_space
        return [_LawTangent(space, *each, degree) for each in self._forms.tangents]

    @cached_property
    def _direction(self) -> "dolfinx.fem.Function":
        return dolfinx.fem.Function(self._forms.displacement.function_space, name="direction")

    @cached_property
    def _derivatives(self) -> "list[_LawTangent]":
        """∫ ∇v : (∂³ψ/∂F³ : ∇d) : ∇u dX of each law that is not linear."""
        degree, u, d = self._forms.degree, self._forms.displacement, self._direction
        moduli = [
            (cells, differentiated(ufl.derivative(differentiated(modulus), u, d)))
            for cells, modulus in self._forms.tangents
        ]
        return [
            _LawTangent(u.function_space, cells, change, degree)
            for cells, change in moduli
            if not isinstance(change, ufl.classes.Zero)
        ]

    def _deform(self, local: Array) -> None:
        self._forms.displacement.x.array[:] = local.ravel()

    def energy(self, local: Array) -> float:
        """This rank's share of the strain energy [J] at a displacement (d, 3) [m]."""
        self._deform(local)
        return float(dolfinx.fem.assemble_scalar(self._energy))

    def add_force(self, local: Array, force: Array) -> None:
        """Add this rank's share of the internal force to (d, 3) [N]."""
        self._deform(local)
        dolfinx.fem.assemble_vector(force.reshape(-1), self._force)

    def add_tangent(self, local: Array, blocks: BlockMatrix, force: Array | None) -> None:
        """Add this rank's share of the tangent, and of the force where an array is given for it."""
        self._deform(local)
        for tangent in self._tangents:
            tangent.add(blocks)
        if force is not None:
            dolfinx.fem.assemble_vector(force.reshape(-1), self._force)

    def add_tangent_derivative(self, local: Array, direction: Array, blocks: BlockMatrix) -> None:
        """Add this rank's share of the tangent's derivative along a displacement (d, 3)."""
        self._deform(local)
        self._direction.x.array[:] = direction.ravel()
        for derivative in self._derivatives:
            derivative.add(blocks)


class _LawTangent:
    """∫ ∇v : C : ∇u dX of one law, with C = ∂²ψ/∂F² or its derivative along a displacement.

    FFCx's kernel for this bilinear form takes twice as long, and longer to compile: here it gives
    C at the points only, and the products with the gradients are the same for all laws.

    Args:
        space: displacement space.
        cells: the law's.
        modulus: C (3, 3, 3, 3).
        degree: that the quadrature integrates exactly.
    """

    def __init__(
        self,
        space: "dolfinx.fem.FunctionSpace",
        cells: NDArray[np.int32],
        modulus: Expr,
        degree: int,
    ) -> None:
        self._mesh = space.mesh
        self._cells = cells[cells < space.mesh.topology.index_map(3).size_local]
        quadrature = cell_points(space, self._cells, degree)
        self._loops = quadrature.loops
        modulus = differentiated(modulus)
        if not extract_coefficients(modulus):
            # DOLFINx learns from a coefficient what mesh an expression belongs to.
            one = dolfinx.fem.Function(dolfinx.fem.functionspace(space.mesh, ("DG", 0)))
            one.x.array[:] = 1.0
            modulus = one * modulus
        self._modulus = compiled_at_points(modulus, quadrature.points)
        count = len(quadrature.points)
        self._batch = max(BATCH // count, 1)
        self._values = np.empty((self._batch, count, 3, 3, 3, 3))
        self._positions: NDArray[np.int32] | None = None

    def add(self, blocks: BlockMatrix) -> None:
        """Add this rank's share at the present displacement."""
        if self._positions is None:
            self._positions = np.ascontiguousarray(blocks.positions[self._cells])
        for begin in range(0, len(self._cells), self._batch):
            some = slice(begin, min(begin + self._batch, len(self._cells)))
            cells = self._cells[some]
            values = self._modulus.eval(self._mesh, cells, self._values[: len(cells)])
            self._loops.add_tangents(some, values, self._positions, blocks.values)


def add_form(form: "dolfinx.fem.Form", blocks: BlockMatrix) -> None:
    """Add this rank's share of a bilinear form, on cells or on exterior facets.

    DOLFINx's own loop does the same through a search for each block's place; here the places are
    known.
    """
    if form.ufcx_form is None:  # a form of zero
        return
    mesh, ufcx, ffi = form.mesh, form.ufcx_form, form.module.ffi
    constants = dolfinx.fem.pack_constants(form)
    geometry = (mesh.geometry.x, mesh.geometry.dofmaps[0])
    for (kind, number), coefficients in dolfinx.fem.pack_coefficients(form).items():
        begin = ufcx.form_integral_offsets[kind.value]
        integral = ufcx.form_integrals[begin + number]
        domain = form._cpp_object.domains(kind, number)
        cells, facets = np.ascontiguousarray(domain, np.int32), None
        if kind != _CELL:
            cells, facets = (np.ascontiguousarray(column) for column in cells.reshape(-1, 2).T)
        address = int(ffi.cast("uintptr_t", integral.tabulate_tensor_float64))
        packed = coefficients, constants
        add_kernel(address, (cells, facets), packed, geometry, blocks.positions, blocks.values)
