// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/gltf/check.h"

namespace gnomon::io::gltf {

namespace {

// Slightly more than the error of storing components in one byte each, for the length of a vector or a sum of weights.
constexpr double k_unit_tolerance3 = 0.00674;
constexpr double k_unit_tolerance4 = 0.00769;
constexpr double k_sum_step = 0.0039216;

double restart_value(Component type)
{
    return type == Component::u8 ? 255 : type == Component::u16 ? 65535 : 4294967295.0;
}

// Checks the elements of one accessor in one pass.
class ElementCheck {
 public:
    ElementCheck(const Accessor& accessor, const AccessorUse& use, std::string here, Context& context)
        : accessor_(accessor), use_(use), here_(std::move(here)), context_(context)
    {
    }

    void element(std::uint64_t i, std::span<const double> v)
    {
        for (std::size_t c = 0; c < v.size(); ++c) {
            if (!std::isfinite(v[c])) {
                const auto problem = [&] { return fmt::format("element {} is not finite", i); };
                if (!use_.not_position) context_.fail(here_, problem());
                context_.repair(Fault::not_finite, use_.user, problem);
                return;
            }
            low_[c] = i == 0 ? v[c] : std::min(low_[c], v[c]);
            high_[c] = i == 0 ? v[c] : std::max(high_[c], v[c]);
        }
        if (use_.unit || use_.tangent) vector(i, v);
        if (use_.quaternion && (!use_.cubic || i % 3 == 1)) quaternion(i, v);
        if (use_.role == AccessorUse::Role::index) index(i, v[0]);
        if (use_.role == AccessorUse::Role::animation_input) key_time(i, v[0]);
        if (use_.role == AccessorUse::Role::inverse_bind) inverse_bind(i, v);
    }

    void finish() const
    {
        bounds(accessor_.min, low_, "min", "minimum");
        bounds(accessor_.max, high_, "max", "maximum");
    }

 private:
    [[noreturn]] void fail(const std::string& problem) const { context_.fail(use_.user, problem); }
    double value(double stored) const
    {
        return accessor_.normalized ? normalized_value(stored, accessor_.component) : stored;
    }

    void bounds(const std::vector<double>& declared, const double* actual, const char* name, const char* word) const
    {
        for (std::size_t c = 0; c < declared.size(); ++c) {
            const double d = accessor_.component == Component::f32
                                 ? static_cast<double>(static_cast<float>(declared[c]))
                                 : declared[c];
            if (d == actual[c]) continue;
            context_.repair(Fault::bounds, at(at(here_, name), c), [&] {
                return fmt::format("{} is declared, but the actual {} is {}", declared[c], word, actual[c]);
            });
            return;   // one repair for each list
        }
    }

    void vector(std::uint64_t i, std::span<const double> v)
    {
        const double x = value(v[0]), y = value(v[1]), z = value(v[2]);
        const double length = std::sqrt(x * x + y * y + z * z);
        const Fault fault = use_.tangent ? Fault::tangent_length : Fault::normal_length;
        if (!(std::abs(length - 1) <= k_unit_tolerance3))
            context_.repair(fault, use_.user,
                            [&] { return fmt::format("vector {} is not of unit length: {}", i, length); });
        else if (use_.tangent && std::abs(value(v[3])) != 1)
            context_.repair(fault, use_.user,
                            [&] { return fmt::format("tangent {} has w = {}, not 1 or -1", i, value(v[3])); });
    }

    void quaternion(std::uint64_t i, std::span<const double> v) const
    {
        double square = 0;
        for (const double c : v) square += value(c) * value(c);
        if (!(std::abs(std::sqrt(square) - 1) <= k_unit_tolerance4))
            context_.repair(Fault::rotation_length, use_.user, [&] {
                return fmt::format("quaternion {} is not of unit length: {}", i, std::sqrt(square));
            });
    }

    void index(std::uint64_t i, double v) const
    {
        if (v == restart_value(accessor_.component))
            fail(fmt::format("index {} is {}, which restarts primitives", i, v));
        if (use_.vertices > 0 && v >= static_cast<double>(use_.vertices))
            fail(fmt::format("index {} refers to vertex {}, but there are {}", i, v, use_.vertices));
    }

    void key_time(std::uint64_t i, double v)
    {
        if (v < 0)
            context_.repair(Fault::key_before_zero, use_.user,
                            [&] { return fmt::format("key {} has the negative time {}", i, v); });
        if (i > 0 && v <= time_)
            context_.repair(Fault::key_order, use_.user, [&] {
                return fmt::format("key {} has time {}, which is not greater than that of the previous key, {}", i, v,
                                   time_);
            });
        else
            time_ = v;
    }

    void inverse_bind(std::uint64_t i, std::span<const double> v)
    {
        if (v[3] == 0 && v[7] == 0 && v[11] == 0 && v[15] == 1) return;
        context_.repair(Fault::inverse_bind_row, use_.user,
                        [&] { return fmt::format("the last row of matrix {} is not 0 0 0 1", i); });
    }

