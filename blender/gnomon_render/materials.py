# SPDX-License-Identifier: Apache-2.0
"""Materials: node trees of surfaces in terms of glTF's metallic-roughness model and its extensions.

Each shader node gives a Surface, whose members are constants or image_maps. Mixes of surfaces mix their members, which is
exact for colours of one kind of surface, for emission and for transparency, and an approximation otherwise.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any, Optional

import numpy as np

from .geometry import Layers
from .images import ImageCache, ImageMap
from .nodes import Evaluator, LUMA, Value, apply, constant, followed
from .units import LUMENS_PER_WATT

_BLACK = (0.0, 0.0, 0.0, 1.0)


def _number(value: float) -> Any:
    return field(default_factory=lambda: constant(value))


def _color(*value: float) -> Any:
    return field(default_factory=lambda: constant(value))


@dataclass
class Surface:
    """A surface by the members of the metallic-roughness model."""

    kind: str = "opaque"
    """What the members stand for; surfaces of other kinds mix approximately."""
    base: Value = _color(0.8, 0.8, 0.8)
    metallic: Value = _number(0.0)
    roughness: Value = _number(0.5)
    specular: Value = _number(1.0)
    specular_tint: Value = _color(1.0, 1.0, 1.0)
    transmission: Value = _number(0.0)
    alpha: Value = _number(1.0)
    emission: Value = _color(0.0, 0.0, 0.0)
    coat: Value = _number(0.0)
    coat_roughness: Value = _number(0.0)
    sheen: Value = _color(0.0, 0.0, 0.0)
    ior: Value = _number(1.5)
    anisotropy: Value = _number(0.0)
    anisotropy_rotation: Value = _number(0.0)
    normal: Optional[Value] = None
    normal_scale: float = 1.0


@dataclass
class Made:
    """A material as Gnomon has it, and what it reads of meshes."""

    values: dict
    """Members of gnomon.Material; image maps in place of textures."""
    layers: Layers
    warnings: list
    animated: bool = False


class ShaderReader:
    """Reads the surface of one material."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.at = evaluator

    def surface(self, socket) -> Surface:
        """The surface of a shader input."""
        node, out = followed(socket)
        if node is None:
            return Surface(kind="none", base=constant(_BLACK), specular=constant(0.0))
        act = getattr(self, "_" + node.type.lower(), None)
        if act is None:
            self.at.warn(f"the shader '{node.bl_label}' is not known, and taken as a diffuse surface")
            return self._bsdf_diffuse(node, out)
        made: Surface = act(node, out)
        return made

    def _color(self, node, name: str = "Color") -> Value:
        return self.at.value(node.inputs[name]) if name in node.inputs else constant((0.8, 0.8, 0.8, 1))

    def _roughness(self, node) -> Value:
        return self.at.number(node.inputs["Roughness"]) if "Roughness" in node.inputs else constant(0.5)

    def _normal(self, node, into: Surface) -> Surface:
        if "Normal" not in node.inputs:
            return into
        source, _ = followed(node.inputs["Normal"])
        if source is None:
            return into
        if source.type == "NORMAL_MAP":
            if source.space != "TANGENT":
                self.at.warn(f"a normal map in {source.space.lower()} space is left out")
                return into
            value = self.at.value(source.inputs["Color"])
            if isinstance(value, ImageMap):
                into.normal, into.normal_scale = value, self.at.scalar(source.inputs["Strength"])
        elif source.type == "BUMP":
            self._bump(source, into)
        else:
            self.at.warn(f"the normal of the node '{source.bl_label}' is left out")
        return into

    def _bump(self, node, into: Surface) -> None:
        self.at.warn("a bump is left out; a normal map has its effect")

    # Shaders.

    def _bsdf_diffuse(self, node, out) -> Surface:
        return self._normal(node, Surface(base=self._color(node), roughness=constant(1.0), specular=constant(0.0)))

    def _bsdf_glossy(self, node, out) -> Surface:
        roughness = constant(0.0) if getattr(node, "distribution", "") == "SHARP" else self._roughness(node)
        return self._normal(node, Surface(base=self._color(node), metallic=constant(1.0), roughness=roughness))

    _bsdf_anisotropic = _bsdf_glossy

    def _bsdf_glass(self, node, out) -> Surface:
        roughness = constant(0.0) if node.distribution == "SHARP" else self._roughness(node)
        return self._normal(node, Surface(kind="glass", base=self._color(node), transmission=constant(1.0),
                                          roughness=roughness, ior=self.at.number(node.inputs["IOR"])))

    def _bsdf_refraction(self, node, out) -> Surface:
        self.at.warn("a refraction shader also reflects")
        return self._bsdf_glass(node, out)

    def _bsdf_transparent(self, node, out) -> Surface:
        color = self.at.plain(node.inputs["Color"])
        if np.ptp(color[:3]) > 1e-3:
            self.at.warn("the colour of a transparent shader is taken as grey")
        return Surface(kind="transparent", base=constant(_BLACK), specular=constant(0.0),
                       alpha=constant(1.0 - float(color[:3] @ LUMA)))

    def _bsdf_translucent(self, node, out) -> Surface:
        self.at.warn("a translucent shader is taken as a diffuse one")
        return self._bsdf_diffuse(node, out)

    def _bsdf_velvet(self, node, out) -> Surface:
        self.at.warn("a velvet shader is approximated by sheen")
        return Surface(base=constant(_BLACK), roughness=constant(1.0), specular=constant(0.0), sheen=self._color(node))

    def _subsurface_scattering(self, node, out) -> Surface:
        self.at.warn("subsurface scattering is taken as a diffuse surface")
        return self._bsdf_diffuse(node, out)

    def _emission(self, node, out) -> Surface:
        strength = self.at.number(node.inputs["Strength"])
        light = apply(lambda c, s: c * s[..., :1], ("emission",), self._color(node), strength)
        return Surface(kind="emission", base=constant(_BLACK), specular=constant(0.0), emission=light)

    _background = _emission

    def _holdout(self, node, out) -> Surface:
        self.at.warn("a holdout is black")
        return Surface(kind="none", base=constant(_BLACK), specular=constant(0.0))

    def _group(self, node, out) -> Surface:
        if node.node_tree is None:
            return Surface()
        end = next((each for each in node.node_tree.nodes if each.type == "GROUP_OUTPUT" and each.is_active_output), None)
        inner = end and next((each for each in end.inputs if each.identifier == out.identifier), None)
        if not inner:
            return Surface()
        self.at._groups.append(node)
        try:
            return self.surface(inner)
        finally:
            self.at._groups.pop()

    def _add_shader(self, node, out) -> Surface:
        first, second = self.surface(node.inputs[0]), self.surface(node.inputs[1])
        if second.kind != "emission":
            first, second = second, first
        if second.kind != "emission" and "none" not in (first.kind, second.kind):
            self.at.warn("a sum of shaders is approximated by their mean")
            return self._between(constant(0.5), first, second)
        first.emission = apply(lambda a, b: a + b, ("add",), first.emission, second.emission)
        if first.kind == "transparent" and isinstance(second.emission, np.ndarray) and second.emission[:3].any():
            self.at.warn("a surface that emits and is transparent emits by what it covers")
        return first

    def _mix_shader(self, node, out) -> Surface:
        source, link = followed(node.inputs["Fac"])
        if source is not None and source.type == "LIGHT_PATH":
            camera = link.name == "Is Camera Ray"
            self.at.warn(f"'{link.name}' is taken as {'1' if camera else '0'} for all rays")
            return self.surface(node.inputs[2 if camera else 1])
        if source is not None and source.type in {"FRESNEL", "LAYER_WEIGHT"}:
            return self._coated(node, source)
        factor = self.at.number(node.inputs["Fac"])
        if isinstance(factor, np.ndarray) and factor[0] in (0.0, 1.0):
            return self.surface(node.inputs[1 + int(factor[0])])
        first, second = self.surface(node.inputs[1]), self.surface(node.inputs[2])
        return self._mixed(factor, first, second)

    def _mixed(self, factor: Value, first: Surface, second: Surface) -> Surface:
        kinds = {first.kind, second.kind}
        if second.kind == "transparent" or first.kind == "transparent":
            if second.kind == "transparent":
                first, second = second, first
                factor = apply(lambda f: 1 - f, ("not",), factor)
            # The first one is transparent: what is left covers.
            second.alpha = apply(lambda f, a, b: f * b + (1 - f) * a, ("cover",), factor, first.alpha, second.alpha)
            return second
        if kinds == {"emission", "opaque"}:
            return self._between(factor, first, second)
        if len(kinds) > 1 or not np.array_equal(_kept(first), _kept(second)):
            self.at.warn("a mix of shaders is approximated by the mix of their values")
        return self._between(factor, first, second)

    def _coated(self, node, source) -> Surface:
        """A mix by the angle: a glossy layer over what is below."""
        below, above = self.surface(node.inputs[1]), self.surface(node.inputs[2])
        self.at.warn("a mix by the angle of view is approximated by a surface with highlights")
        below.specular, below.roughness = constant(1.0), above.roughness
        if source.type == "FRESNEL":
            below.ior = self.at.number(source.inputs["IOR"])
        return below

    def _between(self, factor: Value, first: Surface, second: Surface) -> Surface:
        made = Surface(kind=first.kind if first.kind == second.kind else "opaque")
        for member in fields(Surface):
            a, b = getattr(first, member.name), getattr(second, member.name)
            if member.name in {"kind", "normal_scale", "normal"}:
                continue
            if isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and np.array_equal(a, b):
                setattr(made, member.name, a)
            else:
                setattr(made, member.name, apply(lambda f, x, y: (1 - f[..., :1]) * x + f[..., :1] * y, ("between",), factor, a, b))
        keep = first if first.normal is not None else second
        made.normal, made.normal_scale = keep.normal, keep.normal_scale
        return made

    def _bsdf_principled(self, node, out) -> Surface:
        value, number = lambda name: self.at.value(node.inputs[name]), lambda name: self.at.number(node.inputs[name])  # noqa: E731
        made = Surface(base=value("Base Color"), metallic=number("Metallic"), roughness=number("Roughness"))
        if self._some(node, "Subsurface"):
            self.at.warn("subsurface scattering is taken as a diffuse surface")
            made.base = apply(lambda f, a, b: a * (1 - f[..., :1]) + b * f[..., :1], ("subsurface",), number("Subsurface"),
                              made.base, value("Subsurface Color"))
        # Principled's reflectance at normal incidence is 0.08 of this value, glTF's 0.04 of the specular colour.
        made.specular_tint = apply(lambda s: np.repeat(2 * s[..., :1], 4, axis=-1), ("f0",), number("Specular"))
        if self._some(node, "Specular Tint"):
            made.specular_tint = apply(_tinted, ("tint",), made.specular_tint, number("Specular Tint"), made.base)
        if self._some(node, "Transmission"):
            made.transmission, made.ior = number("Transmission"), number("IOR")
            made.specular_tint = constant((1, 1, 1, 1))
            made.kind = "glass"
            if self._some(node, "Transmission Roughness"):
                self.at.warn("transmission roughness is taken as the surface's own")
        if self._some(node, "Clearcoat"):
            made.coat, made.coat_roughness = number("Clearcoat"), number("Clearcoat Roughness")
        if self._some(node, "Sheen"):
            self.at.warn("sheen is approximated")
            made.sheen = apply(lambda s, t, c: s[..., :1] * (1 - t[..., :1] + t[..., :1] * c), ("sheen",), number("Sheen"),
                               number("Sheen Tint"), made.base)
        if self._some(node, "Anisotropic"):
            made.anisotropy, made.anisotropy_rotation = number("Anisotropic"), number("Anisotropic Rotation")
        if self._some(node, "Emission Strength"):
            made.emission = apply(lambda c, s: c * s[..., :1], ("emission",), value("Emission"), number("Emission Strength"))
        made.alpha = number("Alpha")
        if node.inputs["Clearcoat Normal"].is_linked or node.inputs["Tangent"].is_linked:
            self.at.warn("the normal of the clearcoat and the tangent are left out")
        return self._normal(node, made)

    def _some(self, node, name: str) -> bool:
        """Whether an input may be other than 0."""
        if name not in node.inputs:
            return False
        value = self.at.number(node.inputs[name])
        return isinstance(value, ImageMap) or bool(value[:3].any())


