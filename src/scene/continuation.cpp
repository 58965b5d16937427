// SPDX-License-Identifier: Apache-2.0
#include "scene/continuation.h"

#include <algorithm>
#include <unordered_map>

#include "base/bits.h"

namespace gnomon::scene {

namespace {

// Removed objects are kept up to so many, and so many for every one that is there.
constexpr std::size_t k_removed_at_least = 1024, k_removed_per_object = 2;
// Meshes that are gone are kept up to so many triangles, and as many as those that are there have.
constexpr std::size_t k_removed_triangles = 1u << 18;
// Of all objects together, removed ones included: half of what 32 bits can number.
constexpr std::uint64_t k_most_triangles = 1ull << 31;

bool same_skins(const std::vector<Skin>& a, const std::vector<Skin>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Skin& x, const Skin& y) {
        return x.joints == y.joints && same_bits(x.inverse_bind, y.inverse_bind);
    });
}

// Whether two backgrounds are the same but for their images.
bool same_background(const Background& a, const Background& b)
{
    return a.kind == b.kind && same_bits(a.color, b.color) && same_bits(a.zenith, b.zenith) &&
           same_bits(a.horizon, b.horizon) && same_bits(a.ground, b.ground) &&
           same_bits(a.sun_direction, b.sun_direction) && same_bits(a.sun_radiance, b.sun_radiance) &&
           (a.environment == nullptr) == (b.environment == nullptr);
}

bool same_timeline(const Timeline& a, const Timeline& b)
{
    return same_bits(a.start, b.start) && same_bits(a.end, b.end) && a.frames == b.frames && same_bits(a.fps, b.fps) &&
           a.own_frames == b.own_frames;
}

bool has_track(const Node& node)
{
    return node.transform || node.visibility || node.weights;
}

// Whether two nodes are the same but for their names and meshes.
bool same_node(const Node& a, const Node& b)
{
    return a.parent == b.parent && same_bits(a.local, b.local) && a.transform == b.transform &&
           a.visibility == b.visibility && a.weights == b.weights && a.animated == b.animated &&
           a.deforms == b.deforms && a.skin == b.skin && same_bits(a.morph_weights, b.morph_weights) &&
           same_bits(a.reach, b.reach);
}

// Numbers the parts of one scene as another has them, step by step. Each step returns whether that is possible.
class Numbering {
 public:
    Numbering(const Scene& before, const Scene& wanted)
        : before_(before), wanted_(wanted), made_(std::make_shared<Scene>(wanted))
    {
    }

    std::optional<Continuation> make()
    {
        const bool same = same_skins(before_.skins, wanted_.skins) &&
                          same_background(before_.background, wanted_.background) &&
                          same_bits(before_.ambient, wanted_.ambient) &&
                          same_timeline(before_.timeline, wanted_.timeline) && !wanted_.nodes.empty();
        if (!same || !compare_nodes() || !compare_lights() || !compare_textures()) return {};
        result_.other_environment = before_.background.environment != wanted_.background.environment;
        number_meshes();
        if (!compare_materials()) return {};
        keep_objects();
        if (!static_objects_stay()) return {};
        number_groups();
        remove_objects();
        add_objects();
        if (too_much_is_gone()) return {};
        result_.scene = std::move(made_);
        return std::move(result_);
    }

 private:
    // Finds the nodes that are replaced. None of these may have a track or a joint.
    bool compare_nodes()
    {
        const std::size_t both = std::min(before_.nodes.size(), wanted_.nodes.size());
        same_.assign(wanted_.nodes.size(), 0);
        for (std::size_t n = 0; n < wanted_.nodes.size(); ++n) {
            const Node& node = wanted_.nodes[n];
            same_[n] = n < both && same_node(before_.nodes[n], node) && (node.parent == none || same_[node.parent]);
            if (same_[n]) continue;
            if (has_track(node) || (n < both && has_track(before_.nodes[n]))) return false;
            result_.replaced.push_back(static_cast<NodeId>(n));
        }
        for (std::size_t n = both; n < before_.nodes.size(); ++n)
            if (has_track(before_.nodes[n])) return false;
        return std::all_of(wanted_.skins.begin(), wanted_.skins.end(), [&](const Skin& skin) {
            return std::all_of(skin.joints.begin(), skin.joints.end(), [&](NodeId joint) { return stays(joint); });
        });
    }

    bool stays(NodeId node) const { return node < same_.size() && same_[node] != 0; }

    // Whether a node and its ancestors never move.
    static bool rests(const Scene& scene, NodeId node)
    {
        for (; node != none; node = scene.nodes[node].parent)
            if (scene.nodes[node].may_move()) return false;
        return true;
    }

