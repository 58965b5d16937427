// SPDX-License-Identifier: Apache-2.0
#include "light_views/vulkan/caster_geometry.h"

#include <map>

namespace gnomon::light_views {

namespace {

// Appends the vertices of a mesh (or deforming object) to the shared buffers and returns their offset.
std::int32_t add_vertices(const scene::Mesh& mesh, const std::vector<glm::vec3>& positions, int texcoord,
                          std::vector<glm::vec3>& all_positions, std::vector<glm::vec2>& all_texcoords)
{
    const auto offset = static_cast<std::int32_t>(all_positions.size());
    all_positions.insert(all_positions.end(), positions.begin(), positions.end());
    const auto& uv = mesh.texcoords[texcoord];
    all_texcoords.insert(all_texcoords.end(), uv.begin(), uv.end());
    all_texcoords.resize(all_positions.size(), glm::vec2(0));
    return offset;
}

}   // namespace

CasterGeometry::CasterGeometry(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state)
    : scene_(state.shared_scene())
{
    // Gather the triangles that occlude light: opaque ones in one range, alpha-tested ones by material.
    std::map<scene::MaterialId, std::uint32_t> alpha_of;
    std::vector<int> texcoord_of;   // by mesh: the set of texture coordinates for its alpha tests
    for (const scene::Mesh& mesh : scene_->meshes) {
        MeshParts parts;
        int texcoord = 0;
        const auto add = [&](const scene::MeshPart& part) {
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
                for (int i = 0; i < 3; ++i) first_indices_.push_back(mesh.triangles[t][i]);
        };
        parts.opaque.first_index = static_cast<std::uint32_t>(first_indices_.size());
        for (const scene::MeshPart& part : mesh.parts)
            if (scene_->materials[part.material].surface_class() == scene::SurfaceClass::opaque) add(part);
        parts.opaque.index_count = static_cast<std::uint32_t>(first_indices_.size()) - parts.opaque.first_index;
        for (const scene::MeshPart& part : mesh.parts) {
            const scene::Material& material = scene_->materials[part.material];
            if (material.surface_class() != scene::SurfaceClass::masked || part.triangle_count == 0) continue;
            const auto [at, is_new] = alpha_of.try_emplace(part.material, 0);
            if (is_new) at->second = alpha_material(material, first_texels_, first_alpha_);
            texcoord = material.base_color_texture.texcoord;
            const auto first = static_cast<std::uint32_t>(first_indices_.size());
            add(part);
            parts.masked.push_back({first, static_cast<std::uint32_t>(first_indices_.size()) - first, at->second});
        }
        meshes_.push_back(std::move(parts));
        texcoord_of.push_back(texcoord);
    }

    // Add vertices: once per mesh, and once per deforming object.
    std::vector<std::int32_t> mesh_offset(scene_->meshes.size(), -1);
    vertex_offset_.assign(scene_->objects.size(), 0);
    for (std::size_t o = 0; o < scene_->objects.size(); ++o) {
        const scene::Object& object = scene_->objects[o];
        const scene::Mesh& mesh = scene_->meshes[object.mesh];
        if (object.deforming) {
            vertex_offset_[o] =
                add_vertices(mesh, mesh.positions, texcoord_of[object.mesh], first_positions_, first_texcoords_);
            continue;
        }
        std::int32_t& offset = mesh_offset[object.mesh];
        if (offset < 0)
            offset = add_vertices(mesh, mesh.positions, texcoord_of[object.mesh], first_positions_, first_texcoords_);
        vertex_offset_[o] = offset;
    }
    first_texels_.resize((first_texels_.size() + 3) / 4 * 4);

    const auto buffer = [&](const char* name, std::size_t bytes) {
        return vk::Buffer(device, name, std::max<std::size_t>(bytes, 4));
    };
    positions_ = buffer("caster positions", first_positions_.size() * sizeof(glm::vec3));
    texcoords_ = buffer("caster texcoords", first_texcoords_.size() * sizeof(glm::vec2));
    indices_ = buffer("caster indices", first_indices_.size() * sizeof(std::uint32_t));
    matrices_ = buffer("caster matrices", scene_->objects.size() * sizeof(glm::mat4));
    offsets_ = buffer("caster vertex offsets", vertex_offset_.size() * sizeof(std::int32_t));
    alpha_materials_ =
        buffer("alpha materials", std::max<std::size_t>(first_alpha_.size(), 1) * sizeof(shared::AlphaMaterial));
    alpha_texels_ = buffer("alpha texels", first_texels_.size());
}

// Copies a material's alpha channel and returns its record's index.
std::uint32_t CasterGeometry::alpha_material(const scene::Material& material, std::vector<std::uint8_t>& texels,
                                             std::vector<shared::AlphaMaterial>& records) const
{
    shared::AlphaMaterial record{};
    record.first_byte = scene::none;
    record.alpha = material.alpha;
    record.cutoff = material.alpha_cutoff;
    const scene::TextureUse& use = material.base_color_texture;
    if (use.used() && scene_->textures[use.texture].has_alpha()) {
        const scene::Texture& texture = scene_->textures[use.texture];
        const Image8& level = texture.levels().front();
        record.first_byte = static_cast<std::uint32_t>(texels.size());
        record.width = static_cast<std::uint32_t>(texture.width());
        record.height = static_cast<std::uint32_t>(texture.height());
        record.wrap_u = static_cast<std::uint32_t>(texture.sampler().wrap_u);
        record.wrap_v = static_cast<std::uint32_t>(texture.sampler().wrap_v);
        record.nearest = texture.sampler().magnify == scene::Filter::nearest;
        for (int y = 0; y < texture.height(); ++y)
            for (int x = 0; x < texture.width(); ++x) texels.push_back(level.pixel(x, y)[3]);
        // apply() is affine, so its values at the origin and the axes determine it.
        record.offset = use.apply({0, 0});
        const glm::vec2 u = use.apply({1, 0}) - record.offset, v = use.apply({0, 1}) - record.offset;
        record.row_u = {u.x, v.x};
        record.row_v = {u.y, v.y};
    }
    records.push_back(record);
    return static_cast<std::uint32_t>(records.size() - 1);
}

void CasterGeometry::fill(vk::Commands& commands, const scene::SceneState& state)
{
    std::vector<glm::mat4> matrices;
    for (scene::ObjectId o = 0; o < scene_->objects.size(); ++o) {
        matrices.push_back(state.object_matrix(o));
        if (!scene_->objects[o].deforming) continue;
        const auto& positions = state.deformed(o).positions;
        std::copy(positions.begin(), positions.end(), first_positions_.begin() + vertex_offset_[o]);
    }
    std::vector<vk::Upload> uploads;
    const auto add = [&](const vk::Buffer& to, auto values) {
        if (!values.empty()) uploads.push_back(vk::upload_of(to, values));
    };
    add(positions_, std::span<const glm::vec3>(first_positions_));
    add(texcoords_, std::span<const glm::vec2>(first_texcoords_));
    add(indices_, std::span<const std::uint32_t>(first_indices_));
    add(matrices_, std::span<const glm::mat4>(matrices));
    add(offsets_, std::span<const std::int32_t>(vertex_offset_));
    add(alpha_materials_, std::span<const shared::AlphaMaterial>(first_alpha_));
    add(alpha_texels_, std::span<const std::uint8_t>(first_texels_));
    for (const vk::Upload& upload : uploads) uploaded_bytes_ += upload.bytes.size();
    if (!uploads.empty()) commands.upload("casters", uploads);
    first_positions_ = {}, first_texcoords_ = {}, first_indices_ = {}, first_alpha_ = {}, first_texels_ = {};
    filled_ = true;
}

void CasterGeometry::update(vk::Commands& commands, const scene::SceneState& state)
{
    uploaded_bytes_ = 0;
    if (!filled_) {
        fill(commands, state);
        return;
    }
    const scene::FrameChanges& changes = state.changes();
    std::vector<glm::mat4> matrices;
    matrices.reserve(changes.moved.size() +
                     changes.appeared.size());   // `uploads` has spans of it, so it must not reallocate
    std::vector<vk::Upload> uploads;
    for (const auto* list : {&changes.moved, &changes.appeared})
        for (const scene::ObjectId o : *list) {
            matrices.push_back(state.object_matrix(o));
            uploads.push_back(
                vk::upload_of(matrices_, std::span<const glm::mat4>(&matrices.back(), 1), o * sizeof(glm::mat4)));
        }
    for (const auto* list : {&changes.deformed, &changes.appeared})
        for (const scene::ObjectId o : *list) {
            if (!scene_->objects[o].deforming) continue;
            const std::span<const glm::vec3> positions = state.deformed(o).positions;
            uploads.push_back(
                vk::upload_of(positions_, positions, static_cast<std::size_t>(vertex_offset_[o]) * sizeof(glm::vec3)));
        }
    for (const vk::Upload& upload : uploads) uploaded_bytes_ += upload.bytes.size();
    if (!uploads.empty()) commands.upload("casters", uploads);
}

vk::Pass& CasterGeometry::declare_alpha(vk::Pass& pass) const
{
    for (const vk::Buffer* buffer : {&texcoords_, &indices_, &offsets_, &alpha_materials_, &alpha_texels_})
        pass.reads(*buffer, vk::Use::storage_read);
    return pass;
}

void CasterGeometry::bind_alpha(vk::Recorder& recorder) const
{
    recorder.set("CasterTexcoords", texcoords_);
    recorder.set("CasterIndices", indices_);
    recorder.set("CasterOffsets", offsets_);
    recorder.set("AlphaMaterials", alpha_materials_);
    recorder.set("AlphaTexels", alpha_texels_);
}

vk::Pass& CasterGeometry::declare(vk::Pass& pass) const
{
    for (const vk::Buffer* buffer : {&positions_, &texcoords_, &indices_}) pass.reads(*buffer, vk::Use::vertices);
    for (const vk::Buffer* buffer : {&matrices_, &alpha_materials_, &alpha_texels_})
        pass.reads(*buffer, vk::Use::storage_read);
    return pass;
}

void CasterGeometry::bind(vk::Recorder& recorder, bool alpha) const
{
    recorder.vertex_buffer(0, positions_);
    recorder.vertex_buffer(1, texcoords_);
    recorder.index_buffer(indices_);
    recorder.set("Matrices", matrices_);
    if (!alpha) return;
    recorder.set("AlphaMaterials", alpha_materials_);
    recorder.set("AlphaTexels", alpha_texels_);
}

}   // namespace gnomon::light_views
