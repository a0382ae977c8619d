"""What is rendered: arrays that outlive Blender's data. No methods but the checks at the door.

World space is Blender's: right-handed, z up, metres. Colours are linear Rec.709.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .data.asked_passes import NO_PASSES, AskedPasses
from .data.bake_points import BakePoints
from .data.copies import Copies
from .data.lamps import NO_LAMPS, LampLink, Lamps
from .data.object_motion import ObjectMotion, PixelMotion, Pose
from .data.program import Shaders, WorldProgram

EQUIRECTANGULAR, MIRROR_BALL = "EQUIRECTANGULAR", "MIRROR_BALL"
LINEAR, CLOSEST, LINEAR_SRGB = "LINEAR", "CLOSEST", "LINEAR_SRGB"
PERSPECTIVE, ORTHOGRAPHIC, PANORAMIC = "PERSPECTIVE", "ORTHOGRAPHIC", "PANORAMIC"

# Kinds of Panorama -> their parameters. Angles in radians; lens and sensor in millimetres.
PANORAMAS = {
    "EQUIRECTANGULAR": ("longitude_min", "longitude_max", "latitude_min", "latitude_max"),
    "EQUIANGULAR_CUBEMAP_FACE": (),
    "MIRRORBALL": (),
    "FISHEYE_EQUIDISTANT": ("fov",),
    "FISHEYE_EQUISOLID": ("fov", "sensor_width", "sensor_height", "lens"),
    "FISHEYE_LENS_POLYNOMIAL": (
        *("fov", "sensor_width", "sensor_height"),
        *("k0", "k1", "k2", "k3", "k4"),
    ),
    "CENTRAL_CYLINDRICAL": ("u_min", "u_max", "v_min", "v_max", "axis"),
}

# MaterialParams.model
DIFFUSE, PRINCIPLED, GLOSSY, BLACK, MEASURED = 0, 1, 2, 3, 4
TRANSLUCENT, SHEEN, VELVET_SHEEN, TOON, GLOSSY_TOON = 5, 6, 7, 8, 9  # Closure.model: of DIFFUSE
# Bits of Scene.object_flags
CAMERA_RAYS, SHADOW_RAYS, HOLDOUT, SHADOW_CATCHER = 1, 2, 4, 8
# Scene.terminator_offset of what is as round as its normals: all shadow rays start on that surface.
ROUND = 1e6
# MaterialParams.distribution; ASHIKHMIN_SHIRLEY: of Closure alone, of GLOSSY
GGX, MULTI_GGX, BECKMANN, ASHIKHMIN_SHIRLEY = 0, 1, 2, 3


class MaterialParams(NamedTuple):
    """The parameters of a reflecting point, one row a material, or one row a shading point.

    model: int8 (n,), DIFFUSE, PRINCIPLED, GLOSSY, BLACK (emission only) or MEASURED
    distribution: int8 (n,), GGX, MULTI_GGX or BECKMANN; of MEASURED: its row of Scene.measured
    base_color: float32 (n, 3), of MEASURED a tint
    metallic, roughness, ior, specular_level: float32 (n,)
    specular_tint: float32 (n, 3); emission: float32 (n, 3), radiance (strength included)
    diffuse_roughness: float32 (n,), 0: Lambert's (rough_diffuse.py)
    """

    model: np.ndarray
    distribution: np.ndarray
    base_color: np.ndarray
    metallic: np.ndarray
    roughness: np.ndarray
    ior: np.ndarray
    specular_level: np.ndarray
    specular_tint: np.ndarray
    emission: np.ndarray
    diffuse_roughness: np.ndarray


class MeasuredBrdfs(NamedTuple):
    """Measured BRDFs, one row each (measured.py makes them).

    values: float32 (m, 90, 90, 180, 3), sr^-1, see merl.py
    fit: float32 (m, FIT_ANGLES, FIT_COLUMNS), what each reflects seen from evenly spaced cosines,
        0 to 1: columns of measured.py
    keys: sha256 of each one's file
    """

    values: np.ndarray
    fit: np.ndarray
    keys: tuple[str, ...]


# Columns of MeasuredBrdfs.fit: albedo (r, g, b), the Lambert lobe under it (r, g, b), weight and
# width of the GGX lobe over that one.
FIT_ALBEDO, FIT_DIFFUSE, FIT_WEIGHT, FIT_ALPHA, FIT_COLUMNS = 0, 3, 6, 7, 8
FIT_ANGLES = 25
MOST_MEASURED = 127  # rows of an int8
_NO_SIZES = (0, 90, 90, 180, 3), (0, FIT_ANGLES, FIT_COLUMNS)
NO_MEASURED = MeasuredBrdfs(*(np.zeros(size, np.float32) for size in _NO_SIZES), ())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TriangleMesh:
    """All triangles of the scene, in world space, in one table.

    vertices: float32 (n, 3); triangles: int32 (m, 3), indices into vertices
    corner_normals: float32 (m, 3, 3), shading normals at the three corners (a flat face has its
        geometric normal three times), on the side that the winding points to; of unit length, but
        for instances under a scale that is not uniform: normalise what is interpolated
    material_index: int32 (m,), row of Scene.materials; object_index: int32 (m,), row of the objects
    """

    vertices: np.ndarray
    triangles: np.ndarray
    corner_normals: np.ndarray
    material_index: np.ndarray
    object_index: np.ndarray

    def __post_init__(self):
        m = len(self.triangles)
        _expect("vertices", self.vertices, np.float32, (len(self.vertices), 3))
        _expect("triangles", self.triangles, np.int32, (m, 3))
        _expect("corner_normals", self.corner_normals, np.float32, (m, 3, 3))
        _expect("material_index", self.material_index, np.int32, (m,))
        _expect("object_index", self.object_index, np.int32, (m,))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EnvironmentMap:
    """Light at infinity: an image, how a direction finds its texel, and a factor.

    radiance: float32 (h, w, 3), finite; row 0 is the bottom row (looks along -z). Negative light
        takes away, as in Cycles: filters leave it round the sun of many an HDRI
    world_to_map: float32 (3, 4); a world direction d is looked up at world_to_map @ (d, 1),
        normalised: Cycles' Mapping node
    projection: EQUIRECTANGULAR or MIRROR_BALL
    interpolation: LINEAR, CLOSEST, or LINEAR_SRGB: between sRGB-encoded texels, then decoded, which
        is what Cycles does with byte images
    strength: float, or per channel float32 (3,), multiplies radiance
    visible_to_camera: whether a camera ray that hits nothing shows it
    name: of the image, for messages
    """

    radiance: np.ndarray
    world_to_map: np.ndarray = field(default_factory=lambda: np.eye(3, 4, dtype=np.float32))
    projection: str = EQUIRECTANGULAR
    interpolation: str = LINEAR
    strength: np.ndarray = field(default_factory=lambda: np.ones(3, np.float32))
    visible_to_camera: bool = True
    name: str = "world"

    def __post_init__(self):
        if self.radiance.ndim != 3 or self.radiance.shape[2] != 3 or 0 in self.radiance.shape:
            raise ValueError(f"radiance must be (h, w, 3), got {self.radiance.shape}")
        _expect("radiance", self.radiance, np.float32, self.radiance.shape)
        _expect("world_to_map", self.world_to_map, np.float32, (3, 4))
        _expect("strength", self.strength, np.float32, (3,))
        low, high = self.radiance.min(), self.radiance.max()  # NaN goes through both
        if not (low > -np.inf and high < np.inf):
            raise ValueError(f"world {self.name}: radiance must be finite")


class Panorama(NamedTuple):
    """How a panoramic camera's unit square becomes directions (panorama.py).

    kind: of PANORAMAS; parameters: in the order that it names
    """

    kind: str
    parameters: tuple[float, ...]


class Lens(NamedTuple):
    """An aperture that blurs what is not in focus.

    radius: metres; focus: metres to what is sharp, along -z (PANORAMIC: along the ray)
    blades: corners of the aperture, a disc below 3; rotation: radians; ratio: its height / width
    """

    radius: float
    focus: float
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0


class CameraMotion(NamedTuple):
    """What a camera does while the shutter is open, at evenly spaced times from first to last.

    matrices: float64 (k, 4, 4), as Camera.camera_to_world; windows: float64 (k, 4), as its window
    times: float64 (m,), ascending, 0 to 1: evenly spaced parts of the light have come in by then
    """

    matrices: np.ndarray
    windows: np.ndarray
    times: np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """Where rays start, and the part of the frame that is wanted.

    kind: PERSPECTIVE, ORTHOGRAPHIC or PANORAMIC
    camera_to_world: float64 (4, 4), unit axes, askew at times; it looks along its -z, y up
    window: (left, right, bottom, top) of the whole frame: on the plane z = -1 for PERSPECTIVE,
        in metres for ORTHOGRAPHIC; lens shift, sensor fit and pixel aspect are in it. PANORAMIC: of
        the panorama's unit square
    width, height: pixels of the whole frame
    region: (x0, y0, x1, y1), the pixels to render, x1 and y1 not included, y up from the bottom
    clip_start, clip_end: metres along -z, PANORAMIC: along the ray; hits outside are not seen
    panorama: of PANORAMIC; lens: None = all is sharp; motion: None = it stands still
    bake: what its rays end at instead, the frame is an image; None: it is a camera
    """

    kind: str
    camera_to_world: np.ndarray
    window: tuple[float, float, float, float]
    width: int
    height: int
    region: tuple[int, int, int, int]
    clip_start: float
    clip_end: float
    panorama: Panorama | None = None
    lens: Lens | None = None
    motion: CameraMotion | None = None
    bake: BakePoints | None = None

    def __post_init__(self):
        x0, y0, x1, y1 = self.region
        if self.kind not in (PERSPECTIVE, ORTHOGRAPHIC, PANORAMIC):
            raise ValueError(f"camera kind {self.kind!r} is unknown")
        if (self.kind == PANORAMIC) != (self.panorama is not None):
            raise ValueError("a panorama belongs to a camera of kind PANORAMIC, and only to it")
        if self.panorama is not None:
            names = PANORAMAS.get(self.panorama.kind)
            if names is None or len(names) != len(self.panorama.parameters):
                raise ValueError(f"panorama {self.panorama} is none of {PANORAMAS}")
        if not (0 <= x0 < x1 <= self.width and 0 <= y0 < y1 <= self.height):
            raise ValueError(
                f"camera region {self.region} is not inside {self.width}x{self.height}"
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """All that one picture needs.

    material_pass_index, object_pass_index: float32 (n,), values of the index passes
    terminator_offset: float32 (n_objects,), Blender's shadow terminator geometry offset: shadow
        rays of a smaller cosine start above coarse smooth faces; ROUND: all do; None = 0 for all
    object_flags: uint8 (n_objects,), CAMERA_RAYS | SHADOW_RAYS: which rays see an object; HOLDOUT |
        SHADOW_CATCHER: what the camera sees of it; None = plain objects that all rays see
    shaders: materials that vary over the surface; None: materials says all
    backdrop: what camera rays that hit nothing see in place of environment; None = the same
    transparent_film: alpha 0 where the camera sees the world; exposure: factor of the film
    asked: passes made on request; measured: the BRDFs that materials of model MEASURED name
    lamps: what lights the scene beside its environment; lamp_links: which objects these are about
    motion: of objects while the shutter is open; pose: the slice of it that a copy of the scene
        stands for, made by time_slices.py; pixel_motion: for the Vector pass, None = not asked
    object_to_world: float64 (n_objects, 4, 4), where the mesh table has objects; None = not told
    copies: objects that show what others of the mesh table do, elsewhere
    """

    mesh: TriangleMesh
    materials: MaterialParams
    environment: EnvironmentMap
    camera: Camera
    material_pass_index: np.ndarray
    object_pass_index: np.ndarray
    terminator_offset: np.ndarray | None = None
    object_flags: np.ndarray | None = None
    shaders: Shaders | None = None
    backdrop: EnvironmentMap | WorldProgram | None = None
    transparent_film: bool = False
    exposure: float = 1.0
    asked: AskedPasses = NO_PASSES
    measured: MeasuredBrdfs = NO_MEASURED
    lamps: Lamps = NO_LAMPS
    lamp_links: tuple[LampLink, ...] = ()
    motion: ObjectMotion | None = None
    pose: Pose | None = None
    pixel_motion: PixelMotion | None = None
    object_to_world: np.ndarray | None = None
    copies: Copies | None = None

    def __post_init__(self):
        if self.pose is not None:  # a copy of what has been checked
            return
        rows = self.materials.distribution[self.materials.model == MEASURED]
        if len(rows) and not 0 <= rows.min() <= rows.max() < len(self.measured.values):
            raise ValueError("a material names a measured BRDF that is not there")
        mesh = self.mesh
        for name, own, n in (
            ("a vertex", mesh.triangles, len(mesh.vertices)),
            ("a material", mesh.material_index, len(self.materials.model)),
            ("an object", mesh.object_index, len(self.object_pass_index)),
        ):
            if len(own) and not 0 <= own.min() <= own.max() < n:
                raise ValueError(f"a triangle names {name} that is not there")


def _expect(name, array, dtype, shape):
    if array.dtype != dtype or array.shape != shape or not array.flags.c_contiguous:
        raise ValueError(
            f"{name} must be C-contiguous {np.dtype(dtype).name} {shape}, "
            f"got {array.dtype} {array.shape}"
        )
