# SPDX-License-Identifier: Apache-2.0
"""Materials and lights, and what a scene and a frame tell. The names and defaults are those of the C++ interface.

Colours are linear, with Rec. 709 primaries; lengths are metres, angles radians.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Optional, Union

from ._gnomon import InstanceId, LightId, MaterialId, TextureId

Vec2 = Sequence[float]
"""Two numbers, in a tuple, a list or an array."""
Vec3 = Sequence[float]
"""Three numbers: a point, a direction, or a linear colour."""
Size = tuple[int, int]
"""Width and height in pixels."""


@dataclass(slots=True)
class TextureUse:
    """A texture as a material uses it: coordinates are scaled, rotated, then moved (KHR_texture_transform)."""

    texture: Optional[TextureId] = None
    """None: a constant 1."""
    texcoord: int = 0
    """0: the mesh's `uvs`; 1: its `uvs2`."""
    offset: Vec2 = (0.0, 0.0)
    scale: Vec2 = (1.0, 1.0)
    rotation: float = 0.0
    """Radians, counter-clockwise."""


AnyTexture = Union[TextureUse, TextureId, None]
"""A texture alone stands for its plain use."""


@dataclass(slots=True)
class MaterialLayers:
    """What a metallic-roughness material may have beside its base; the values are those of glTF's extensions
    KHR_materials_specular, clearcoat, sheen, anisotropy, iridescence, transmission, volume and dispersion."""

    specular: float = 1.0
    """0 to 1: scales the dielectric's reflectance."""
    specular_texture: AnyTexture = None
    """In A."""
    specular_color: Vec3 = (1.0, 1.0, 1.0)
    """Scales the reflectance at normal incidence; may exceed 1."""
    specular_color_texture: AnyTexture = None
    clearcoat: float = 0.0
    """0 to 1; a coat of index 1.5."""
    clearcoat_roughness: float = 0.0
    """0 to 1."""
    clearcoat_texture: AnyTexture = None
    """In R."""
    clearcoat_roughness_texture: AnyTexture = None
    """In G."""
    clearcoat_normal_texture: AnyTexture = None
    clearcoat_normal_scale: float = 1.0
    sheen_color: Vec3 = (0.0, 0.0, 0.0)
    """Of fibres, 0 to 1; 0: none."""
    sheen_roughness: float = 0.0
    """0 to 1."""
    sheen_color_texture: AnyTexture = None
    sheen_roughness_texture: AnyTexture = None
    """In A."""
    anisotropy: float = 0.0
    """0 to 1: how much wider highlights are along the grain."""
    anisotropy_rotation: float = 0.0
    """Of the grain from the tangent, radians, counter-clockwise."""
    anisotropy_texture: AnyTexture = None
    """Direction in RG, strength in B."""
    iridescence: float = 0.0
    """0 to 1: of a thin film."""
    iridescence_texture: AnyTexture = None
    """In R."""
    iridescence_ior: float = 1.3
    """Index of refraction of the thin film, 1 or more."""
    iridescence_thickness_least: float = 100.0
    """Nanometres."""
    iridescence_thickness_most: float = 400.0
    """Nanometres."""
    iridescence_thickness_texture: AnyTexture = None
    """In G: from the least to the most; None: the most."""
    transmission_texture: AnyTexture = None
    """In R."""
    thin_walled: bool = False
    """Light passes without refraction, tinted by the base colour."""
    thickness: float = 0.0
    """Of the body, metres; used where refracted rays are not traced."""
    thickness_texture: AnyTexture = None
    """In G."""
    attenuation_color: Vec3 = (1.0, 1.0, 1.0)
    """0 to 1: white light after `attenuation_distance` inside."""
    attenuation_distance: float = 0.0
    """Metres; 0: nothing is absorbed."""
    dispersion: float = 0.0
    """20 divided by the Abbe number."""
    emission_inner: float = 0.0
    """Of the cone around the instance's -Z within which the surface emits, as a spot with the profile "smooth-cosine": radians from the axis, within
    which the light does not fade."""
    emission_outer: float = 0.0
    """Radians from the axis beyond which it emits nothing; 0: it emits in all directions."""


@dataclass(slots=True)
class Material:
    """A surface: glTF 2.0's metallic-roughness model, or the model of Whitted that the scenes of BART have."""

    name: str = ""
    model: Literal["metallic_roughness", "whitted", "unlit"] = "metallic_roughness"
    base_color: Vec3 = (0.8, 0.8, 0.8)
    """0 to 1; of 'whitted', the diffuse colour."""
    base_color_texture: AnyTexture = None
    double_sided: bool = False
    alpha: float = 1.0
    """0 to 1."""
    alpha_mode: Literal["opaque", "mask", "blend"] = "opaque"
    """What alpha means: nothing; where the surface is cut out; how much it covers of what is behind."""
    alpha_cutoff: float = 0.5
    """Of 'mask': the surface is there where alpha reaches it."""
    metallic: float = 0.0
    """0 to 1."""
    roughness: float = 0.8
    """0 to 1."""
    metallic_roughness_texture: AnyTexture = None
    """Roughness in G, metallic in B."""
    normal_texture: AnyTexture = None
    normal_scale: float = 1.0
    occlusion_texture: AnyTexture = None
    """In R; darkens ambient light only."""
    occlusion_strength: float = 1.0
    emissive: Vec3 = (0.0, 0.0, 0.0)
    """Radiance in nits."""
    emissive_texture: AnyTexture = None
    transmission: float = 0.0
    """0 to 1: glass, which refracts by `ior` unless its layers say that it is thin."""
    ior: float = 1.5
    """Index of refraction inside, of both models."""
    ambient: Vec3 = (0.0, 0.0, 0.0)
    """Of 'whitted'."""
    specular: Vec3 = (0.0, 0.0, 0.0)
    """Of 'whitted': of highlights and reflections."""
    shine: float = 0.0
    """Of 'whitted': exponent of highlights; 0: none."""
    transmittance: float = 0.0
    """Of 'whitted': 0 to 1."""
    layers: Optional[MaterialLayers] = None
    outline: bool = False
    """Of an inverted hull, drawn around a body as its outline: it casts no shadow."""
    hidden_from_camera: bool = False
    """Traced frames: cameras see what is behind it; mirrors and light meet it."""