def _tinted(specular, share, base):
    luma = np.maximum((base[..., :3] @ LUMA)[..., None], 1e-6)
    rgb = specular[..., :3] * (1 - share[..., :1] + share[..., :1] * base[..., :3] / luma)
    return np.concatenate([rgb, np.ones_like(rgb[..., :1])], axis=-1)


def _kept(surface: Surface) -> np.ndarray:
    """What must be equal for a mix of colours to be exact."""
    names = ("metallic", "roughness", "specular", "transmission", "coat", "ior")
    values = [getattr(surface, name) for name in names]
    return np.array([np.nan if isinstance(v, ImageMap) else float(v[0]) for v in values])


def read_material(material, images: ImageCache, frame: int) -> Made:
    """What a material of Blender, or None, is in Gnomon."""
    warnings: list = []

    def warn(what: str) -> None:
        if what not in warnings:
            warnings.append(what)

    evaluator = Evaluator(images, frame, warn)
    surface = Surface()
    if material is not None and not material.use_nodes:
        surface = Surface(base=constant(material.diffuse_color), roughness=constant(float(material.roughness)),
                          metallic=constant(float(material.metallic)))
    elif material is not None and material.node_tree is not None:
        end = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
        if end is None:
            surface = Surface(kind="none", base=constant(_BLACK), specular=constant(0.0))
        else:
            surface = ShaderReader(evaluator).surface(end.inputs["Surface"])
            if end.inputs["Volume"].is_linked:
                warn("a volume is left out")
            if end.inputs["Displacement"].is_linked:
                warn("displacement is left out")
    writer = _Writer(warn)
    name = material.name_full if material is not None else ""
    values = writer.values(surface, name, material is not None and material.use_backface_culling)
    return Made(values, Layers(tuple(writer.uvs), evaluator.vertex_color), warnings)


