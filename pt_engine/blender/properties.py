"""The engine's own properties, on every scene as `scene.pt_engine`."""

from __future__ import annotations

import zlib

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..core.samplers import SAMPLERS
from ..render import integrators  # noqa: F401  fills the registry
from ..render.integrator import INTEGRATORS

DEFAULT_INTEGRATOR = "path"
_items: list[tuple] = []  # Blender does not keep the strings of a dynamic enum: this does


def integrator_items(self, context):
    """The registry as an enum. A .blend stores an item's number, so numbers are made from names."""
    _items[:] = [
        (name, cls.label or name, cls.description, "", integrator_number(name))
        for name, cls in INTEGRATORS.items()
    ]
    return _items


def integrator_number(name: str) -> int:
    """0 for the default, else one that depends on the name alone."""
    return 0 if name == DEFAULT_INTEGRATOR else zlib.crc32(name.encode()) & 0x7FFFFFFF


SAMPLER_TEXTS = {
    "sobol": ("Sobol", "Owen-scrambled Sobol points: less noise for the same number of samples"),
    "independent": ("Independent", "Independent random numbers: the plain Monte Carlo method"),
}
# not in the class: before Python 3.12 a comprehension in an annotation does not see this module
SAMPLER_ITEMS = [(name, *SAMPLER_TEXTS.get(name.lower(), (name.title(), ""))) for name in SAMPLERS]


def target_percent(self) -> float:
    """The target error as a panel shows it."""
    return 100 * self.target_error


def set_target_percent(self, percent: float) -> None:
    """What somebody has typed into the panel."""
    self.target_error = percent / 100


