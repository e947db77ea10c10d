# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""USD: a TetMesh under the proposed physics schema of deformable bodies, as Newton reads it.

The schema is not registered in usd-core, so its names are applied as such. Omniverse's older names
stand beside them. A stage has one material for the whole body where there is one, and subsets with
their own where there are several; a reader that knows no subsets takes the mean.
"""

from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.errors import InputError
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.material_groups import material_groups, MaterialGroup
import numpy as np

SIMULATOR = 'physx'
_NAMESPACES = ('physics', 'omniphysics')
_ROOT = '/World'


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.usda`."""
    try:
        from pxr import Usd, UsdGeom, UsdPhysics
    except ImportError as error:
        raise InputError(
            "USD files are written by usd-core: install it with `pip install 'diffcal_ros[usd]'`"
        ) from error
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    world = UsdGeom.Xform.Define(stage, _ROOT)
    stage.SetDefaultPrim(world.GetPrim())
    _put_gravity(stage, body)
    deformable = UsdGeom.Xform.Define(stage, f'{_ROOT}/deformable').GetPrim()
    deformable.AddAppliedSchema('PhysicsDeformableBodyAPI')
    mesh = _put_mesh(stage, f'{_ROOT}/deformable/mesh', body)
    _put_materials(stage, mesh, body)
    path = folder / 'body.usda'
    write_text_atomically(path, stage.GetRootLayer().ExportToString())
    return [path]


def _put_gravity(stage: Any, body: ExportedBody) -> None:
    from pxr import Gf, UsdPhysics

    size = float(np.linalg.norm(body.gravity))
    scene = UsdPhysics.Scene.Define(stage, f'{_ROOT}/physics')
    scene.CreateGravityMagnitudeAttr(size)
    direction = body.gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
    scene.CreateGravityDirectionAttr(Gf.Vec3f(*(float(value) for value in direction)))


def _put_mesh(stage: Any, path: str, body: ExportedBody) -> Any:
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.TetMesh.Define(stage, path)
    points = body.mesh.rest_positions.astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateTetVertexIndicesAttr(Vt.Vec4iArray.FromNumpy(body.mesh.tets))
    triangles = Vt.Vec3iArray.FromNumpy(body.mesh.surface_triangles)
    mesh.CreateSurfaceFaceVertexIndicesAttr(triangles)
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(body.mesh.extent.astype(np.float32)))
    mesh.GetPrim().AddAppliedSchema('PhysicsVolumeDeformableSimAPI')
    _put_subset(mesh, 'held', UsdGeom.Tokens.point, body.held, 'held')
    return mesh


def _put_subset(mesh: Any, name: str, kind: str, indices: Any, family: str) -> Any:
    from pxr import UsdGeom, Vt

    numbers = Vt.IntArray.FromNumpy(np.asarray(indices, dtype=np.int32))
    return UsdGeom.Subset.CreateGeomSubset(mesh, name, kind, numbers, family)


def _put_materials(stage: Any, mesh: Any, body: ExportedBody) -> None:
    from pxr import Tf, UsdGeom, UsdShade

    groups = material_groups(body)
    whole = groups[0] if len(groups) == 1 else _mean(body)
    _bind(mesh.GetPrim(), _material(stage, 'material', whole))
    if len(groups) == 1:
        return
    for group in groups:
        name = Tf.MakeValidIdentifier(group.name)
        kind = UsdGeom.Tokens.tetrahedron
        subset = _put_subset(mesh, name, kind, group.tets, UsdShade.Tokens.materialBind)
        _bind(subset.GetPrim(), _material(stage, f'material_{name}', group))


def _mean(body: ExportedBody) -> MaterialGroup:
    """Return the material of a body that is the same everywhere and as heavy."""
    weights = body.mesh.volumes / body.volume
    return MaterialGroup(
        name='mean',
        tets=np.arange(body.mesh.tet_count, dtype=np.int32),
        youngs_modulus=float(np.exp(weights @ np.log(body.youngs_modulus))),
        poissons_ratio=float(weights @ body.poissons_ratio),
        density=float(weights @ body.density),
        stiffness_damping=float(weights @ body.stiffness_damping),
    )


def _material(stage: Any, name: str, group: MaterialGroup) -> Any:
    from pxr import Sdf, UsdShade

    material = UsdShade.Material.Define(stage, f'{_ROOT}/{name}')
    prim = material.GetPrim()
    prim.AddAppliedSchema('PhysicsVolumeDeformableMaterialAPI')
    values = {
        'youngsModulus': group.youngs_modulus,
        'poissonsRatio': group.poissons_ratio,
        'density': group.density,
    }
    for namespace in _NAMESPACES:
        for key, value in values.items():
            attribute = prim.CreateAttribute(f'{namespace}:{key}', Sdf.ValueTypeNames.Float)
            attribute.Set(value)
    damping = prim.CreateAttribute('diffcal:stiffnessDamping', Sdf.ValueTypeNames.Float)
    damping.Set(group.stiffness_damping)
    return material


def _bind(prim: Any, material: Any) -> None:
    from pxr import UsdShade

    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, 'physics')