    bool compare_lights()
    {
        if (before_.lights.size() != wanted_.lights.size()) return false;
        for (std::size_t l = 0; l < wanted_.lights.size(); ++l) {
            const Light &a = before_.lights[l], &b = wanted_.lights[l];
            if (a.type != b.type || a.of_environment != b.of_environment || a.by_default != b.by_default ||
                a.of_surface != b.of_surface || a.track != b.track)
                return false;
            if (a.node == b.node && stays(b.node)) continue;
            // The node of a default light comes after all others, so it may be another one in the same place. Those
            // that approximate an image may be elsewhere.
            if (!rests(before_, a.node) || !rests(wanted_, b.node)) return false;
            if (!b.of_environment && !same_bits(before_.world_matrix(a.node, 0), wanted_.world_matrix(b.node, 0)))
                return false;
        }
        return true;
    }

    bool compare_textures() const
    {
        if (wanted_.textures.size() < before_.textures.size()) return false;
        for (std::size_t t = 0; t < before_.textures.size(); ++t)
            if (before_.textures.shared(t) != wanted_.textures.shared(t)) return false;
        return true;
    }

    // Gives the meshes of wanted nodes the numbers that they had, or new ones at the end.
    void number_meshes()
    {
        made_->meshes = before_.meshes;
        std::unordered_map<const Mesh*, MeshId> numbers;
        for (std::size_t m = 0; m < before_.meshes.size(); ++m)
            numbers.emplace(before_.meshes.shared(m).get(), static_cast<MeshId>(m));
        is_there_.assign(before_.meshes.size(), 0);
        for (std::size_t m = 0; m < wanted_.meshes.size(); ++m)
            if (const auto at = numbers.find(wanted_.meshes.shared(m).get()); at != numbers.end())
                is_there_[at->second] = 1;
        for (Node& node : made_->nodes) {
            if (node.mesh == none) continue;
            const std::shared_ptr<const Mesh>& mesh = wanted_.meshes.shared(node.mesh);
            const auto [at, is_new] = numbers.emplace(mesh.get(), static_cast<MeshId>(made_->meshes.size()));
            if (is_new) made_->meshes.push_shared(mesh);
            node.mesh = at->second;
        }
    }

    // A material that changes must look the same to rays, unless no mesh had it that is still there.
    bool compare_materials()
    {
        if (wanted_.materials.size() < before_.materials.size()) return false;
        for (std::size_t m = 0; m < before_.materials.size(); ++m) {
            const Material &old = before_.materials[m], &now = wanted_.materials[m];
            const auto id = static_cast<MaterialId>(m);
            if (old.track != now.track) return false;
            if (same_values(old, now) || !was_used(id)) continue;
            if (!same_to_rays(old, now)) return false;
            result_.edited.push_back(id);
        }
        return true;
    }

    bool was_used(MaterialId material) const
    {
        for (std::size_t m = 0; m < is_there_.size(); ++m)
            if (is_there_[m])
                for (const MeshPart& part : before_.meshes[m].parts)
                    if (part.material == material) return true;
        return false;
    }

    // Finds the objects that stay.
    void keep_objects()
    {
        std::vector<ObjectId> at(before_.nodes.size(), none);
        for (std::size_t o = 0; o < before_.objects.size(); ++o)
            if (!before_.objects[o].removed) at[before_.objects[o].node] = static_cast<ObjectId>(o);
        number_.assign(wanted_.objects.size(), none);
        taken_.assign(before_.objects.size(), 0);
        for (std::size_t i = 0; i < wanted_.objects.size(); ++i) {
            Object object = wanted_.objects[i];
            object.mesh = made_->nodes[object.node].mesh;
            if (!stays(object.node) || at[object.node] == none) continue;
            const Object& old = before_.objects[at[object.node]];
            if (old.mesh != object.mesh || old.skin != object.skin || old.dynamic != object.dynamic ||
                old.deforming != object.deforming || (old.group == none) != (object.group == none))
                continue;
            number_[i] = at[object.node];
            taken_[number_[i]] = 1;
        }
    }

    // Whether all that is not kept is dynamic, and rigid or deformed by the host alone.
    bool static_objects_stay() const
    {
        const auto may_go = [](const Scene& scene, const Object& object) {
            return object.dynamic && object.skin == none && !scene.meshes[object.mesh].vertex_keys;
        };
        for (std::size_t i = 0; i < wanted_.objects.size(); ++i)
            if (number_[i] == none && !may_go(wanted_, wanted_.objects[i])) return false;
        for (std::size_t o = 0; o < before_.objects.size(); ++o)
            if (!taken_[o] && !before_.objects[o].removed && !may_go(before_, before_.objects[o])) return false;
        return true;
    }

