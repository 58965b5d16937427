// SPDX-License-Identifier: Apache-2.0
// AFF: materials, textures and geometry.
#include <fmt/format.h>

#include "gnomon/error.h"
#include "io/aff_import.h"
#include "io/image_file.h"
#include "io/read_file.h"

namespace gnomon::io {

namespace {

constexpr double k_no_index = 0.01;   // the data writes an index of refraction of 0 for opaque materials: read as 1

glm::vec3 unit(const glm::dvec3& v)
{
    const double length = glm::length(v);
    return length > 0 ? glm::vec3(v / length) : glm::vec3(0);
}

glm::vec2 read_uv(AffText& text)
{
    const double u = text.number("texture coordinate"), v = text.number("texture coordinate");
    return {static_cast<float>(u), static_cast<float>(v)};
}

}   // namespace

// --- Materials

void AffImport::read_nff_material(AffText& text)
{
    const glm::dvec3 color = text.vector("colour");
    const double kd = text.number("diffuse part"), ks = text.number("specular part");
    scene::Material m;
    m.model = scene::ShadingModel::whitted;
    m.base_color = glm::vec3(color * kd);
    m.specular = glm::vec3(static_cast<float>(ks));   // the tint of the highlight is left open: white
    m.shine = static_cast<float>(text.number("shine"));
    m.transmittance = static_cast<float>(text.number("transmittance"));
    const double ior = text.number("index of refraction");
    m.ior = static_cast<float>(ior < k_no_index ? 1 : ior);
    material_ = m;
}

void AffImport::read_material(AffText& text)
{
    scene::Material m;
    m.model = scene::ShadingModel::whitted;
    m.ambient = glm::vec3(text.vector("ambient colour"));
    m.base_color = glm::vec3(text.vector("diffuse colour"));
    m.specular = glm::vec3(text.vector("specular colour"));
    m.shine = static_cast<float>(text.number("shine"));
    m.transmittance = static_cast<float>(text.number("transmittance"));
    const double ior = text.number("index of refraction");
    m.ior = static_cast<float>(ior < k_no_index ? 1 : ior);
    material_ = m;
}

// The current material, with a texture or without; equal ones are kept once.
scene::MaterialId AffImport::material(AffText& text, scene::TextureId texture)
{
    if (!material_) {
        warn(fmt::format("{}: geometry before any material is grey", text.shown_as()));
        material_.emplace();
        material_->model = scene::ShadingModel::whitted;
        material_->base_color = material_->ambient = glm::vec3(0.5f);
        material_->ior = 1;
    }
    scene::Material m = *material_;
    m.base_color_texture.texture = texture;
    const std::string key = fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {}", m.ambient.x, m.ambient.y, m.ambient.z,
                                        m.base_color.x, m.base_color.y, m.base_color.z, m.specular.x, m.specular.y,
                                        m.specular.z, m.shine, m.transmittance, m.ior, texture);
    const auto [at, fresh] = materials_.try_emplace(key, static_cast<scene::MaterialId>(scene_.materials.size()));
    if (fresh) scene_.materials.push_back(m);
    return at->second;
}

scene::TextureId AffImport::texture(AffText& text, const std::string& name)
{
    if (const auto known = textures_.find(name); known != textures_.end()) return known->second;
    if (name.find_first_of("/\\") != std::string::npos || name == "." || name == "..")
        text.fail(fmt::format("the name of a texture has no path: '{}'", name));
    if (texture_folder_.empty())
        text.fail(fmt::format("no folder TextureFiles beside the scene's for texture '{}'", name));
    std::string why;
    const auto file = resolve_inside(texture_folder_, name, {texture_folder_}, why);
    if (file.empty()) text.fail(fmt::format("texture '{}' {}", name, why));
    const std::vector<std::uint8_t> bytes = read_whole_file(file, name);
    const Image8 image = decode_image(bytes, file.string());
    texture_bytes_ += 4 * image.data.size() / static_cast<std::size_t>(image.channels);
    if (texture_bytes_ > limits_.texture_bytes) text.fail("textures add up to more than is allowed");
    const auto id = static_cast<scene::TextureId>(scene_.textures.size());
    scene_.textures.emplace_back(name, image, true, scene::Sampler{});
    textures_[name] = id;
    return id;
}