@dataclass(slots=True)
class Light:
    """A light without size, at its node's origin and directed along the node's -Z."""

    name: str = ""
    type: Literal["point", "spot", "directional"] = "point"
    color: Vec3 = (1.0, 1.0, 1.0)
    """Candela (point and spot), lux (directional); with constant falloff, the irradiance itself."""
    falloff: Literal["inverse_square", "constant"] = "inverse_square"
    profile: Literal["smooth", "cosine", "smooth-cosine"] = "smooth"
    """Of a spot: smooth between the inner and the outer angle (glTF), the cosine from the axis, or that cosine with smooth
    steps between the angles (Blender)."""
    inner_angle: float = 0.0
    """Of a spot: radians from the axis."""
    outer_angle: float = 0.7853982
    """Of a spot: radians from the axis."""
    range: float = 0.0
    """Metres beyond which it is dark; 0: unlimited."""


@dataclass(slots=True)
class AreaLight:
    """A light with size: a surface of one radiance, which mirrors see as well, and cameras unless it is hidden from them. A rectangle and a disc lie
    across the node's Z axis."""

    name: str = ""
    shape: Literal["rectangle", "disc", "sphere"] = "rectangle"
    width: float = 1.0
    """Metres along X; of a disc and a sphere, the diameter."""
    height: float = 1.0
    """Metres along Y."""
    radiance: Vec3 = (1.0, 1.0, 1.0)
    """Nits."""
    two_sided: bool = False
    """It emits along +Z, too; otherwise along -Z alone."""
    hidden_from_camera: bool = False
    """Traced frames: cameras see what is behind it; mirrors see it."""
    inner_angle: float = 0.0
    """Of the cone around -Z within which it emits: see `MaterialLayers.emission_inner`."""
    outer_angle: float = 0.0
    """0: it has no cone."""


@dataclass(slots=True, frozen=True)
class AnimationInfo:
    """An animation of a file that may hold several (glTF)."""

    name: str
    start: float
    """Of its keys, in seconds."""
    end: float
    frames: int
    """At the scene's rate."""
    plays: bool


@dataclass(slots=True, frozen=True)
class SceneInfo:
    """Statistics of a scene. 'Dynamic' means that it may move or deform at some time in the clip."""

    name: str
    triangles: int
    triangles_dynamic: int
    objects: int
    objects_dynamic: int
    meshes: int
    materials: int
    textures: int
    lights: list[str]
    """Names; '' for unnamed ones."""
    cameras: list[str]
    frames: int
    fps: float
    start: float
    """Seconds."""
    end: float
    bounds: tuple[Vec3, Vec3]
    """Low and high corner, at the start of the clip."""
    resolution: Size
    """Given by the file; (0, 0): none."""
    animations: list[AnimationInfo]
    variants: list[str]
    warnings: list[str]


@dataclass(slots=True, frozen=True)
class Pick:
    """What the last frame shows at the centre of a pixel."""

    instance: InstanceId
    material: Optional[MaterialId]
    triangle: int
    """Of the object's mesh, from 0."""
    position: Vec3
    """On the surface, in world space."""
    normal: Vec3
    """Shading normal in world space, of unit length, on the camera's side."""
    depth: float
    """Metres along the camera's axis."""


@dataclass(slots=True, frozen=True)
class FrameReport:
    """What the last frame changed against the one before it."""

    everything: bool
    """The renderer began anew, or the last frame failed: the lists of parts are empty."""
    instances: list[InstanceId]
    """Moved, deformed, appeared, vanished or added."""
    lights: list[LightId]
    materials: list[MaterialId]
    rectangles: list[tuple[int, int, int, int]] = field(default_factory=list)
    """(x, y, width, height) that contain all pixels whose colour differs; with RenderOptions.report_changes."""


@dataclass(slots=True, frozen=True)
class CompareResult:
    """The difference between two images, as their files store the values."""

    size: Size
    rmse: float
    relmse: float
    psnr: Optional[float]
    """Decibels; None: equal images."""
    ssim: Optional[float]
    flip: Optional[float]
    """Mean over the pixels."""
    max_abs: float
    pixels_different: float
    """Fraction of pixels of which any channel differs."""
