// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/gltf/check.h"

namespace gnomon::io::gltf {

namespace {

// The extensions that the importer supports; a file that requires any other is rejected.
constexpr std::array k_supported = {"KHR_lights_punctual",
                                    "KHR_texture_transform",
                                    "KHR_mesh_quantization",
                                    "KHR_materials_unlit",
                                    "KHR_materials_ior",
                                    "KHR_materials_transmission",
                                    "KHR_materials_emissive_strength",
                                    "KHR_materials_specular",
                                    "KHR_materials_clearcoat",
                                    "KHR_materials_sheen",
                                    "KHR_materials_anisotropy",
                                    "KHR_materials_iridescence",
                                    "KHR_materials_volume",
                                    "KHR_materials_dispersion",
                                    "KHR_materials_pbrSpecularGlossiness",
                                    "KHR_materials_variants",
                                    "EXT_mesh_gpu_instancing",
                                    "KHR_node_visibility",
                                    "KHR_animation_pointer",
                                    "KHR_draco_mesh_compression",
                                    "EXT_texture_webp",
                                    "EXT_meshopt_compression"};

bool supported(const std::string& name)
{
    return std::find(k_supported.begin(), k_supported.end(), name) != k_supported.end();
}

constexpr const char* k_basisu = "KHR_texture_basisu";

// Whether every texture that is compressed with Basis Universal has another image beside it.
bool has_fallbacks(const Model& model)
{
    const auto compressed = [](const Texture& t) { return t.compressed; };
    return std::any_of(model.textures.begin(), model.textures.end(), compressed) &&
           std::none_of(model.textures.begin(), model.textures.end(),
                        [&](const Texture& t) { return t.compressed && t.source == k_absent; });
}

// The smallest and largest number that a component can hold.
std::pair<double, double> range_of(Component type)
{
    switch (type) {
        case Component::i8:
            return {-128, 127};
        case Component::u8:
            return {0, 255};
        case Component::i16:
            return {-32768, 32767};
        case Component::u16:
            return {0, 65535};
        case Component::u32:
            return {0, 4294967295.0};
        default:
            return {-std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
    }
}

void check_bounds(const Accessor& accessor, const std::vector<double>& bounds, const std::string& pointer,
                  const Context& context)
{
    if (bounds.empty()) return;
    if (bounds.size() != static_cast<std::size_t>(accessor.components()))
        context.fail(pointer, fmt::format("expected {} elements, found {}", accessor.components(), bounds.size()));
    const auto [low, high] = range_of(accessor.component);
    for (std::size_t i = 0; i < bounds.size(); ++i) {
        const bool whole = accessor.component == Component::f32 || bounds[i] == std::floor(bounds[i]);
        if (!whole || bounds[i] < low || bounds[i] > high)
            context.fail(at(pointer, i), fmt::format("{} is not a value of the accessor's component type", bounds[i]));
    }
}

class Layout {
 public:
    Layout(const Model& model, Context& context) : model_(model), context_(context) {}

    void check_view(Index i) const
    {
        const BufferView& view = model_.views[i];
        const std::string here = at("/bufferViews", i);
        const std::uint64_t length = model_.buffers[view.buffer].length;
        if (view.offset >= length)
            fail(at(here, "byteOffset"),
                 fmt::format("{} lies beyond buffer {} of {} bytes", view.offset, view.buffer, length));
        if (view.length > length - view.offset)
            fail(at(here, "byteLength"), fmt::format("{} bytes from {} on do not fit buffer {} of {} bytes",
                                                     view.length, view.offset, view.buffer, length));
        if (view.stride == 0) return;
        const std::string stride = at(here, "byteStride");
        if (view.stride > view.length) fail(stride, fmt::format("{} is greater than the view's length", view.stride));
        if (view.stride % 4 != 0)
            context_.repair(Fault::alignment, stride,
                            [&] { return fmt::format("{} is not a multiple of 4", view.stride); });
        constexpr int element_array_buffer = 34963;
        if (view.target == element_array_buffer)
            context_.repair(Fault::stride, stride, [] { return "only vertex data can have a stride"; });
    }

    void check_accessor(Index i) const
    {
        const Accessor& accessor = model_.accessors[i];
        const std::string here = at("/accessors", i);
        if (!accessor.known()) return;   // an error is reported where it is used
        const std::uint64_t size = accessor.component_bytes();
        if (accessor.normalized && (accessor.component == Component::f32 || accessor.component == Component::u32))
            fail(at(here, "normalized"), "only byte and short types can be normalized");
        if (accessor.offset % size != 0)
            context_.repair(Fault::alignment, at(here, "byteOffset"), [&] {
                return fmt::format("{} is not a multiple of the component's {} bytes", accessor.offset, size);
            });
        if (accessor.shape >= Shape::mat2 && accessor.offset % 4 != 0)
            context_.repair(Fault::alignment, at(here, "byteOffset"),
                            [] { return "matrices must begin at multiples of 4"; });
        check_bounds(accessor, accessor.min, at(here, "min"), context_);
        check_bounds(accessor, accessor.max, at(here, "max"), context_);

        if (accessor.view != k_absent) {
            const std::uint64_t stride = model_.views[accessor.view].stride;
            if (stride != 0 && stride < accessor.element_bytes())
                fail(here, fmt::format("the view's stride {} is less than the element's {} bytes", stride,
                                       accessor.element_bytes()));
            // The sums are exact because offsets and lengths are below 2^53; the count is compared by division to avoid
            // overflow.
            check_fit(accessor.view, accessor.offset, accessor.count, stride ? stride : accessor.packed_stride(),
                      accessor.element_bytes(), size, here, at(here, "byteOffset"));
        }
        if (!accessor.sparse) return;
        const Sparse& sparse = *accessor.sparse;
        const std::string place = at(here, "sparse");
        if (sparse.count > accessor.count)
            fail(at(place, "count"),
                 fmt::format("overrides {} elements, but the accessor has {}", sparse.count, accessor.count));
        if (sparse.index_type == Component::unknown)
            fail(at(at(place, "indices"), "componentType"), "must be an unsigned integer type");
        const std::uint64_t index_size = sparse.index_type == Component::u8    ? 1
                                         : sparse.index_type == Component::u16 ? 2
                                                                               : 4;
        check_sparse_part(sparse.index_view, sparse.index_offset, sparse.count, index_size, index_size,
                          at(place, "indices"));
        check_sparse_part(sparse.value_view, sparse.value_offset, sparse.count, accessor.packed_stride(), size,
                          at(place, "values"));
    }

 private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const
    {
        context_.fail(pointer, problem);
    }

    void check_sparse_part(Index view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                           std::uint64_t alignment, const std::string& here) const
    {
        if (model_.views[view].stride != 0) fail(at(here, "bufferView"), "only vertex data can have a stride");
        if (offset % alignment != 0)
            context_.repair(Fault::alignment, at(here, "byteOffset"),
                            [&] { return fmt::format("{} is not a multiple of {} bytes", offset, alignment); });
        check_fit(view, offset, count, stride, stride, alignment, here, at(here, "byteOffset"));
    }

    // Checks that `count` elements, `stride` apart, the last one `element` bytes long, fit in the view from offset on.
    void check_fit(Index index, std::uint64_t offset, std::uint64_t count, std::uint64_t stride, std::uint64_t element,
                   std::uint64_t alignment, const std::string& here, const std::string& offset_place) const
    {
        const BufferView& view = model_.views[index];
        if (offset >= view.length || element > view.length - offset)
            fail(offset != 0 ? offset_place : here,
                 fmt::format("offset {} leaves no room for an element in buffer view {} of {} bytes", offset, index,
                             view.length));
        if ((count - 1) > (view.length - offset - element) / stride)
            fail(offset != 0 ? offset_place : here,
                 fmt::format("{} elements from {} on do not fit buffer view {} of {} bytes", count, offset, index,
                             view.length));
        if ((view.offset + offset) % alignment != 0)
            context_.repair(Fault::alignment, here, [&] {
                return fmt::format("begins at byte {} of the buffer, which is not a multiple of {}",
                                   view.offset + offset, alignment);
            });
    }

    const Model& model_;
    Context& context_;
};

std::pair<int, int> version_of(const std::string& text)
{
    const auto dot = text.find('.');
    return {std::stoi(text.substr(0, dot)), std::stoi(text.substr(dot + 1))};
}

}   // namespace

void check_extensions(const Model& model, Context& context)
{
    const auto [major, minor] = version_of(model.version);
    if (major != 2) context.fail("/asset/version", fmt::format("glTF {} is not supported, only 2.x", model.version));
    if (minor != 0) context.warn("/asset/version", fmt::format("glTF {} is read as 2.0", model.version));
    if (!model.min_version.empty() && version_of(model.min_version) > version_of(model.version))
        context.fail("/asset/minVersion",
                     fmt::format("{} is greater than the version {}", model.min_version, model.version));

    for (std::size_t i = 0; i < model.extensions_required.size(); ++i) {
        const std::string& name = model.extensions_required[i];
        const auto& used = model.extensions_used;
        if (std::find(used.begin(), used.end(), name) == used.end())
            context.repair(Fault::extension_list, at("/extensionsRequired", i),
                           [&] { return fmt::format("'{}' is required but not used", name.substr(0, 80)); });
        if (name == k_basisu && has_fallbacks(model)) continue;
        if (name == k_basisu)
            context.fail(at("/extensionsRequired", i),
                         "needs the extension 'KHR_texture_basisu', which is not supported: export the file with PNG, "
                         "JPEG or WebP textures, or convert it, for example with 'gltf-transform ktxdecompress'");
        if (!supported(name))
            context.fail(at("/extensionsRequired", i),
                         fmt::format("needs the extension '{}', which is not supported", name.substr(0, 80)));
    }
    for (std::size_t i = 0; i < model.extensions_used.size(); ++i) {
        const std::string& name = model.extensions_used[i];
        if (!supported(name) && !(name == k_basisu && has_fallbacks(model)))
            context.warn(at("/extensionsUsed", i), fmt::format("the extension '{}' is ignored", name.substr(0, 80)));
        const auto& required = model.extensions_required;
        if (name == "KHR_mesh_quantization" && std::find(required.begin(), required.end(), name) == required.end())
            context.repair(Fault::extension_list, at("/extensionsUsed", i),
                           [] { return "'KHR_mesh_quantization' must be required where it is used"; });
    }
}

void check_layout(const Model& model, Context& context)
{
    const Layout layout(model, context);
    for (Index i = 0; i < model.views.size(); ++i) layout.check_view(i);
    for (Index i = 0; i < model.accessors.size(); ++i) layout.check_accessor(i);
}

}   // namespace gnomon::io::gltf
