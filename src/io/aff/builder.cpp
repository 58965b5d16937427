// SPDX-License-Identifier: Apache-2.0
#include "io/aff/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "base/check.h"
#include "io/aff/mesh.h"
#include "io/image/image_file.h"
#include "scene/file_surfaces.h"

namespace gnomon::io {

using scene::none;

namespace {

constexpr std::size_t k_names_in_a_warning = 5, k_longest_name = 80;

// The material of geometry before the first material statement.
scene::Material grey()
{
    scene::Material material;
    material.model = scene::ShadingModel::whitted;
    material.base_color = material.ambient = glm::vec3(0.5f);
    material.ior = 1;
    return material;
}

}   // namespace

std::string AffBuilder::limit_exceeded() const
{
    if (triangles_ > limits_.max_triangles) return fmt::format("more than {} triangles", limits_.max_triangles);
    if (shape_triangles_ > limits_.max_shape_triangles)
        return fmt::format("more than {} triangles in cones", limits_.max_shape_triangles);
    if (scene_.nodes.size() > limits_.max_nodes) return fmt::format("more than {} nodes", limits_.max_nodes);
    if (deepest_ > limits_.max_nesting)
        return fmt::format("transforms are nested more than {} deep", limits_.max_nesting);
    if (!(largest_scale_ <= limits_.max_scale)) return "the scale of nested transforms is too large";
    return {};
}

// --- Materials

void AffBuilder::set_material(const scene::Material& m)
{
    // Merge equal materials, because files repeat them for every part.
    const std::array<float, 12> values{m.ambient.x,    m.ambient.y,    m.ambient.z,     m.base_color.x,
                                       m.base_color.y, m.base_color.z, m.specular.x,    m.specular.y,
                                       m.specular.z,   m.shine,        m.transmittance, m.ior};
    const auto [place, is_new] = plain_by_values_.try_emplace(values, static_cast<std::uint32_t>(plain_.size()));
    if (is_new) plain_.push_back(m);
    current_ = place->second;
}

std::uint32_t AffBuilder::current_material()
{
    if (current_ == none) {
        scene_.warnings.emplace_back("geometry before the first material is drawn in grey");
        set_material(grey());
    }
    return current_;
}

scene::TextureId AffBuilder::add_texture(const std::string& name, std::span<const std::uint8_t> file,
                                         const std::string& shown_as)
{
    const ImageNeeds needs = image_needs(file, shown_as);
    const scene::MemoryBudget::Expected expected = memory_.expect(needs.width, needs.height);
    memory_.make_room(needs.bytes + file.size(), scene_.textures, {shown_as, "", "the texture"});
    const auto id = static_cast<scene::TextureId>(scene_.textures.size());
    scene_.textures.push_back(memory_.make(expected, name, decode_image(file, shown_as), true, scene::Sampler{}));
    memory_.made(expected, id);
    return id;
}

scene::MaterialId AffBuilder::material(scene::TextureId texture)
{
    const auto [place, is_new] =
        materials_.try_emplace({current_material(), texture}, static_cast<scene::MaterialId>(scene_.materials.size()));
    if (is_new) {
        scene::Material material = plain_[current_];
        material.name = fmt::format("material {}", scene_.materials.size() + 1);
        material.base_color_texture.texture = texture;
        scene_.materials.push_back(std::move(material));
    }
    return place->second;
}

// --- Transforms

void AffBuilder::open(std::string name, const glm::dmat4& matrix, double largest_scale)
{
    const double scale = (open_.empty() ? 1 : open_.back().scale) * largest_scale;
    largest_scale_ = std::max(largest_scale_, scale);
    open_.push_back({scene_.add_node(std::move(name), parent(), matrix), scale});
    deepest_ = std::max(deepest_, open_.size());
}

void AffBuilder::open_static(const glm::dmat4& shape, double largest_scale)
{
    open({}, shape, largest_scale);
}

void AffBuilder::open_animated(const std::string& name)
{
    open(utf8_from_latin1(name), glm::dmat4(1), 1);
    scene_.nodes.back().animated = true;
    animated_.push_back({open_.back().node, name});
}

void AffBuilder::close()
{
    GNOMON_CHECK(!open_.empty());
    open_.pop_back();
}

// --- Geometry

scene::MeshId AffBuilder::add_mesh(scene::Mesh mesh, scene::TextureId texture)
{
    mesh.parts = {{material(texture), 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    scene_.meshes.push_back(std::move(mesh));
    return static_cast<scene::MeshId>(scene_.meshes.size() - 1);
}

void AffBuilder::add_instance(scene::MeshId mesh)
{
    scene::NodeId node = parent();
    if (node == none || scene_.nodes[node].mesh != none) node = scene_.add_node(scene_.meshes[mesh].name, node);
    scene_.nodes[node].mesh = mesh;
    triangles_ += scene_.meshes[mesh].triangles.size();
}

AffBuilder::Run& AffBuilder::run_of(scene::MaterialId id, bool normals, bool texcoords,
                                    const std::vector<double>& times)
{
    if (run_ &&
        (run_->material != id || run_->normals != normals || run_->texcoords != texcoords || run_->times != times))
        flush();
    if (!run_) {
        run_ = Run();
        run_->material = id, run_->normals = normals, run_->texcoords = texcoords, run_->times = times;
        if (!times.empty()) {
            run_->mesh.vertex_keys.emplace();
            run_->mesh.vertex_keys->times = times;
            run_->mesh.vertex_keys->positions.resize(times.size());
            run_->mesh.vertex_keys->normals.resize(times.size());
        }
    }
    return *run_;
}

void AffBuilder::add_polygon(const std::vector<AffCorner>& corners, scene::TextureId texture, bool with_normals)
{
    GNOMON_CHECK_LE(3u, corners.size());
    scene::Mesh& mesh = run_of(material(texture), with_normals, texture != none, {}).mesh;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const AffCorner& corner : corners) {
        mesh.positions.push_back(corner.position);
        if (with_normals)
            mesh.normals.push_back(
                usable_normal(corner.normal, corners[0].position, corners[1].position, corners[2].position));
        if (texture != none) mesh.texcoords[0].push_back(corner.texcoord);
    }
    for (std::uint32_t i = 2; i < corners.size(); ++i) mesh.triangles.emplace_back(first, first + i - 1, first + i);
}

void AffBuilder::add_keyed_triangle(const std::vector<double>& times,
                                    const std::vector<std::array<AffCorner, 3>>& corners)
{
    scene::VertexKeys& keys = *run_of(material(none), true, false, times).mesh.vertex_keys;
    for (std::size_t k = 0; k < times.size(); ++k)
        for (const auto& [a, b, c] = corners[k]; const AffCorner& corner : corners[k]) {
            keys.positions[k].push_back(corner.position);
            keys.normals[k].push_back(usable_normal(corner.normal, a.position, b.position, c.position));
        }
    const auto first = static_cast<std::uint32_t>(keys.positions[0].size() - 3);
    run_->mesh.triangles.emplace_back(first, first + 1, first + 2);
}

void AffBuilder::flush()
{
    if (!run_) return;
    scene::Mesh mesh = std::move(run_->mesh);
    const scene::MaterialId id = run_->material;
    run_.reset();
    mesh.name = "triangles";
    if (mesh.vertex_keys) mesh.positions = mesh.vertex_keys->positions[0], mesh.normals = mesh.vertex_keys->normals[0];
    mesh.parts = {{id, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    scene_.meshes.push_back(std::move(mesh));
    add_instance(static_cast<scene::MeshId>(scene_.meshes.size() - 1));
}

void AffBuilder::add_sphere(const glm::dvec3& centre, double radius, bool inside)
{
    // All spheres with the same material share one mesh.
    const auto [place, is_new] = spheres_.try_emplace({material(none), inside}, none);
    if (is_new) {
        scene::Mesh mesh = make_unit_sphere(shapes_, inside);
        mesh.name = "sphere";
        place->second = add_mesh(std::move(mesh), none);
    }
    // Thousands in one place are a mistake or an attack, and nobody sees more than one.
    if (++in_place_[{place->second, parent(), {centre.x, centre.y, centre.z, radius}}] > scene::k_most_in_place) {
        ++repeats_;
        return;
    }
    glm::dmat4 matrix(radius);
    matrix[3] = glm::dvec4(centre, 1);
    const scene::NodeId node = scene_.add_node("sphere", parent(), matrix);
    scene_.nodes[node].mesh = place->second;
    triangles_ += scene_.meshes[place->second].triangles.size();
}

void AffBuilder::add_cone(const glm::dvec3& base, double base_radius, const glm::dvec3& apex, double apex_radius,
                          bool inside)
{
    scene::Mesh mesh = make_cone(shapes_, base, base_radius, apex, apex_radius, inside);
    mesh.name = "cone";
    shape_triangles_ += mesh.triangles.size();
    add_instance(add_mesh(std::move(mesh), none));
}

// --- Lights, camera, tracks

void AffBuilder::add_light(const glm::dvec3& position, const glm::vec3& color, const std::string& track_name)
{
    // DEVIATION(BART AFF, `la`): the format leaves open whether a light's track replaces its position or adds to it; it
    // adds. Lights are placed in the open transforms, like geometry.
    scene::NodeId moving = parent();
    if (!track_name.empty()) {
        moving = scene_.add_node(utf8_from_latin1(track_name), moving);
        animated_lights_.push_back({moving, track_name});
    }
    scene::Light light;
    light.name = track_name.empty() ? fmt::format("light {}", scene_.lights.size()) : utf8_from_latin1(track_name);
    light.type = scene::LightType::point;
    light.falloff = scene::Falloff::constant;
    light.color = color;
    light.node = scene_.add_node(light.name, moving, scene::TransformParts{position}.matrix());
    scene_.lights.push_back(light);
}

void AffBuilder::set_camera(const scene::Camera& camera, const scene::TransformParts& place)
{
    camera_ = camera;
    camera_place_ = place;
}

void AffBuilder::place_tracks()
{
    std::vector<std::string> without;   // each name once
    std::unordered_set<std::string_view> seen;
    for (const auto& [node, name] : animated_) {
        const auto found = tracks_.find(name);
        if (found == tracks_.end()) {
            if (seen.insert(name).second) without.push_back(name);
            continue;
        }
        scene_.nodes[node].transform = found->second.transform;
        scene_.nodes[node].visibility = found->second.visibility;
    }
    if (!without.empty()) {
        const std::size_t named = std::min(without.size(), k_names_in_a_warning);
        std::string names;
        for (std::size_t i = 0; i < named; ++i)
            names += (i ? ", " : "") + utf8_from_latin1(without[i].substr(0, k_longest_name));
        scene_.warnings.push_back(fmt::format("animated transforms without keys do not move: {}{}", names,
                                              named < without.size() ? ", ..." : ""));
    }
    for (const auto& [node, name] : animated_lights_) {
        const auto found = tracks_.find(name);
        if (found == tracks_.end()) continue;
        scene_.nodes[node].visibility = found->second.visibility;
        if (!found->second.transform || !found->second.transform->translation) continue;
        auto track = std::make_shared<scene::KochanekTrack>();
        track->translation = found->second.transform->translation;
        scene_.nodes[node].transform = std::move(track);
    }
}

void AffBuilder::place_camera()
{
    const auto found = tracks_.find("camera");
    const bool has_track = found != tracks_.end() && found->second.transform;
    if (!camera_ && !has_track) return;
    if (!camera_) {
        scene_.warnings.emplace_back("a camera track without a 'v': the default field of view is used");
        camera_.emplace();
    }
    camera_->name = "camera";
    camera_->node = scene_.add_node("camera", none, camera_place_.matrix());
    if (has_track) {
        // The track overrides `v` part by part: parts without keys keep the values of `v`.
        auto track = std::make_shared<scene::KochanekTrack>();
        track->translation = found->second.transform->translation;
        track->rotation = found->second.transform->rotation;
        track->rest = camera_place_;
        scene_.nodes[camera_->node].transform = std::move(track);
    }
    scene_.cameras.push_back(*camera_);
}

scene::Scene AffBuilder::finish()
{
    flush();
    if (repeats_ > 0)
        scene_.warnings.push_back(fmt::format("{} sphere{} where {} equal ones are already: left out", repeats_,
                                              repeats_ == 1 ? "" : "s", scene::k_most_in_place));
    place_tracks();
    place_camera();
    if (std::string halved = memory_.warning(scene_.textures); !halved.empty())
        scene_.warnings.push_back(std::move(halved));
    scene::leave_out_repeats(scene_);
    scene_.finish();
    return std::move(scene_);
}

}   // namespace gnomon::io