// --- Geometry

void AffImport::add_mesh(scene::Mesh mesh, scene::NodeId parent)
{
    const scene::NodeId node = scene_.add_node("", parent);
    scene_.nodes[node].mesh = static_cast<scene::MeshId>(scene_.meshes.size());
    scene_.meshes.push_back(std::move(mesh));
}

AffMeshBuilder& AffImport::loose(scene::MaterialId m, bool normals, bool uvs)
{
    if (!loose_ || loose_->parent != open_node() || loose_->material != m || loose_->normals != normals ||
        loose_->uvs != uvs) {
        flush_loose();
        loose_.emplace(Loose{open_node(), m, normals, uvs, AffMeshBuilder(normals, uvs)});
    }
    return loose_->builder;
}

void AffImport::flush_loose()
{
    if (loose_ && loose_->builder.triangles() > 0) add_mesh(loose_->builder.take(loose_->material), loose_->parent);
    loose_.reset();
}

void AffImport::flush_animated()
{
    if (animated_) {
        scene::Mesh& mesh = animated_->mesh;
        mesh.parts = {{animated_->material, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
        mesh.positions = mesh.vertex_keys->positions.front();
        mesh.normals = mesh.vertex_keys->normals.front();
        add_mesh(std::move(mesh), animated_->parent);
    }
    animated_.reset();
}

void AffImport::flush()
{
    flush_loose();
    flush_animated();
}

void AffImport::read_sphere(AffText& text)
{
    const glm::dvec3 centre = text.vector("centre");
    const double radius = text.number("radius");
    flush();
    scene::Mesh mesh = aff_sphere(centre, radius, fineness_);
    mesh.parts = {{material(text), 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    add_mesh(std::move(mesh), open_node());
}

void AffImport::read_cone(AffText& text)
{
    const glm::dvec3 base = text.vector("base");
    const double base_radius = text.number("radius");
    const glm::dvec3 apex = text.vector("apex");
    const double apex_radius = text.number("radius");
    flush();
    scene::Mesh mesh = aff_cone(base, base_radius, apex, apex_radius, fineness_);
    mesh.parts = {{material(text), 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    add_mesh(std::move(mesh), open_node());
}

void AffImport::read_polygon(AffText& text, bool normals)
{
    const std::size_t n = text.count("number of corners", 3, normals ? 12 : 6);
    std::vector<AffMeshBuilder::Corner> corners(n);
    for (auto& corner : corners) {
        corner.position = glm::vec3(text.vector("corner"));
        if (normals) corner.normal = unit(text.vector("normal"));
    }
    flush_animated();
    loose(material(text), normals, false).add_polygon(corners);
}

void AffImport::read_textured(AffText& text, bool normals)
{
    const scene::TextureId id = texture(text, text.name("the name of a texture"));
    AffMeshBuilder::Corner corner[3];
    for (auto& c : corner) {
        c.position = glm::vec3(text.vector("corner"));
        if (normals) c.normal = unit(text.vector("normal"));
        c.uv = read_uv(text);
    }
    flush_animated();
    loose(material(text, id), normals, true).add_triangle(corner);
}

void AffImport::read_animated_triangle(AffText& text)
{
    const std::size_t n = text.count("number of keys", 1, 38);
    scene::VertexKeys keys;
    keys.positions.resize(n);
    keys.normals.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        const double time = text.number("key time");
        if (k > 0 && !(time > keys.times.back())) text.fail("key times do not rise");
        keys.times.push_back(time);
        for (int c = 0; c < 3; ++c) {
            keys.positions[k].emplace_back(text.vector("corner"));
            keys.normals[k].push_back(unit(text.vector("normal")));
        }
    }
    flush_loose();
    // Triangles that follow each other and share their key times move in one mesh.
    const scene::MaterialId m = material(text);
    if (!animated_ || animated_->parent != open_node() || animated_->material != m ||
        animated_->mesh.vertex_keys->times != keys.times) {
        flush_animated();
        animated_.emplace(AnimatedTriangles{open_node(), m, {}});
        animated_->mesh.vertex_keys.emplace();
        animated_->mesh.vertex_keys->times = keys.times;
        animated_->mesh.vertex_keys->positions.resize(n);
        animated_->mesh.vertex_keys->normals.resize(n);
    }
    scene::VertexKeys& all = *animated_->mesh.vertex_keys;
    const auto first = static_cast<std::uint32_t>(all.positions[0].size());
    for (std::size_t k = 0; k < n; ++k) {
        all.positions[k].insert(all.positions[k].end(), keys.positions[k].begin(), keys.positions[k].end());
        all.normals[k].insert(all.normals[k].end(), keys.normals[k].begin(), keys.normals[k].end());
    }
    animated_->mesh.triangles.emplace_back(first, first + 1, first + 2);
}

void AffImport::read_mesh(AffText& text)
{
    text.expect("vertices");
    std::vector<glm::vec3> positions(text.count("number of vertices", 1, 6)), normals;
    for (glm::vec3& p : positions) p = glm::vec3(text.vector("vertex"));
    if (text.peek() == "normals") {
        text.next();
        normals.resize(text.count("number of normals", 1, 6));
        for (glm::vec3& n : normals) n = unit(text.vector("normal"));
    }
    std::vector<glm::vec2> uvs;
    scene::TextureId id = scene::none;
    if (text.peek() == "texturecoords") {
        text.next();
        uvs.resize(text.count("number of texture coordinates", 1, 4));
        id = texture(text, text.name("the name of a texture"));
        for (glm::vec2& uv : uvs) uv = read_uv(text);
    }
    text.expect("triangles");
    const int kinds = 1 + !normals.empty() + !uvs.empty();
    const std::size_t n = text.count("number of triangles", 0, static_cast<std::size_t>(6 * kinds));

    // A vertex of ours for every set of indices that occurs.
    struct Indices {
        std::uint32_t position, normal, uv;
        bool operator==(const Indices&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Indices& i) const
        {
            return (i.position * 0x9e3779b97f4a7c15ull) ^ (i.normal * 0xc2b2ae3d27d4eb4full) ^
                   (i.uv * 0x165667b19e3779f9ull);
        }
    };
    std::unordered_map<Indices, std::uint32_t, Hash> known;
    known.reserve(positions.size());
    scene::Mesh mesh;
    const auto read_index = [&](const char* what, std::size_t size) {
        return static_cast<std::uint32_t>(text.integer(what, 0, static_cast<long long>(size) - 1));
    };
    mesh.triangles.reserve(n);
    for (std::size_t t = 0; t < n; ++t) {
        Indices corner[3]{};
        for (Indices& c : corner) c.position = read_index("vertex index", positions.size());
        if (!normals.empty())
            for (Indices& c : corner) c.normal = read_index("normal index", normals.size());
        if (!uvs.empty())
            for (Indices& c : corner) c.uv = read_index("texture index", uvs.size());
        glm::uvec3 triangle;
        for (int c = 0; c < 3; ++c) {
            const auto [at, fresh] = known.try_emplace(corner[c], static_cast<std::uint32_t>(mesh.positions.size()));
            if (fresh) {
                mesh.positions.push_back(positions[corner[c].position]);
                if (!normals.empty()) mesh.normals.push_back(normals[corner[c].normal]);
                if (!uvs.empty()) mesh.texcoords[0].push_back(uvs[corner[c].uv]);
            }
            triangle[c] = at->second;
        }
        mesh.triangles.push_back(triangle);
    }
    flush();
    if (n == 0) return;
    mesh.parts = {{material(text, id), 0, static_cast<std::uint32_t>(n)}};
    add_mesh(std::move(mesh), open_node());
}

}   // namespace gnomon::io