class PTEngineSettings(bpy.types.PropertyGroup):
    """Settings of PT Engine; each is also a key of the command line's --set."""

    integrator: EnumProperty(
        name="Integrator",
        description="How light transport is estimated",
        items=integrator_items,
    )
    samples: IntProperty(
        name="Samples",
        description="Samples for each pixel; 0 for no limit (then give a time limit, or stop it yourself)",
        default=64,
        min=0,
        soft_max=4096,
    )
    seconds: FloatProperty(
        name="Time Limit",
        description="Seconds after which rendering ends, whatever the samples; 0 for no limit",
        default=0.0,
        min=0.0,
        unit="TIME_ABSOLUTE",
    )
    target_error: FloatProperty(
        name="Target Error",
        description="Relative error at which rendering ends: 0.01 is 1 %; 0 for none. "
        "Samples and time limit still hold",
        default=0.0,
        min=0.0,
        soft_max=0.5,
        max=10.0,
        precision=4,
    )
    target_percent: FloatProperty(  # not stored: files and --set keep the number itself
        name="Target Error",
        description="Relative error at which rendering ends; 0 for none. Samples and time limit still hold",
        subtype="PERCENTAGE",
        min=0.0,
        soft_max=50.0,
        max=1000.0,
        precision=2,
        get=target_percent,
        set=set_target_percent,
        options={"SKIP_SAVE"},
    )
    target_of: EnumProperty(
        name="Target For",
        description="Whose error it is",
        items=[
            ("IMAGE", "Image", "Root of the image's mean squared relative error"),
            ("PIXELS", "Pixels", "The standard error of most pixels: a noise threshold"),
        ],
        default="IMAGE",
    )
    target_percentile: FloatProperty(
        name="Pixels Below",
        description="Percentage of pixels whose relative error has to be below the target",
        default=95.0,
        min=1.0,
        max=100.0,
        subtype="PERCENTAGE",
    )
    min_samples: IntProperty(
        name="Min Samples",
        description="Samples for each pixel before the error decides anything",
        default=16,
        min=4,
        soft_max=256,
    )
    adaptive: BoolProperty(
        name="Adaptive",
        description="Pixels whose surroundings have little noise stop early; Samples is the most one gets",
        default=False,
    )
    seed: IntProperty(
        name="Seed",
        description="Another seed gives other noise; the same seed gives the same image, bit for bit",
        default=0,
        min=0,
    )
    sampler: EnumProperty(
        name="Sampler",
        description="Where the random numbers come from",
        items=SAMPLER_ITEMS,
        default=next(iter(SAMPLERS)),
    )
    max_depth: IntProperty(
        name="Max Depth",
        description="Longest light path, in edges: 1 shows emitters only, 2 adds direct light, "
        "each further one a bounce",
        default=14,
        min=1,
        soft_max=64,
        max=1024,
    )
    rr_depth: IntProperty(
        name="Roulette Depth",
        description="From this depth on, dim paths end by Russian roulette: faster, and without bias",
        default=4,
        min=1,
        soft_max=64,
        max=1024,
    )
    transparent_depth: IntProperty(
        name="Transparent Depth",
        description="How many transparent surfaces a path or a shadow ray passes at most; "
        "they are no bounces",
        default=8,
        min=0,
        max=1024,
    )
    clamp_direct: FloatProperty(
        name="Clamp Direct",
        description="What a sample may bring at most of light after one bounce; 0 for all. "
        "It takes fireflies and the energy in them: the image is biased",
        default=0.0,
        min=0.0,
    )
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description="What a sample may bring at most of light after several bounces; 0 for all "
        "(Cycles' default is 10). It takes fireflies and the energy in them: the image is biased",
        default=0.0,
        min=0.0,
    )
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="How much each point around a pixel counts in it",
        items=[
            ("FILE", "From the File", "Type and width as set for Cycles, else Blackman-Harris"),
            ("BLACKMAN_HARRIS", "Blackman-Harris", "Smooth, hardly any ringing"),
            ("GAUSSIAN", "Gaussian", "A bell curve"),
            ("BOX", "Box", "The pixel's own square"),
        ],
        default="FILE",
    )
    filter_width: FloatProperty(
        name="Filter Width",
        description="Width of the pixel filter in pixels (a box is always one pixel wide)",
        default=1.5,
        min=0.01,
        max=10.0,
        subtype="PIXEL",
    )
    texture_memory: IntProperty(
        name="Texture Memory",
        description="Megabytes that image textures may take; 0 for no limit. Images that do not fit are kept "
        "in a scratch file and read tile by tile: the same picture, made more slowly",
        default=0,
        min=0,
        soft_max=65536,
        max=1048576,
    )
    memory_limit: IntProperty(
        name="Memory Limit",
        description="Megabytes that a render may take beside Blender itself; 0 for what is free. "
        "Instances that would not fit are rendered without being placed, which is slower; what does not fit "
        "even so is refused before it starts",
        default=0,
        min=0,
        soft_max=1048576,
        max=16777216,
    )
    strict: BoolProperty(
        name="Strict",
        description="Refuse to render a scene with anything that is not rendered exactly, and list it",
        default=False,
    )
    stats_path: StringProperty(
        name="Statistics File",
        description="Write the render's statistics to this file, as JSON; #### stands for the frame",
        subtype="FILE_PATH",
    )
    python_files: StringProperty(
        name="Integrator Files",
        description="Python files with integrators of your own, separated by semicolons. "
        "They are run only when you press Load, never because a .blend says so",
    )


class PTEngineLayerSettings(bpy.types.PropertyGroup):
    """Passes of a view layer that only PT Engine has; off, they cost nothing."""

    use_pass_standard_error: BoolProperty(
        name="Standard Error",
        description="How uncertain each pixel still is: the standard deviation of its mean, per channel",
        default=False,
    )
    use_pass_sample_count: BoolProperty(
        name="Sample Count",
        description="How many samples each pixel got",
        default=False,
    )
    use_pass_halves: BoolProperty(
        name="Half Buffers",
        description="The image from even samples (Half A) and from odd ones (Half B): two independent "
        "renders, as denoisers and comparisons want them",
        default=False,
    )


def register() -> None:
    bpy.utils.register_class(PTEngineSettings)
    bpy.utils.register_class(PTEngineLayerSettings)
    bpy.types.ViewLayer.pt_engine = PointerProperty(type=PTEngineLayerSettings)
    bpy.types.Scene.pt_engine = PointerProperty(type=PTEngineSettings)


def unregister() -> None:
    del bpy.types.Scene.pt_engine
    del bpy.types.ViewLayer.pt_engine
    bpy.utils.unregister_class(PTEngineLayerSettings)
    bpy.utils.unregister_class(PTEngineSettings)
