"""Blender's materials to core.scene.MaterialParams, one row each, and to programs.

What is the same all over a surface is a row. A material that varies over the surface gets a
program.Program as well; its row then holds means, for mode PAPER, whose tables are made for
one material as a whole.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np

from ....core.data.program import Closure, Displacement, Program
from ....core.data.program_ops import depends_on_around, passes_by_angle
from ....core.scene import (
    ASHIKHMIN_SHIRLEY,
    BECKMANN,
    BLACK,
    DIFFUSE,
    GGX,
    GLOSSY,
    GLOSSY_TOON,
    MULTI_GGX,
    PRINCIPLED,
    SHEEN,
    TOON,
    TRANSLUCENT,
    VELVET_SHEEN,
    MaterialParams,
)
from .displacement import DisplacementRead, read_displacement
from .node_values import NodeReader, follow
from .program_builder import ProgramBuilder
from .program_images import ImageStore
from .seen_tree import seen_tree
from .shader_reader import ShaderReader
from .surface_parts import SurfaceParts, is_constant, is_plain_diffuse

_WHITE, _NO_LIGHT = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)


class MaterialExport(NamedTuple):
    """Materials in their order.

    params: a row each; pass_index: float32 (n,), the value of the material index pass
    programs: one each, None where the row says all
    requests: names of the mesh data that each one's programs need (surface_data.py)
    displacements: what moves vertices, one each; None: nothing does
    """

    params: MaterialParams
    pass_index: np.ndarray
    programs: tuple[Program | None, ...]
    requests: tuple[frozenset[str], ...]
    displacements: tuple[Displacement | None, ...]


@dataclass(frozen=True, slots=True)
class _Surface:
    """A row of MaterialParams."""

    model: int = DIFFUSE
    distribution: int = GGX
    base_color: tuple = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 0.5
    ior: float = 1.5
    specular_level: float = 0.5
    specular_tint: tuple = _WHITE
    emission: tuple = _NO_LIGHT
    diffuse_roughness: float = 0.0


_CLEAR_NEAR = (
    "what it lets through depends on what is near it: as such it is seen, but for its shadow "
    "nothing is near, as for Cycles' light samples"
)
_NOTHING = _Surface(model=BLACK)
_LIKE_LAMBERTS = (TRANSLUCENT, SHEEN, VELVET_SHEEN, TOON)
_OF_CLOSURES = (*_LIKE_LAMBERTS, GLOSSY_TOON)  # models that no row has
# Where there is no material, Cycles shows a new Principled BSDF; before Blender 5 a diffuse grey.
_NO_MATERIAL = (
    _Surface(model=PRINCIPLED, distribution=MULTI_GGX) if bpy.app.version >= (5, 0) else _Surface()
)


def export_materials(
    materials: list, warnings: list[str], users: list[list[str]] | None = None
) -> tuple[MaterialParams, np.ndarray]:
    """The rows alone of what export_shaders gives, and the value of the material index pass."""
    return export_shaders(materials, warnings, users)[:2]


def export_shaders(
    materials: list,
    warnings: list[str],
    users: list[list[str]] | None = None,
    texel_cache=None,
    depsgraph=None,
) -> MaterialExport:
    """The table of materials and their programs.

    materials: bpy materials, evaluated or not; None is a slot left empty
    warnings: gets a line for all that is rendered otherwise than Cycles would
    users: names of the objects that have each material, for these lines
    texel_cache: the TexelCache of the job; depsgraph: whose scene's time nodes ask for
    """
    users = users or [[]] * len(materials)
    images = ImageStore(texel_cache)
    found = [
        _surface_of(material, names, warnings, images, depsgraph)
        for material, names in zip(materials, users, strict=True)
    ]
    surfaces, programs, requests, displacements = zip(*found, strict=True) if found else ((),) * 4
    columns = {}
    for field in MaterialParams._fields:
        values = [getattr(surface, field) for surface in surfaces]
        if field in ("model", "distribution"):
            columns[field] = np.array(values, np.int8)
        else:
            width = (3,) if isinstance(getattr(_NOTHING, field), tuple) else ()
            columns[field] = np.array(values, np.float32).reshape(len(surfaces), *width)
    index = [0 if material is None else material.pass_index for material in materials]
    return MaterialExport(
        MaterialParams(**columns),
        np.array(index, np.float32),
        programs,
        tuple(map(frozenset, requests)),
        displacements,
    )


def _surface_of(material, users, warnings, images, depsgraph):
    """(row, program or None, requests, displacement or None) of one material."""
    if material is None:
        return _NO_MATERIAL, None, (), None
    reader = NodeReader(material.name, users, warnings)
    seen = seen_tree(material)
    if seen is None:
        return _Surface(base_color=tuple(material.diffuse_color[:3])), None, (), None
    output = seen.output
    if output is None:
        reader.warn(None, "has no Material Output node: black, as in Cycles")
        return _NOTHING, None, (), None
    if follow(output.inputs["Volume"]).node is not None:
        reader.warn(output, "Volume is not supported and left out")
    builder = ProgramBuilder(reader, images, depsgraph)
    displacement = read_displacement(material, output, builder)
    builder.displaced = displacement.normal
    shaders = ShaderReader(builder)
    shaders.read(output.inputs["Surface"])
    if follow(output.inputs["Surface"]).node is None:
        if follow(output.inputs["Volume"]).node is not None:  # a volume's box is not there itself
            shaders.parts.transparent.append(np.ones(3, np.float32))
        else:
            reader.warn(output, "nothing is linked to Surface: black, as in Cycles")
    row, program = _finished(shaders.parts, builder, reader, _settings_of(material))
    moving = _moving(displacement, builder)
    requests = () if program is None and moving is None else builder.requests
    return row, program, requests, moving


class _Settings(NamedTuple):
    """Of a material beside its nodes. corrects_bumps: Cycles' Bump Map Correction, on where its
    add-on is not there; throws_whole_shadow: Transparent Shadows are off"""

    corrects_bumps: bool
    throws_whole_shadow: bool


def _settings_of(material) -> _Settings:
    corrects = getattr(getattr(material, "cycles", None), "use_bump_map_correction", True)
    return _Settings(corrects, not material.use_transparent_shadow)


def _finished(
    parts: SurfaceParts, builder: ProgramBuilder, reader: NodeReader, settings: _Settings
):
    """(row, program or None) of all that a tree came to."""
    emission, transparent = builder.added(parts.emission), builder.added(parts.transparent)
    holdout = builder.added(parts.holdout)
    is_more = parts.added and transparent is not None and holdout is None
    shown = builder.added(parts.shown) if is_more else None
    closures = _merged(parts.closures, builder)
    row = _finite(_row_of(closures, emission, builder), reader)
    plain = transparent is None and holdout is None and settings.corrects_bumps
    if plain and _is_row(closures, emission):
        return row, None
    closures = closures or [Closure(BLACK, GGX, np.ones(3, np.float32), {})]
    program = Program(
        ops=builder.ops,
        closures=tuple(closures),
        emission=emission,
        transparent=transparent,
        shown=shown,
        holdout=holdout,
        displaced=builder.displaced,
        **settings._asdict(),
    )
    if parts.tinted and not passes_by_angle(program):
        told = "a colored Transparent BSDF that depends on the ray throws a grey shadow"
        reader.warn(parts.tinted[0], told)
    if transparent is not None and depends_on_around(program, transparent):
        reader.warn(None, _CLEAR_NEAR)
    return row, program


def _moving(read: DisplacementRead, builder: ProgramBuilder) -> Displacement | None:
    if read.moves is None:
        return None
    program = Program(ops=builder.ops, closures=())
    return Displacement(program, read.moves, keeps_normals=read.normal is not None)


def _merged(closures: list[Closure], builder) -> list[Closure]:
    """The same closures, but one for all diffuse ones, with the sum of their colours."""
    matte = [closure for closure in closures if is_plain_diffuse(closure)]
    if len(matte) == 0 or (len(matte) == 1 and len(closures) > 1):
        return closures
    colors = [builder.run("product", A=c.weight, B=c.params["base_color"]) for c in matte]
    one = np.ones(3, np.float32)
    whole = matte[0]._replace(weight=one, params={"base_color": builder.added(colors)})
    return [whole, *(closure for closure in closures if not is_plain_diffuse(closure))]


def _is_row(closures, emission) -> bool:
    if emission is not None and not is_constant(emission):
        return False
    if not closures:
        return True
    closure = closures[0]
    more = (closure.normal, closure.grain, closure.subsurface, closure.hair, closure.film)
    if len(closures) > 1 or more != (None,) * 5 or closure.model in _OF_CLOSURES:
        return False
    if closure.distribution == ASHIKHMIN_SHIRLEY:
        return False
    whole = is_constant(closure.weight) and np.all(np.minimum(closure.weight, 1.0) == 1.0)
    return bool(whole) and all(map(is_constant, closure.params.values()))


def _row_of(closures, emission, builder) -> _Surface:
    """The row that shows a material best: its heaviest closure, what varies by its mean."""

    def constant(value):
        return value if is_constant(value) else builder.mean(value)

    surface, glow = _NOTHING, np.zeros(3, np.float32)
    if emission is not None:
        glow = glow + constant(emission)
    if closures:
        heaviest = max(closures, key=lambda c: float(np.mean(constant(c.weight))))
        params = {name: constant(value) for name, value in heaviest.params.items()}
        values = {name: value.tolist() for name, value in params.items()}
        values = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
        model = DIFFUSE if heaviest.model in _LIKE_LAMBERTS else heaviest.model
        if heaviest.model in (TOON, GLOSSY_TOON):
            size, smooth = values["roughness"], values.pop("diffuse_roughness")
            values["roughness"] = _roughness_of_cap(size, smooth)
            model = DIFFUSE if heaviest.model == TOON else GLOSSY
        distribution = heaviest.distribution
        if distribution == ASHIKHMIN_SHIRLEY:
            distribution = BECKMANN
        surface = _Surface(model=model, distribution=distribution, **values)
    return dataclasses.replace(surface, emission=tuple(map(float, glow)))


def _roughness_of_cap(size: float, smooth: float) -> float:
    """Of a GGX lobe that spreads what it mirrors as a toon cap does: half within the same angle."""
    reach = 0.5 * np.pi * float(np.clip(size, 0.0, 1.0) + 0.5 * np.clip(smooth, 0.0, 1.0))
    return min(float(np.sqrt(reach / np.sqrt(8.0))), 1.0)


def _finite(surface: _Surface, reader) -> _Surface:
    """The surface with 0 for what is no number, as in Cycles."""
    mended = {}
    for field in dataclasses.fields(surface):
        value = np.array(getattr(surface, field.name), np.float32)
        if not np.isfinite(value).all():
            mended[field.name] = np.nan_to_num(value, nan=0.0, posinf=0.0, neginf=0.0).tolist()
            what = field.name.replace("_", " ")
            reader.warn(None, f"{what} is {value}, not finite: {mended[field.name]} instead")
    return dataclasses.replace(surface, **mended)
