"""What a user sets: `scene.iwis`, `view_layer.iwis`. core.settings gives defaults and limits."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from ..core.settings import CHOICES, LIMITS, RenderSettings
from .bake_kinds import KINDS
from .denoise_properties import choice, switch
from .viewport_properties import IWISViewportProperties

_DEFAULTS = RenderSettings()

# A field of RenderSettings that is no property of the scene, and where it is set instead.
NOT_ON_SCENE = {"cache_dir": "the add-on's preferences: a folder belongs to a machine, not a file"}

_CHOICE_TEXTS = {
    "UNBIASED": ("Unbiased", "Weight each sample by light, material and density: converges"),
    "PAPER": ("Paper", "As printed in the paper"),
    "PERCEPTUAL": ("Perceptual", "Samples go where they lower the visible error most"),
    "FIXED": ("Fixed", "Every pixel takes Max Samples"),
    "BUDGET": ("Budget", "As Perceptual, until a mean count or a time is used up"),
    "CENTER": ("Center", "One shading point, at the pixel's center: no anti-aliasing"),
    "BOX": ("Box", "Box filter, one pixel wide"),
    "GAUSSIAN": ("Gaussian", "Gaussian filter, as Cycles'"),
    "BLACKMAN_HARRIS": ("Blackman-Harris", "Blackman-Harris filter, as Cycles has it by default"),
    "OWEN": ("Scrambled", "Each pixel scrambles the points anew: the least noise"),
    "PIXEL": ("Shifted", "Each pixel shifts the paper's points"),
    "NONE": ("None", "The same points in every pixel, as printed in the paper"),
}
_TEXTS_OF_SETTING = {
    ("estimator", "PAPER"): ("Paper", "Unoccluded light from the tables, times the visible share"),
    ("stop_rule", "PAPER"): ("Error", "A pixel is done when its error is below the threshold"),
}


def _number(field: str, /, **texts) -> dict:
    low, high = LIMITS[field]
    return {"default": getattr(_DEFAULTS, field), "min": low, "max": high, **texts}


def _choice(field: str, /, **texts) -> dict:
    items = [
        (value, *_TEXTS_OF_SETTING.get((field, value), _CHOICE_TEXTS[value]))
        for value in CHOICES[field]
    ]
    return {"default": getattr(_DEFAULTS, field), "items": items, **texts}


def _update_passes(self, _context):
    for view_layer in self.id_data.view_layers:
        view_layer.update_render_passes()


class IWISSceneProperties(bpy.types.PropertyGroup):
    """The fields of RenderSettings and DenoiseSettings under the same names, and what only
    Blender's side needs."""

    error_threshold: FloatProperty(
        **_number(
            "error_threshold",
            name="Error Threshold",
            description="The relative noise left where half of the light is hidden",
            soft_max=1.0,
            precision=3,
        )
    )
    max_samples: IntProperty(
        **_number(
            "max_samples",
            name="Max Samples",
            description="The most shadow rays that one pixel may take",
            soft_max=4096,
        )
    )
    target_samples: IntProperty(
        **_number(
            "target_samples",
            name="Target Samples",
            description="The mean count of the pixels that show an object; 0 sets none",
            soft_max=4096,
        )
    )
    time_limit: FloatProperty(
        **_number(
            "time_limit",
            name="Time Limit",
            description="Seconds that sampling may take; 0 sets none",
            unit="TIME_ABSOLUTE",
            soft_max=3600.0,
        )
    )
    batch_size: IntProperty(
        **_number(
            "batch_size",
            name="Batch Size",
            description="Samples that a pixel takes between two looks at its error",
            soft_max=64,
        )
    )
    estimator: EnumProperty(
        **_choice("estimator", name="Estimator", description="How samples become a color")
    )
    stop_rule: EnumProperty(
        **_choice("stop_rule", name="Stop Rule", description="When a pixel has enough samples")
    )
    coefficients: FloatProperty(
        **_number(
            "coefficients",
            name="Coefficients",
            description="Fraction of the wavelet coefficients that the tables keep",
            soft_max=0.2,
            precision=3,
        )
    )
    pixel_filter: EnumProperty(
        **_choice("pixel_filter", name="Filter Type", description="Pixel filter type")
    )
    filter_width: FloatProperty(
        **_number(
            "filter_width",
            name="Filter Width",
            description="Pixel filter width",
            subtype="PIXEL",
        )
    )
    transparent_max_bounces: IntProperty(
        **_number(
            "transparent_max_bounces",
            name="Transparent Max Bounces",
            description="Transparent surfaces that a ray may go through; behind them it is black",
        )
    )
    decorrelation: EnumProperty(
        **_choice(
            "decorrelation",
            name="Decorrelation",
            description="How the points of neighboring pixels differ",
        )
    )
    seed: IntProperty(**_number("seed", name="Seed", description="Another seed, other noise"))
    use_animated_seed: BoolProperty(
        name="Animate Seed",
        description="Use another seed for every frame",
        default=False,
    )
    threads: IntProperty(
        **_number(
            "threads",
            name="Threads",
            description="Worker threads; 0 follows Blender's own setting and its -t option",
            soft_max=64,
        )
    )
    tile_px: IntProperty(
        **_number(
            "tile_px",
            name="Tile Size",
            description="Side of a tile in pixels at the most; the picture does not depend on it",
            subtype="PIXEL",
        )
    )
    keep_film: BoolProperty(
        name="Keep Film",
        description="Keep every layer of the last render in memory, so that it can be saved",
        default=False,
        options=set(),
    )
    bake_type: EnumProperty(
        name="Bake Type",
        description="What the panel's button bakes into the active image of each material",
        items=KINDS,
        default="COMBINED",
        options=set(),
    )
    denoise: BoolProperty(
        **switch(
            description="Take the noise out of the finished picture with Open Image Denoise",
            update=_update_passes,
        )
    )
    denoise_passes: EnumProperty(**choice("denoise_passes"))
    denoise_prefilter: EnumProperty(**choice("denoise_prefilter"))
    denoise_quality: EnumProperty(**choice("denoise_quality"))
    viewport: PointerProperty(type=IWISViewportProperties)


