# SPDX-License-Identifier: Apache-2.0
"""Keeps a scene of Gnomon like what a dependency graph of Blender evaluates.

The first synchronisation reads everything. Later ones read what `depsgraph.updates` lists, and compare the instances that
there are with those that were. Transforms, vertices, visibility, and the values of lights and materials go to the renderer
as changes; parts that come or go make another scene of the same builder, which shares all else.
"""
from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, Optional

import gnomon
import numpy as np

from . import geometry, lights, units, world
from .images import ImageCache, bytes_of
from .materials import Made, read_material
from .mobility import Mobility
from .nodes import Evaluator
from .parts import Changes, InstancePart, LightPart, MaterialPart, MeshPart, Updates

_HIDDEN_PARTS = 1024
"""Hidden instances that are kept, and shown again without another scene; beyond, they are removed."""


class SceneSync:
    """The scene of one view layer."""

    def __init__(self, warn: Callable[[str], None], may_change: bool) -> None:
        """warn(what)   is told of what is approximated
        may_change      everything may move and deform, as in a viewport; otherwise, what is animated"""
        self.warn = warn
        self.may_change = may_change
        self.images = ImageCache()
        self.mobility = Mobility()
        self.builder = gnomon.SceneBuilder()
        self.scene: Any = None
        self.sun_angle = 0.0
        self.object_index: dict = {}
        self._finished = False
        self._frame = 0
        self._materials: dict = {}
        self._textures: dict = {}
        self._meshes: dict = {}
        self._instances: dict = {}
        self._lights: dict = {}
        self._world: Optional[bytes] = None
        self._override: Any = None
        self._override_name = ""
        self._slot_materials: list = []
        self._done: set = set()
        self.removed: set = set()
        """Ids of parts that the last update has removed."""
        self._before: dict = {}   # values that the last update has replaced
        self._names: dict = {}

    # The whole.

    def update(self, depsgraph, updates: Updates, changes: Changes) -> None:
        """Follows the dependency graph. `scene` is then the scene to render, with the changes, to which those since the
        last call are added."""
        self._frame = depsgraph.scene_eval.frame_current
        for name in updates.images:
            self.images.forget(name)
        self._done.clear()
        self._before.clear()
        self.removed = set()
        override = depsgraph.view_layer_eval.material_override
        name = override.name_full if override else ""
        if name != self._override_name:
            updates.everything = True
        self._override, self._override_name = override, name
        self._follow_materials(depsgraph, updates, changes)
        self._follow_world(depsgraph, updates)
        self._follow_objects(depsgraph, updates, changes)
        if not self._finished:
            fps = depsgraph.scene_eval.render.fps / depsgraph.scene_eval.render.fps_base
            self.builder.clip(0.0, 1.0, float(fps))
            self.scene = self.builder.finish()
            self._finished = True
            self._names = {part.id: key[0] for key, part in self._instances.items()}
        changes.drop(self.removed)

    def transform_before(self, node) -> np.ndarray:
        """A node's transform before the last update, which has changed it."""
        matrix: np.ndarray = self._before[node]
        return matrix

    def vertices_before(self, instance) -> gnomon.Vertices:
        """An instance's vertices before the last update, which has changed them."""
        vertices: gnomon.Vertices = self._before[instance, "vertices"]
        return vertices

    def _change_builder(self) -> None:
        self._finished = False

    def _follow_objects(self, depsgraph, updates: Updates, changes: Changes) -> None:
        seen: set = set()
        seen_lights: set = set()
        for instance in depsgraph.object_instances:
            ob = instance.object
            if not instance.show_self:
                continue
            name = ob.name_full
            key = (name,)
            moved = updates.everything or instance.is_instance or name in updates.transforms
            if instance.is_instance:
                parent = instance.parent
                key = (name, parent.name_full if parent else "", tuple(instance.persistent_id))
            if ob.type == "LIGHT":
                seen_lights.add(key)
                self._follow_light(key, ob, instance, moved, updates, changes)
            elif ob.type in geometry.WITH_SURFACE:
                if self._follow_instance(key, ob, instance, moved, updates, changes):
                    seen.add(key)
        self._hide_unseen(seen, seen_lights, changes)
        self._remove_unused(seen)
        self._find_sun(seen_lights)

    def _hide_unseen(self, seen: set, seen_lights: set, changes: Changes) -> None:
        for key, part in self._instances.items():
            if part.visible and key not in seen:
                part.visible = False
                changes.visibility[part.id] = False
        for key, light in self._lights.items():
            if light.visible and key not in seen_lights:
                light.visible = False
                changes.visibility[light.node] = False

    def _remove_unused(self, seen: set) -> None:
        hidden = [key for key in self._instances if key not in seen]
        if len(hidden) <= max(_HIDDEN_PARTS, len(seen)):
            return
        for key in hidden:
            self._remove_instance(key)

    def _find_sun(self, seen: set) -> None:
        suns = [part.made for key, part in self._lights.items()
                if key in seen and part.made.kind == "light" and part.made.values["type"] == "directional"]
        suns.sort(key=lambda made: -max(made.values["color"]))
        self.sun_angle = suns[0].sun_angle if suns else 0.0
        if any(abs(made.sun_angle - self.sun_angle) > 1e-4 for made in suns):
            self.warn("suns of several sizes: all have that of the strongest")

    # Materials and textures.

    def _follow_materials(self, depsgraph, updates: Updates, changes: Changes) -> None:
        for (name, hidden), part in self._materials.items():
            if not (updates.everything or name in updates.shading or self._reads(part, updates.images)):
                continue
            block = _find_material(depsgraph, name)
            if block is None and name:
                continue
            made = self._read_material(block, name)
            if (signature := _signature(made)) == part.signature:
                continue
            material, textures, added = self._to_gnomon(made, hidden)
            if made.layers != part.made.layers:
                for mesh in self._meshes.values():
                    mesh.topology = b""   # read again what the material needs
                updates.everything = True
            changes.materials[part.id] = material
            if added or textures != part.textures:
                self.builder.set_material(part.id, material)
                self._change_builder()
            part.made, part.signature, part.textures = made, signature, textures
        self._remove_textures()

    def _reads(self, part: MaterialPart, images: set) -> bool:
        return bool(images) and any(key[0] in images for key in part.textures)

    def _read_material(self, block, name: str) -> Made:
        made = read_material(block, self.images, self._frame)
        for warning in made.warnings:
            self.warn(f"material '{name or 'default'}': {warning}")
        return made

    def _material(self, block, hidden: bool) -> MaterialPart:
        key = (block.name_full if block is not None else "", hidden)
        if key not in self._materials:
            made = self._read_material(block, key[0])
            material, textures, _ = self._to_gnomon(made, hidden)
            self._materials[key] = MaterialPart(self.builder.material(material), made, _signature(made), textures)
            self._change_builder()
        return self._materials[key]

    def _to_gnomon(self, made: Made, hidden: bool) -> tuple:
        """(gnomon.Material, keys of its textures, whether one of them is new)."""
        values = dict(made.values)
        textures: set = set()
        added = False
        for name, value in made.values.items():
            if not name.endswith("_texture"):
                continue
            image_map, texcoord, srgb, alpha = value
            mapping = image_map.mapping
            key = (*image_map.key, srgb, alpha, mapping.wrap, mapping.filter)
            if key not in self._textures:
                self._textures[key] = self.builder.texture(
                    bytes_of(image_map, srgb, alpha), srgb=srgb, wrap_u=mapping.wrap, wrap_v=mapping.wrap,
                    magnify=mapping.filter, minify=mapping.filter, name=str(image_map.key[0]))
                added = True
                self._change_builder()
            textures.add(key)
            offset, scale, rotation = mapping.to_gltf()
            values[name] = gnomon.TextureUse(self._textures[key], texcoord, offset, scale, rotation)
        if layers := values.pop("layers"):
            values["layers"] = gnomon.MaterialLayers(**layers)
        return gnomon.Material(**values, hidden_from_camera=hidden), textures, added

    def _remove_textures(self) -> None:
        if len(self._textures) < 64:
            return
        used = set().union(*(part.textures for part in self._materials.values()))
        for key in [key for key in self._textures if key not in used]:
            try:
                self.builder.remove(self._textures[key])
            except gnomon.UsageError:
                continue   # a material of the builder still has it
            del self._textures[key]
            self._change_builder()

    # Meshes and instances.

    def _follow_instance(self, key: tuple, ob, instance, moved: bool, updates: Updates, changes: Changes) -> bool:
        """Whether the object has a surface."""
        mesh_key = self._mesh_key(ob)
        part = self._instances.get(key)
        if part is not None and part.mesh != mesh_key:
            self._remove_instance(key)
            part = None
        mesh = self._mesh(mesh_key, ob, updates, changes)
        if mesh is None:
            if part is not None:
                self._remove_instance(key)
            return False
        part = self._instances.get(key)   # another mesh may have taken its place
        if part is None:
            matrix = units.to_y_up(instance.matrix_world)
            self._add_instance(key, mesh_key, mesh, ob, matrix, instance.is_instance, changes)
            return True
        if moved:
            matrix = units.to_y_up(instance.matrix_world)
            if not np.array_equal(matrix, part.matrix):
                self._before[part.id] = part.matrix
                part.matrix = matrix
                changes.transforms[part.id] = matrix
        if not part.visible:
            part.visible = True
            changes.visibility[part.id] = True
        return True

    def _add_instance(self, key: tuple, mesh_key: tuple, mesh: MeshPart, ob, matrix: np.ndarray, is_instance: bool,
                      changes: Changes) -> None:
        mobility = "fixed"
        if mesh.deforms:
            mobility = "may_deform"
        elif self.may_change or is_instance and self._instancer_moves(key) or self.mobility.moves(ob.original):
            mobility = "may_move"
        added = self.builder.instance(mesh.id, None, matrix, mobility=mobility, name=ob.name_full)
        self._instances[key] = InstancePart(added, mesh_key, ob.name_full, matrix)
        mesh.users.add(key)
        if mesh.vertices is not None:
            changes.vertices[added] = mesh.vertices
        self._change_builder()

    def _instancer_moves(self, key: tuple) -> bool:
        import bpy

        parent = bpy.data.objects.get(key[1])
        return parent is None or self.mobility.moves(parent) or self.mobility.deforms(parent)

    def _remove_instance(self, key: tuple) -> None:
        part = self._instances.pop(key)
        self.removed.add(part.id)
        self.builder.remove(part.id)
        self._change_builder()
        mesh = self._meshes.get(part.mesh)
        if mesh is None:
            return
        mesh.users.discard(key)
        if not mesh.users:
            self.builder.remove(mesh.id)
            del self._meshes[part.mesh]

    def _slots(self, ob) -> list:
        if self._override is not None:
            return [self._override]
        return [slot.material for slot in ob.material_slots] or [None]

    def _mesh_key(self, ob) -> tuple:
        names = tuple(m.name_full if m is not None else "" for m in self._slots(ob))
        hidden = not ob.visible_camera
        data = ob.data
        own = len(ob.modifiers) > 0 or ob.type != "MESH" or data is None
        if own:
            # Instances made by nodes have data of their own under the object's name.
            return "Object", ob.name_full, data.name_full if data is not None else "", names, hidden
        return "Data", data.name_full, "", names, hidden

    def _mesh(self, key: tuple, ob, updates: Updates, changes: Changes) -> Optional[MeshPart]:
        """The mesh as it is now, whose users have it; None: the object has no surface."""
        part = self._meshes.get(key)
        if key in self._done:
            return part
        data = ob.data.name_full if ob.data is not None else ""
        changed = (updates.everything or ("Object", ob.name_full) in updates.geometry
                   or ("Data", data) in updates.geometry)
        if part is not None and not changed:
            return part
        self._done.add(key)
        deforms = part.deforms if part is not None else self.mobility.deforms(ob.original)
        made = self._extract(ob, key, deforms)
        if part is not None and made is not None and not deforms and not part.holds(made):
            made = self._extract(ob, key, True)   # it changes after all
        if made is None:
            if part is not None:
                self._remove_mesh(key)
            return None
        if part is None:
            return self._add_mesh(key, made, ob)
        if made.topology() != part.topology:
            users = {user: self._instances[user] for user in part.users}
            self._remove_mesh(key)
            part = self._add_mesh(key, made, ob)
            for user, old in users.items():
                self._add_again(user, key, part, old)
                if part.vertices is not None:
                    changes.vertices[self._instances[user].id] = part.vertices
        elif (shape := made.shape()) != part.shape:
            before, part.vertices = part.vertices, gnomon.Vertices(made.positions, made.normals)
            part.shape = shape
            for user in part.users:
                self._before[self._instances[user].id, "vertices"] = before
                changes.vertices[self._instances[user].id] = part.vertices
        return part

    def _add_again(self, key: tuple, mesh_key: tuple, mesh: MeshPart, old: InstancePart) -> None:
        mobility = "may_deform" if mesh.deforms else "may_move"
        added = self.builder.instance(mesh.id, None, old.matrix, mobility=mobility, name=old.source)
        self._instances[key] = InstancePart(added, mesh_key, old.source, old.matrix)
        mesh.users.add(key)

    def _remove_mesh(self, key: tuple) -> None:
        for user in list(self._meshes[key].users):
            self._remove_instance(user)

    def _add_mesh(self, key: tuple, made: geometry.Geometry, ob) -> MeshPart:
        parts = []
        for slot, count in made.runs:
            block = self._slot_materials[min(slot, len(self._slot_materials) - 1)]
            parts.append((self._material(block, key[4]).id, count))
        uvs = {name: array for name, array in zip(("uvs", "uvs2"), made.uvs)}
        # Frames do not depend on the one with which rendering began: the mesh is that at rest, its vertices are in force.
        rest = geometry.at_rest(made, ob.original) if made.deforms else made.positions
        added = self.builder.mesh(rest, made.triangles, normals=made.normals, colors=made.colors, parts=parts,
                                  name=key[1], **uvs)
        self._change_builder()
        first = gnomon.Vertices(made.positions, made.normals) if made.deforms else None
        part = self._meshes[key] = MeshPart(added, made.topology(), made.shape(), made.deforms, first)
        return part

    def _extract(self, ob, key: tuple, deforms: bool) -> Optional[geometry.Geometry]:
        self._slot_materials = self._slots(ob)
        layers = [self._material(block, key[4]).made.layers for block in self._slot_materials]
        try:
            mesh = ob.to_mesh()
        except RuntimeError:
            return None   # it has no geometry
        if mesh is None:
            return None
        try:
            return geometry.extract(mesh, layers, deforms)
        finally:
            ob.to_mesh_clear()

    # Lights.

    def _follow_light(self, key: tuple, ob, instance, moved: bool, updates: Updates, changes: Changes) -> None:
        part = self._lights.get(key)
        changed = part is None or moved or updates.everything or ob.data.name_full in updates.shading
        if part is not None and part.visible and not changed:
            return
        warn = lambda what: self.warn(f"light '{ob.name_full}': {what}")  # noqa: E731
        made = lights.read_light(ob.data, Evaluator(self.images, self._frame, warn), warn)
        matrix = np.array(instance.matrix_world, dtype=float)
        if made is None:
            made = lights.MadeLight("light", {"name": ob.name_full, "type": "point", "color": (0.0, 0.0, 0.0)})
        made = lights.stretched_area(made, matrix)
        place = units.Y_UP @ lights.without_scale(matrix)
        if made.scale != (1.0, 1.0, 1.0):
            place = place @ np.diag([*made.scale, 1.0])
        fixed = made.fixed()
        if part is not None and part.fixed != fixed:
            self.removed |= {part.node, part.light, part.material}
            self.builder.remove(part.node)
            self._change_builder()
            part = None
        if part is None:
            self._lights[key] = self._add_light(made, fixed, place, ob)
            return
        if not np.array_equal(place, part.matrix):
            self._before[part.node] = part.matrix
            part.matrix = place
            changes.transforms[part.node] = place
        if made.values != part.made.values:
            part.made = made
            if part.light is not None:
                changes.lights[part.light] = gnomon.Light(**made.values)
            else:
                changes.materials[part.material] = _light_material(made)
        part.made = made
        if not part.visible:
            part.visible = True
            changes.visibility[part.node] = True

    def _add_light(self, made: lights.MadeLight, fixed: tuple, place: np.ndarray, ob) -> LightPart:
        mobility = "may_move" if self.may_change or self.mobility.moves(ob.original) else "fixed"
        node = self.builder.node(place, mobility=mobility, name=ob.name_full)
        part = LightPart(node, made, fixed, matrix=place)
        if made.kind == "light":
            part.light = self.builder.light(gnomon.Light(**made.values), parent=node)
        else:
            _, part.material = self.builder.area_light(gnomon.AreaLight(**made.values), parent=node, mobility=mobility)
        self._change_builder()
        return part

    # The world, and what ids mean.

    def _follow_world(self, depsgraph, updates: Updates) -> None:
        if self._world is not None and not (updates.everything or updates.world or updates.images):
            return
        made = world.read_world(depsgraph.scene_eval.world, self.images, self._frame,
                                lambda what: self.warn(f"world: {what}"))
        signature = b"dark" if made.pixels is None else hashlib.blake2b(
            np.ascontiguousarray(made.pixels), digest_size=16, key=repr(made.pixels.shape).encode()).digest()
        if signature == self._world:
            return
        if made.pixels is not None:
            self.builder.environment(made.pixels)
        elif self._world is not None:
            self.builder.background((0.0, 0.0, 0.0))
        self._world = signature
        self._change_builder()

    def names_of(self, ids: np.ndarray) -> dict:
        """{value of the layer of ids: name of the object}."""
        found = {}
        for value in np.unique(ids):
            part = self.scene.instance_of(int(value)) if value else None
            if part is not None and part in self._names:
                found[int(value)] = self._names[part]
        return found

    def reflectances(self, ids: np.ndarray) -> dict:
        """By value of the layer of materials: share of metal, reflectance of what is not metal, share of glass."""
        by_id = {part.id: part.made.values for part in self._materials.values()}
        found = {}
        for value in np.unique(ids):
            material = self.scene.material_of(int(value)) if value else None
            values = by_id.get(material) if material is not None else None
            if values is None:
                continue
            layers = values["layers"]
            specular = 0.04 * layers.get("specular", 1.0) * float(np.mean(layers.get("specular_color", (1.0,))))
            textured = "metallic_roughness_texture" in values
            found[int(value)] = (0.0 if textured else values["metallic"], specular, values["transmission"])
        return found

    def light_channels(self) -> list:
        """The channels of the layer of shadows that belong to lights."""
        lights = {part.light for part in self._lights.values() if part.light is not None and part.visible}
        return [index for index, light in enumerate(self.scene.lights) if light in lights]

    def close(self) -> None:
        self.builder.close()


def _find_material(depsgraph, name: str):
    import bpy

    block = bpy.data.materials.get(name) if name else None
    return None if block is None else block.evaluated_get(depsgraph)


def _light_material(made: lights.MadeLight) -> gnomon.Material:
    layers = None
    if "outer_angle" in made.values:
        layers = gnomon.MaterialLayers(emission_inner=made.values["inner_angle"], emission_outer=made.values["outer_angle"])
    return gnomon.Material(name=made.values["name"], base_color=(0.0, 0.0, 0.0), emissive=made.values["radiance"], layers=layers,
                           hidden_from_camera=made.values["hidden_from_camera"])


def _signature(made: Made) -> tuple:
    """Equal for materials that look the same."""
    values = []
    for name, value in sorted(made.values.items()):
        if name.endswith("_texture"):
            image_map, *use = value
            value = (image_map.key, image_map.mapping, tuple(use))
        values.append((name, repr(value)))
    return tuple(values), made.layers
