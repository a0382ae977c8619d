"""Materials that vary over the surface, as plain data: what to compute at a shading point.

A Program is a list of node operations in the order of evaluation, compiled from a shader tree by
the exporter and evaluated over the points of a tile by core/nodes. Values are float32: numbers (n,)
or (), vectors and colours (n, 3) or (3,).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np


class Ref(NamedTuple):
    """The output of an earlier operation."""

    op: int
    output: str


Value = Ref | np.ndarray  # a constant: float32 () or (3,)


class Op(NamedTuple):
    """One node.

    kind: key of core.nodes.FUNCTIONS, Blender's bl_idname where the node has one
    inputs: identifier of a socket -> its value; a socket that takes the point's own normal or
        coordinates where nothing is linked is not there
    settings: the node's properties, images and curves
    """

    kind: str
    inputs: Mapping[str, Value]
    settings: Mapping[str, object]


class Subsurface(NamedTuple):
    """What of a closure's Lambert lobe is light from under the surface (core/walks/subsurface.py).

    share: of the lobe, 0 to 1; method: as Media.method; the rest: values of Media's columns
    """

    share: Value
    radius: Value
    anisotropy: Value
    ior: Value
    roughness: Value
    method: int


# Hair.model: Cycles' Principled Hair, and the two components of its Hair BSDF
HAIR_CHIANG, HAIR_BELL_REFLECTION, HAIR_BELL_TRANSMISSION = 0, 1, 2


class Hair(NamedTuple):
    """What a strand makes of light (core/bsdf/hair.py), values as the node has them.

    tangent: a vector, along the strand; absorption: a colour, of light over the strand's radius
    roughness, radial: along and round the strand; offset: radians
    """

    model: int
    tangent: Value
    absorption: Value
    roughness: Value
    radial: Value
    coat: Value
    ior: Value
    offset: Value


class ThinFilm(NamedTuple):
    """A thin film on a PRINCIPLED closure (core/bsdf/thin_film.py).

    thickness: nm; ior: its index; space: of core/bsdf/thin_film_tables.py, how its colors are seen
    index, extinction: colours, of a metal that is given by these; None: by its own colours
    """

    thickness: Value
    ior: Value
    space: int
    index: Value | None = None
    extinction: Value | None = None


class Closure(NamedTuple):
    """One BSDF of a mixture.

    model: as in MaterialParams, or TRANSLUCENT (DIFFUSE on the side away from the viewer), SHEEN,
        VELVET_SHEEN (sheen.py), TOON, GLOSSY_TOON (toon.py: roughness is Size, diffuse_roughness
        Smooth); distribution: as there, or ASHIKHMIN_SHIRLEY
    weight: a colour, the factor of all it reflects
    params: column of MaterialParams -> its value; a missing one is that of the material's own row
    normal: a vector; None: the surface's own
    grain: a vector along the facets' tangent, as long as the root of alpha_x / alpha_y; None: round
    subsurface: None: light leaves where it has come in
    hair: of what a DIFFUSE closure has in front, a TRANSLUCENT one behind; None: it is no strand
    film: None: there is none
    """

    model: int
    distribution: int
    weight: Value
    params: Mapping[str, Value]
    normal: Value | None = None
    grain: Value | None = None
    subsurface: Subsurface | None = None
    hair: Hair | None = None
    film: ThinFilm | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Program:
    """The surface of one material.

    closures: at least one; they add up
    emission: a colour, radiance; None: it does not glow
    transparent: a colour, the share of light that goes straight through; None: it is opaque
    shown: a colour, the weight of all that does not pass, where both may be more than 1 (added to a
        Transparent BSDF); None: what transparent leaves
    holdout: a colour, the share that is a hole in the picture; None: nothing is
    displaced: a vector, the normal that counts as the surface's own; None: it is that of the mesh
    corrects_bumps: whether turned normals are shadowed and kept clear of the surface (bump.py,
        core/bsdf/glossy_normal.py)
    throws_whole_shadow: whether shadow rays end there however transparent it is
    """

    ops: tuple[Op, ...]
    closures: tuple[Closure, ...]
    emission: Value | None = None
    transparent: Value | None = None
    shown: Value | None = None
    holdout: Value | None = None
    displaced: Ref | None = None
    corrects_bumps: bool = True
    throws_whole_shadow: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WorldProgram:
    """A world's radiance by direction.

    value: a colour of the program, which has no closures; strength: float32 (3,), its factor
    """

    program: Program
    value: Value
    strength: np.ndarray


class Displacement(NamedTuple):
    """What a material moves vertices by (core/fine_meshes/displacement.py).

    value: of the program, a vector, metres in world space
    keeps_normals: whether normals stay as they were, for the material's bump turns them besides:
        Cycles' Displacement and Bump
    """

    program: Program
    value: Value
    keeps_normals: bool


class AtRest(NamedTuple):
    """A scene before materials have moved its vertices.

    mesh: a TriangleMesh of the same triangles; corner_normals: those that bumps begin with
    objects: bool, one an object, whether any of its vertices has moved; smooth: bool, one a
        triangle, whether it is of these and shaded smooth
    """

    mesh: object
    objects: np.ndarray
    smooth: np.ndarray


class ImageTiles(NamedTuple):
    """An image, or the tiles of one.

    tiles: (column, row) of the tile -> float32 or uint8 (h, w, 4), scene-linear or sRGB, row 0 at
        the bottom; an image without tiles is tile (0, 0)
    encoded: whether to decode sRGB after interpolation
    """

    tiles: Mapping[tuple[int, int], np.ndarray]
    encoded: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurfaceData:
    """What programs ask of the scene's surfaces beside their shape.

    row: int32 (m,), for each triangle of the scene its row in the tables; -1 = it has none
    tables: name -> float32 (rows, 3, width), values at the corners; instances share rows
    object_tables: name -> float32 (n, 4), a value for each object
    object_to_world: float64 (n, 4, 4); mirrored: bool (n,), the winding was turned round
    color: float32 (n, 4); random, pass_index: float32 (n,), as the Object Info node gives them
    """

    row: np.ndarray
    tables: Mapping[str, np.ndarray] = field(default_factory=dict)
    object_tables: Mapping[str, np.ndarray] = field(default_factory=dict)
    object_to_world: np.ndarray
    mirrored: np.ndarray
    color: np.ndarray
    random: np.ndarray
    pass_index: np.ndarray


class Aov(NamedTuple):
    """What nodes of materials, and of the world, write into a pass.

    layer: its name in the film; channels: 4, a colour and 1, or 1, a number
    programs: one a material, of which the closures are not asked; None: it writes nothing
    values: of the programs, one a material
    world: what camera rays write that see it; its strength is not asked
    """

    layer: str
    channels: int
    programs: tuple[Program | None, ...]
    values: tuple[Value | None, ...]
    world: WorldProgram | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shaders:
    """The programs of a scene.

    programs: one a material; None where MaterialParams' row says all
    material_pass_index: float32, one a material
    aovs: what materials write into passes that are asked for
    one_more: whether a ray of the camera goes through one surface more than a shadow ray may, as in
        Cycles of Blender 4
    near_distance: metres that nodes look around for what is near, which do not say how far
    near: near_rays.NearRays, which a render puts here for them; None: nothing is near
    rest: what there was before vertices were displaced; None: none was
    """

    programs: tuple[Program | None, ...]
    surface: SurfaceData
    material_pass_index: np.ndarray
    aovs: tuple[Aov, ...] = ()
    one_more: bool = False
    near_distance: float = 10.0
    near: object | None = None
    rest: AtRest | None = None

    def passes_of_camera(self, most: int) -> int:
        """How many surfaces a ray of the camera goes through; most: transparent_max_bounces."""
        return most + 1 if self.one_more else max(most, 1)

    @property
    def scatters(self) -> bool:
        """Whether light leaves any surface elsewhere than it came in."""
        return any(closure.subsurface is not None for closure in self._closures())

    @property
    def has_films(self) -> bool:
        """Whether any closure has a thin film."""
        return any(closure.film is not None for closure in self._closures())

    def has_model(self, *models: int) -> bool:
        """Whether any closure has one of these models."""
        return any(closure.model in models for closure in self._closures())

    def _closures(self):
        return (c for program in self.programs if program is not None for c in program.closures)
