# SPDX-License-Identifier: Apache-2.0
"""The options of a renderer. Names, defaults and ranges are those of the C++ interface (gnomon/renderer.h, ranges.h)."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Optional, Union

from ._parts import Size, Vec3


@dataclass(slots=True)
class ReferenceLightOptions:
    """Path-traced indirect light: slow, unbiased, and with an estimate of its error."""

    spp: int = 1024
    """Paths per pixel, 1 to 16,777,216."""
    bounces: Union[int, Literal["all"]] = "all"
    """Diffuse bounces, 0 to 1,000; 1: direct light and one bounce."""
    seed: int = 0


@dataclass(slots=True)
class RenderOptions:
    """How frames are rendered."""

    size: Size = (0, 0)
    """Width and height in pixels, 1 to 32,768 each; (0, 0): the camera's own resolution, else 1280 x 720."""
    camera: Union[str, int] = "auto"
    """A name, a number from 0, or 'auto': the first."""
    turntable_seconds: float = 0.0
    """Seconds in which the camera circles the scene; 0: off."""
    renderer: Literal["trace", "raster"] = "trace"
    """Ray tracing on the CPU, or the rasteriser on a Vulkan device."""
    max_depth: int = 10
    """Longest chain of reflections and refractions, 0 to 64."""
    samples: Union[int, Literal["auto"]] = 1
    """Per pixel, 1 to 4,096; 'auto': one, and more where something ends within a pixel."""
    filter: Literal["auto", "box", "gaussian", "blackman-harris"] = "auto"
    """How samples make a pixel."""
    shutter: float = 0.0
    """Motion blur: degrees by which a rotating shutter is open, 0 to 360."""
    f_number: float = 0.0
    """Depth of field: focal length divided by the lens's diameter, on a sensor 24 mm high; 0: off."""
    aperture: float = 0.0
    """Depth of field: diameter of the lens in millimetres; 0: off. Not with `f_number`."""
    focus: Optional[float] = None
    """Distance of what is sharp in metres; None: of what the middle of the image shows."""
    exposure: Optional[float] = None
    """Stops, -100 to 100; None: automatic, from each frame by itself."""
    tonemap: Literal["none", "neutral", "agx", "aces"] = "neutral"
    background: Literal["environment", "transparent", "color"] = "environment"
    background_color: Vec3 = (0.0, 0.0, 0.0)
    """Of 'color', as shown: sRGB, 0 to 1."""
    shadow_culling: Literal["off", "paper", "certified"] = "certified"
    indirect: Literal["off", "rsm", "quadtree", "visible"] = "visible"
    """Indirect light; 'visible' accounts for occluders, and has no noise."""
    shadow_textures: Literal["off", "per-caster", "depth", "coherent", "items"] = "items"
    """Of the rasteriser."""
    sun_size: float = 0.0
    """Angular diameter of directional lights in degrees, 0 to 45; the sun's is 0.53."""
    shadow_filter: int = 1
    """Of the rasteriser: width of shadow edges in texels, 0 to 64."""
    as_printed: bool = False
    """The published techniques by the letter of their papers."""
    bounces: Union[int, Literal["all"]] = "all"
    """Diffuse bounces of indirect='visible', 1 to 1,000."""
    reference: Optional[ReferenceLightOptions] = None
    """Path-traced indirect light, instead of `indirect`."""
    rsm_samples: int = 256
    """Of indirect='rsm': 1 to 65,536."""
    indirect_level: int = 5
    """Of indirect='quadtree': finest level of refinement, 7 (coarse) to 1."""
    depth_threshold: float = 0.05
    """Of indirect='quadtree': fraction of the light view's depth range, 0 to 1."""
    normal_threshold: float = 0.9
    """Of indirect='quadtree': cosine, -1 to 1."""
    validity_margin: float = 0.0
    """Of indirect='quadtree': fraction of the thresholds, 0 to 1."""
    separate_trees: bool = False
    """Of indirect='quadtree': static and dynamic objects have light trees of their own."""
    cluster_shadows: bool = False
    """Of indirect='quadtree': clusters are occluded."""
    indirect_at_every_pixel: bool = False
    """Of indirect='rsm' and 'quadtree'."""
    indirect_memory: int = 16
    """MB of irradiance cache, 1 to 65,536; changes time, not images."""
    indirect_on: Literal["auto", "cpu", "vulkan"] = "auto"
    """Of the rasteriser."""
    accelerator: Literal["embree", "kdtree"] = "embree"
    arithmetic: Literal["portable", "native"] = "portable"
    """'portable': the same bytes on every processor."""
    threads: int = 0
    """0 to 1,024; 0: all. Images do not depend on it."""
    memory: int = 0
    """MB that the renderer may hold; 0: no limit. Beyond it, render() raises MissingError."""
    layers: bool = False
    """Frames have the layers depth, normal, albedo, direct, indirect and shadow."""
    ids: bool = False
    """Frames have object_ids and material_ids."""
    motion: bool = False
    """Frames have the layer motion."""
    report_changes: bool = False
    """Renderer.report() lists rectangles of pixels that changed."""
    overlay: Literal["none", "shadow-states", "redrawn", "clusters"] = "none"
    overlay_light: Optional[int] = None
    """Number of a light, from 0; None: all, one panel each."""
    interactive: bool = False
    """Prepare for a window: results for later frames are proven by improve() alone. Cannot be changed later."""
    keep_image: bool = True
    """Where nothing has changed since the last traced frame, give its layers again and trace nothing."""
