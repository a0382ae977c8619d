"""A measured BRDF on a material: `material.iwis`, and its panel in the material tab."""

from __future__ import annotations

import threading
from typing import ClassVar

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatVectorProperty, PointerProperty, StringProperty

from .export.shaders.measured import file_of, read_file
from .job import ENGINE

# Preview: side in pixels; columns are outgoing cosines, 1 at the left.
PREVIEW_PX = 64
_ANGLES = (0, 45, 75)
_POLL_SECONDS = 0.2


def _changed(self, _context):
    """Tell Blender, which would not copy a script's change to what is rendered in the viewport."""
    self.id_data.update_tag()


class IWISMaterialProperties(bpy.types.PropertyGroup):
    """What stands in place of the material's nodes."""

    use_measured: BoolProperty(
        name="IWIS Measured BRDF",
        description="Render a measured BRDF in place of the node tree, in IWIS",
        default=False,
        update=_changed,
    )
    measured_path: StringProperty(
        name="File",
        description="A BRDF in MERL's format: 90 x 90 x 180 samples, .binary",
        subtype="FILE_PATH",
        options={"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        update=_changed,
    )
    measured_tint: FloatVectorProperty(
        name="Tint",
        description="Factor of the measured reflectance",
        subtype="COLOR",
        default=(1.0, 1.0, 1.0),
        min=0.0,
        soft_max=1.0,
        update=_changed,
    )


class _Reader:
    """Reads files in a thread, so that no panel waits: a file's albedo, or what is wrong."""

    def __init__(self):
        self._found: dict[str, np.ndarray | str] = {}
        self._reading: set[str] = set()

    def ask(self, path: str) -> np.ndarray | str | None:
        """float32 (angles, 3), albedo by even cosines, 0 to 1; a text: an error; None: not yet."""
        if path not in self._found and path not in self._reading:
            self._reading.add(path)
            threading.Thread(target=self.read, args=(path,), daemon=True).start()
            if not bpy.app.background:
                bpy.app.timers.register(self._redraw, first_interval=_POLL_SECONDS)
        return self._found.get(path)

    def read(self, path: str) -> np.ndarray | str:
        """The same at once."""
        try:
            found = read_file(path).fit[0, :, :3]
        except (OSError, ValueError) as error:
            found = str(error)
        except ImportError as error:
            found = f"{error}: see the panel Warnings of the render tab"
        self._found[path] = found
        self._reading.discard(path)
        return found

    def forget(self) -> None:
        """Ask again: a file may have changed."""
        self._found.clear()

    def _redraw(self):
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "PROPERTIES":
                    area.tag_redraw()
        return _POLL_SECONDS if self._reading else None


READER = _Reader()
_previews = None


def albedo_at(albedo: np.ndarray, cosine) -> np.ndarray:
    """Between the cosines of READER's table: (..., 3)."""
    x = np.linspace(0.0, 1.0, len(albedo))
    return np.stack([np.interp(cosine, x, albedo[:, c]) for c in range(3)], -1)


def preview_pixels(albedo: np.ndarray, tint) -> np.ndarray:
    """float32 (PREVIEW_PX, PREVIEW_PX, 4), sRGB: what the surface reflects of a white sky.

    Columns: seen head on at the left, to grazing at the right.
    """
    cosines = np.cos(np.linspace(0.0, 0.5 * np.pi, PREVIEW_PX))
    light = np.clip(albedo_at(albedo, cosines) * np.array(tint), 0.0, 1.0)
    light = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    pixels = np.ones((PREVIEW_PX, PREVIEW_PX, 4), np.float32)
    pixels[..., :3] = light
    return pixels


def preview_icon(path: str, albedo: np.ndarray, tint) -> int:
    """The icon that shows preview_pixels()."""
    global _previews
    if _previews is None:
        import bpy.utils.previews

        _previews = bpy.utils.previews.new()
    key = f"{path} {tuple(round(c, 3) for c in tint)}"
    if key not in _previews:
        if len(_previews) > 64:
            _previews.clear()
        preview = _previews.new(key)
        preview.icon_size = preview.image_size = PREVIEW_PX, PREVIEW_PX
        pixels = preview_pixels(albedo, tint).ravel()
        preview.icon_pixels_float = pixels
        preview.image_pixels_float = pixels
    return _previews[key].icon_id


def albedo_lines(albedo: np.ndarray, tint) -> list[str]:
    """What is said of the reflectance: a line an angle."""
    lines = []
    for angle in _ANGLES:
        r, g, b = albedo_at(albedo, np.cos(np.radians(angle))) * np.array(tint)
        lines.append(f"From {angle}\N{DEGREE SIGN}: {r:.3f}, {g:.3f}, {b:.3f}")
    return lines


class IWIS_PT_measured(bpy.types.Panel):
    bl_label = "IWIS Measured BRDF"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES: ClassVar[set[str]] = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES and context.material is not None

    def draw_header(self, context):
        self.layout.prop(context.material.iwis, "use_measured", text="")

    def draw(self, context):
        layout, material = self.layout, context.material
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.active = material.iwis.use_measured
        layout.prop(material.iwis, "measured_path")
        layout.prop(material.iwis, "measured_tint")
        path = file_of(material)
        if not path:
            layout.label(text="Choose a MERL table (.binary)", icon="INFO")
            return
        albedo, tint = READER.ask(path), tuple(material.iwis.measured_tint)
        if albedo is None:
            layout.label(text="Reading...", icon="TIME")
        elif isinstance(albedo, str):
            layout.label(text=albedo, icon="ERROR")
        else:
            row = layout.row()
            row.template_icon(preview_icon(path, albedo, tint), scale=4.0)
            column = row.column()
            column.label(text="Directional albedo")
            for line in albedo_lines(albedo, tint):
                column.label(text=line)


CLASSES = (IWISMaterialProperties, IWIS_PT_measured)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Material.iwis = PointerProperty(type=IWISMaterialProperties)


def unregister() -> None:
    global _previews
    if _previews is not None:
        bpy.utils.previews.remove(_previews)
        _previews = None
    del bpy.types.Material.iwis
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