    const Accessor& accessor_;
    const AccessorUse& use_;
    std::string here_;
    Context& context_;
    double low_[16] = {}, high_[16] = {};
    double time_ = 0;
};

void check_sparse(const Accessor& accessor, const Data& data, const std::string& here, const Context& context)
{
    const std::vector<std::uint32_t> indices = data.sparse_indices(accessor);
    const std::string place = at(here, "sparse");
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (i > 0 && indices[i] <= indices[i - 1])
            context.fail(place,
                         fmt::format("index {} is {}, which is not greater than the previous one", i, indices[i]));
        if (indices[i] >= accessor.count)
            context.fail(place,
                         fmt::format("index {} is {}, but there are {} elements", i, indices[i], accessor.count));
    }
}

// The joints that the current vertex already uses, over all its sets.
struct JointUses {
    std::vector<std::uint64_t>
        last;   // by joint: number of the last vertex that used it; vertices are numbered across primitives
    std::uint64_t vertex = 0;
};

// Checks joints and weights of one primitive, vertex by vertex.
void check_influences(const Model& model, const Data& data, const Primitive& primitive, std::size_t joint_count,
                      JointUses& joint_uses, const std::string& here, Context& context)
{
    std::vector<std::vector<std::uint32_t>> joints;
    std::vector<std::vector<float>> weights;
    for (int set = 0; primitive.has(fmt::format("JOINTS_{}", set).c_str()); ++set) {
        const Accessor& j = model.accessors[primitive.find(fmt::format("JOINTS_{}", set))];
        const Accessor& w = model.accessors[primitive.find(fmt::format("WEIGHTS_{}", set))];
        if (!data.has_bytes(j) || !data.has_bytes(w)) return;
        data.read(j, joints.emplace_back());
        data.read(w, weights.emplace_back());
    }
    const auto place = [&](const char* what, std::size_t set) { return at(here, fmt::format("{}_{}", what, set)); };
    const std::string weights_place = place("WEIGHTS", 0), joints_place = place("JOINTS", 0);
    const std::size_t vertices = joints.empty() ? 0 : joints[0].size() / 4;
    for (std::size_t v = 0; v < vertices; ++v) {
        ++joint_uses.vertex;
        std::size_t used = 0;
        double sum = 0;
        bool twice = false;
        for (std::size_t set = 0; set < joints.size(); ++set) {
            for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
                const std::uint32_t joint = joints[set][k];
                const float weight = weights[set][k];
                if (joint >= joint_count)
                    context.fail(place("JOINTS", set),
                                 fmt::format("vertex {} uses joint {}, but a skin has only {}", v, joint, joint_count));
                if (weight < 0)
                    context.fail(place("WEIGHTS", set), fmt::format("vertex {} has the negative weight {}", v, weight));
                if (weight == 0) continue;
                if (std::exchange(joint_uses.last[joint], joint_uses.vertex) == joint_uses.vertex && !twice) {
                    twice = true;
                    context.repair(Fault::joint_twice, joints_place,
                                   [&] { return fmt::format("vertex {} uses joint {} twice", v, joint); });
                }
                ++used;
                sum += weight;
            }
        }
        // DEVIATION(validator): one step of tolerance for one and two joints as well, because many exporters round.
        const std::size_t pairs = (used + 1) / 2;
        const double steps = std::max(1.0, static_cast<double>(pairs) - 1);
        if (!(std::abs(sum - 1) <= k_sum_step * steps))
            context.repair(Fault::weights_sum, weights_place,
                           [&] { return fmt::format("the weights of vertex {} sum to {}, not 1", v, sum); });
    }
}

}   // namespace

void check_data(const Model& model, const Data& data, const std::vector<AccessorUse>& uses, Context& context)
{
    // Bound the work before doing it.
    std::uint64_t left = context.limits.numbers + context.limits.numbers_per_byte * data.total_bytes();
    const auto spend = [&](const Accessor& accessor, const std::string& here) {
        const auto each = static_cast<std::uint64_t>(accessor.components());
        if (accessor.count > left / each)
            context.fail(here, "the accessors overlap so much that reading them would take too long");
        left -= accessor.count * each;
    };

    for (std::size_t i = 0; i < model.accessors.size(); ++i) {
        const Accessor& accessor = model.accessors[i];
        if (!data.has_bytes(accessor)) continue;
        const std::string here = at("/accessors", i);
        spend(accessor, here);
        if (accessor.sparse) check_sparse(accessor, data, here, context);
        ElementCheck check(accessor, uses[i], here, context);
        data.for_each(accessor, [&](std::uint64_t e, std::span<const double> v) { check.element(e, v); });
        check.finish();
    }

    // Use the number of joints of the smallest skin that each mesh is used with.
    std::vector<std::size_t> joints(model.meshes.size(), 0);
    for (const Node& node : model.nodes) {
        if (node.mesh == k_absent || node.skin == k_absent) continue;
        const std::size_t count = model.skins[node.skin].joints.size();
        joints[node.mesh] = joints[node.mesh] == 0 ? count : std::min(joints[node.mesh], count);
    }
    JointUses joint_uses;
    if (!joints.empty()) joint_uses.last.resize(*std::max_element(joints.begin(), joints.end()));
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        if (joints[m] == 0) continue;
        for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
            const Primitive& primitive = model.meshes[m].primitives[p];
            const std::string here = at(at(at(at("/meshes", m), "primitives"), p), "attributes");
            for (const auto& [name, index] : primitive.attributes)
                if ((name.rfind("JOINTS", 0) == 0 || name.rfind("WEIGHTS", 0) == 0) &&
                    data.has_bytes(model.accessors[index]))
                    spend(model.accessors[index], at(here, name));
            check_influences(model, data, primitive, joints[m], joint_uses, here, context);
        }
    }
}

}   // namespace gnomon::io::gltf