class IWISViewLayerProperties(bpy.types.PropertyGroup):
    """Which of IWIS' own passes a view layer has, and whether it is denoised."""

    use_pass_samples: BoolProperty(
        name="Samples",
        description="Shadow rays that each pixel took",
        default=True,
        update=_update_passes,
    )
    use_pass_error: BoolProperty(
        name="Error",
        description="Estimated visible error with which each pixel stopped",
        default=False,
        update=_update_passes,
    )
    use_pass_unoccluded: BoolProperty(
        name="Unoccluded",
        description="Light of each pixel if nothing cast a shadow",
        default=False,
        update=_update_passes,
    )
    use_pass_visibility: BoolProperty(
        name="Visibility",
        description="Share of the shadow rays that reached the light",
        default=False,
        update=_update_passes,
    )
    use_pass_shadow_catcher: BoolProperty(
        name="Shadow Catcher",
        description="Part of the light on shadow catchers that other objects let through; "
        "the picture then has a hole in their place",
        default=False,
        update=_update_passes,
    )
    use_pass_sample_count: BoolProperty(
        name="Sample Count",
        description="Samples of each pixel divided by Max Samples, as Cycles writes it",
        default=False,
        update=_update_passes,
    )
    use_pass_denoising_data: BoolProperty(
        name="Denoising Data",
        description="Albedo, normal and depth, for a denoiser after the render",
        default=False,
        update=_update_passes,
    )
    use_denoising: BoolProperty(
        name="Denoising",
        description="Denoise this view layer, where the scene is denoised",
        default=True,
        update=_update_passes,
    )


CLASSES = (IWISViewportProperties, IWISSceneProperties, IWISViewLayerProperties)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.iwis = PointerProperty(type=IWISSceneProperties)
    bpy.types.ViewLayer.iwis = PointerProperty(type=IWISViewLayerProperties)


def unregister() -> None:
    del bpy.types.ViewLayer.iwis
    del bpy.types.Scene.iwis
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
