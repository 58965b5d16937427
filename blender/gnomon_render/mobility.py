# SPDX-License-Identifier: Apache-2.0
"""What may change from frame to frame, found without evaluating other frames.

Gnomon remembers what is fixed. An object may move if it or something that it depends on is animated, driven or simulated.
What is taken for fixed and moves all the same is promoted by the renderer at the cost of a new scene, once.
"""
from __future__ import annotations

DEFORMING = {"ARMATURE", "CAST", "CLOTH", "CURVE", "HOOK", "LAPLACIANDEFORM", "LATTICE", "MESH_DEFORM", "OCEAN", "SHRINKWRAP",
             "SIMPLE_DEFORM", "SMOOTH", "SOFT_BODY", "SURFACE_DEFORM", "WARP", "WAVE", "MESH_CACHE", "MESH_SEQUENCE_CACHE",
             "DYNAMIC_PAINT", "FLUID", "EXPLODE", "NODES", "BUILD", "DISPLACE"}
"""Modifiers whose results may change without an animated property of theirs."""
BY_THEMSELVES = {"CLOTH", "OCEAN", "SOFT_BODY", "WAVE", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "DYNAMIC_PAINT", "FLUID",
                 "EXPLODE", "BUILD"}
"""Modifiers that depend on time."""


def _animated(block) -> bool:
    data = getattr(block, "animation_data", None)
    return data is not None and bool(data.action or len(data.nla_tracks) or len(data.drivers))


class Mobility:
    """Answers for the objects of one scene."""

    def __init__(self) -> None:
        self._moves: dict = {}
        self._deforms: dict = {}

    def moves(self, original) -> bool:
        """Whether the object's transform or visibility may change."""
        known = self._moves.get(original)
        if known is None:
            self._moves[original] = False   # ends cycles
            known = self._moves[original] = self._find_moves(original)
        return known

    def _find_moves(self, ob) -> bool:
        if _animated(ob) or ob.rigid_body is not None or len(ob.particle_systems):
            return True
        if ob.parent is not None:
            bends = ob.parent_type in {"VERTEX", "VERTEX_3", "ARMATURE", "LATTICE"}
            if self.moves(ob.parent) or ob.parent_type == "BONE" or (bends and self.deforms(ob.parent)):
                return True
        for constraint in ob.constraints:
            if constraint.type in {"FOLLOW_PATH", "TRANSFORM_CACHE", "CAMERA_SOLVER", "FOLLOW_TRACK"}:
                return True
            targets = [getattr(constraint, "target", None)]
            targets += [each.target for each in getattr(constraint, "targets", [])]
            if any(target is not None and (self.moves(target) or self.deforms(target)) for target in targets):
                return True
        return any(_animated(collection) for collection in ob.users_collection)

    def deforms(self, original) -> bool:
        """Whether the object's vertices may change."""
        known = self._deforms.get(original)
        if known is None:
            self._deforms[original] = False
            known = self._deforms[original] = self._find_deforms(original)
        return known

    def _find_deforms(self, ob) -> bool:
        data = ob.data
        if ob.type == "ARMATURE":
            return _animated(ob) or _animated(data) or any(len(bone.constraints) for bone in ob.pose.bones)
        if data is None:
            return False
        keys = getattr(data, "shape_keys", None)
        if _animated(data) or (keys is not None and _animated(keys)) or ob.type == "META":
            return True
        if len(ob.modifiers) and _animated(ob):
            if any("modifiers" in curve.data_path for curve in _curves(ob)):
                return True
        return any(self._changes(ob, modifier) for modifier in ob.modifiers if modifier.show_render)

    def _changes(self, ob, modifier) -> bool:
        if modifier.type in BY_THEMSELVES:
            return True
        if modifier.type == "NODES" and modifier.node_group is not None:
            group = modifier.node_group
            if _animated(group) or any(node.bl_idname == "GeometryNodeInputSceneTime" for node in group.nodes):
                return True
        for name in modifier.bl_rna.properties.keys():
            if name in {"rna_type", "id_type"}:
                continue
            other = getattr(modifier, name, None)
            if getattr(other, "bl_rna", None) is None or not hasattr(other, "users_collection"):
                continue
            # The result is in the object's own space: what both carry along does not matter, and is not looked for.
            if self.moves(other) or self.deforms(other):
                return True
            if modifier.type in {"SHRINKWRAP", "SURFACE_DEFORM", "MESH_DEFORM", "HOOK", "CURVE", "LATTICE"} and self.moves(ob):
                return True
        return False


def _curves(ob) -> list:
    data = ob.animation_data
    curves = list(data.drivers)
    if data.action:
        curves += list(data.action.fcurves)
    return curves