    // A group stays if none of its objects went, and none joined it; else all of its objects are replaced.
    void number_groups()
    {
        made_->groups = before_.groups;
        group_of_.assign(wanted_.groups.size(), none);
        std::vector<std::uint32_t> index_of(wanted_.objects.size());
        for (std::size_t g = 0; g < wanted_.groups.size(); ++g) {
            const RigidGroup& group = wanted_.groups[g];
            const ObjectId first = number_[group.objects.front()];
            const GroupId old = first == none ? none : before_.objects[first].group;
            const bool whole =
                old != none && before_.groups[old].anchor == group.anchor &&
                before_.groups[old].objects.size() == group.objects.size() &&
                std::equal(group.objects.begin(), group.objects.end(), before_.groups[old].objects.begin(),
                           [&](ObjectId now, ObjectId then) { return number_[now] == then; });
            if (whole) {
                group_of_[g] = old;
                continue;
            }
            for (const ObjectId o : group.objects) {
                if (number_[o] != none) taken_[number_[o]] = 0;
                number_[o] = none;
            }
        }
    }

    // Marks what is gone; groups that lost their objects are free.
    void remove_objects()
    {
        made_->objects = before_.objects;
        for (std::size_t o = 0; o < before_.objects.size(); ++o) {
            Object& object = made_->objects[o];
            if (taken_[o] || object.removed) continue;
            result_.removed.push_back(static_cast<ObjectId>(o));
            object.removed = true;
            object.node = 0;
            if (object.group != none) made_->groups[object.group].objects.clear();
        }
        // In free groups and removed objects, no number may point to a node that is gone.
        for (RigidGroup& group : made_->groups)
            if (group.objects.empty()) group.anchor = 0;
    }

    // Gives numbers to what is new: of objects with the same mesh that were removed in an earlier step, else new ones.
    void add_objects()
    {
        std::unordered_map<std::uint64_t, std::vector<ObjectId>> free;
        const auto kind = [](const Object& object) {
            return (std::uint64_t{object.mesh} << 1) | (object.deforming ? 1u : 0u);
        };
        for (std::size_t o = before_.objects.size(); o-- > 0;)
            if (before_.objects[o].removed) free[kind(before_.objects[o])].push_back(static_cast<ObjectId>(o));
        std::vector<GroupId> free_groups;
        for (std::size_t g = before_.groups.size(); g-- > 0;)
            if (before_.groups[g].objects.empty()) free_groups.push_back(static_cast<GroupId>(g));

        for (std::size_t i = 0; i < wanted_.objects.size(); ++i) {
            if (number_[i] != none) continue;
            Object object = wanted_.objects[i];
            object.mesh = made_->nodes[object.node].mesh;
            if (object.group != none) {
                GroupId& group = group_of_[object.group];
                if (group == none) {
                    if (free_groups.empty()) {
                        free_groups.push_back(static_cast<GroupId>(made_->groups.size()));
                        made_->groups.emplace_back();
                    }
                    group = free_groups.back();
                    free_groups.pop_back();
                    made_->groups[group].anchor = wanted_.groups[object.group].anchor;
                }
                object.group = group;
            }
            std::vector<ObjectId>& same_kind = free[kind(object)];
            if (same_kind.empty()) {
                number_[i] = static_cast<ObjectId>(made_->objects.size());
                made_->objects.push_back(object);
            } else {
                number_[i] = same_kind.back();
                same_kind.pop_back();
                made_->objects[number_[i]] = object;
            }
            if (object.group != none) made_->groups[object.group].objects.push_back(number_[i]);
            result_.added.push_back(number_[i]);
        }
        std::sort(result_.added.begin(), result_.added.end());
    }

    bool too_much_is_gone() const
    {
        std::size_t gone = 0;
        std::uint64_t of_objects = 0, there = 0, kept = 0;
        for (const Object& object : made_->objects) {
            gone += object.removed;
            of_objects += made_->meshes[object.mesh].triangles.size();
        }
        for (std::size_t m = 0; m < made_->meshes.size(); ++m)
            (m >= is_there_.size() || is_there_[m] ? there : kept) += made_->meshes[m].triangles.size();
        return gone > k_removed_at_least + k_removed_per_object * (made_->objects.size() - gone) ||
               of_objects > k_most_triangles || kept > there + k_removed_triangles;
    }

    const Scene &before_, &wanted_;
    std::shared_ptr<Scene> made_;
    Continuation result_;
    std::vector<char> same_;          // by wanted node
    std::vector<char> is_there_;      // by mesh before: the wanted scene has it, used or not
    std::vector<ObjectId> number_;    // by wanted object: its number; none: not known yet
    std::vector<char> taken_;         // by object before: it stays
    std::vector<GroupId> group_of_;   // by wanted group: its number; none: not known yet
};

}   // namespace

std::optional<Continuation> continuation(const Scene& before, const Scene& wanted)
{
    return Numbering(before, wanted).make();
}

}   // namespace gnomon::scene