class _Writer:
    """Turns a surface into the values of gnomon.Material, with (ImageMap, texcoord, srgb) in place of textures."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        self.warn = warn
        self.uvs: list = []

    def texture(self, image_map: ImageMap, srgb: bool, alpha: bool = False) -> tuple:
        name = image_map.mapping.uv
        if name not in self.uvs:
            if len(self.uvs) == 2:
                self.warn("more than two layers of texture coordinates: the others are read in place of the third")
                return image_map, 0, srgb, alpha
            self.uvs.append(name)
        return image_map, self.uvs.index(name), srgb, alpha

    def scalar(self, value: Value, what: str) -> float:
        if isinstance(value, ImageMap):
            self.warn(f"the image of {what} is taken as its mean")
            return float(np.clip(value.mean()[0], 0, 1))
        return float(np.clip(value[0], 0, 1))

    def colored(self, value: Value, scale: float = 1.0, highest: Optional[float] = 1.0) -> tuple:
        """(factor, image map or None) of a colour: pixels beyond 1 are scaled into the factor."""
        if not isinstance(value, ImageMap):
            color = np.maximum(value[:3], 0) * scale
            return tuple(float(c) for c in (color if highest is None else np.minimum(color, highest))), None
        most = float(max(value.pixels[..., :3].max(), 1.0)) if highest is None else 1.0
        if most > 1:
            pixels = value.pixels.copy()
            pixels[..., :3] /= most
            value = ImageMap(pixels, value.mapping, (*value.key, "scaled"))
        return (most * scale,) * 3, value

    def values(self, s: Surface, name: str, culls: bool) -> dict:
        base, image_map = self.colored(s.base)
        values: dict = {"name": name, "base_color": base, "double_sided": not culls, "layers": {}}
        alpha_map = s.alpha if isinstance(s.alpha, ImageMap) else None
        if image_map is not None or alpha_map is not None:
            values["base_color_texture"] = self.texture(self._with_alpha(image_map, alpha_map), True,
                                                        alpha_map is not None)
        values["alpha"] = 1.0 if alpha_map is not None else float(np.clip(s.alpha[0], 0, 1))
        if alpha_map is not None or values["alpha"] < 1:
            values["alpha_mode"] = "blend"
        self._metal(s, values)
        if s.normal is not None:
            values["normal_texture"] = self.texture(s.normal, False)
            values["normal_scale"] = s.normal_scale
        glow, glow_map = self.colored(s.emission, LUMENS_PER_WATT, None)
        values["emissive"] = glow
        if glow_map is not None:
            values["emissive_texture"] = self.texture(glow_map, True)
        self._layers(s, values)
        return values

    def _with_alpha(self, image_map: Optional[ImageMap], alpha: Optional[ImageMap]) -> ImageMap:
        if alpha is None:
            assert image_map is not None
            return image_map

        def join(color, cover):
            c, a = np.broadcast_arrays(color, cover)
            return np.concatenate([c[..., :3], a[..., :1]], axis=-1)

        joined = apply(join, ("alpha",), image_map if image_map is not None else constant((1, 1, 1, 1)), alpha)
        assert isinstance(joined, ImageMap)
        return joined

    def _metal(self, s: Surface, values: dict) -> None:
        if not isinstance(s.metallic, ImageMap) and not isinstance(s.roughness, ImageMap):
            values["metallic"], values["roughness"] = self.scalar(s.metallic, "metallic"), self.scalar(s.roughness, "roughness")
            return

        def pack(metallic, roughness):
            m, r = np.broadcast_arrays(metallic[..., 0], roughness[..., 0])
            return np.stack([np.zeros_like(m), np.clip(r, 0, 1), np.clip(m, 0, 1), np.ones_like(m)], axis=-1)

        packed = apply(pack, ("metal",), s.metallic, s.roughness)
        values["metallic"] = values["roughness"] = 1.0
        values["metallic_roughness_texture"] = self.texture(packed, False)

    def _layers(self, s: Surface, values: dict) -> None:
        layers: dict = values["layers"]
        specular = self.scalar(s.specular, "specular")
        tint = np.array(s.specular_tint.mean()) if isinstance(s.specular_tint, ImageMap) else s.specular_tint
        if isinstance(s.specular_tint, ImageMap):
            self.warn("the image of specular is taken as its mean")
        if specular != 1 or not np.array_equal(tint[:3], np.ones(3)):
            layers["specular"] = specular
            layers["specular_color"] = tuple(float(max(c, 0)) for c in tint[:3])
        values["transmission"] = self.scalar(s.transmission, "transmission")
        ior = s.ior.mean()[0] if isinstance(s.ior, ImageMap) else float(s.ior[0])
        values["ior"] = float(np.clip(ior, 1, 100))
        coat = self.scalar(s.coat, "clearcoat")
        if coat > 0:
            layers["clearcoat"] = coat
            layers["clearcoat_roughness"] = self.scalar(s.coat_roughness, "clearcoat roughness")
        sheen = np.array(s.sheen.mean()) if isinstance(s.sheen, ImageMap) else s.sheen
        if sheen[:3].any():
            layers["sheen_color"] = tuple(float(np.clip(c, 0, 1)) for c in sheen[:3])
            layers["sheen_roughness"] = 0.5
        strength = self.scalar(s.anisotropy, "anisotropy")
        if strength > 0:
            layers["anisotropy"] = strength
            layers["anisotropy_rotation"] = 2 * np.pi * self.scalar(s.anisotropy_rotation, "the rotation of anisotropy")
