// SPDX-License-Identifier: Apache-2.0
#include "trace/centre_layers.h"

#include <algorithm>

#include "base/check.h"
#include "base/morton.h"
#include "trace/hidden_surfaces.h"

namespace gnomon::trace {

namespace {

constexpr int k_side = 32;   // pixels a side of the blocks that are traced together; a power of two

// Returns where a point of an object's surface is, in world space.
glm::dvec3 surface_point(const scene::SceneState& state, scene::ObjectId id, std::uint32_t triangle, float u, float v)
{
    const scene::Object& object = state.scene().objects[id];
    const scene::Mesh& mesh = state.scene().meshes[object.mesh];
    const std::vector<glm::vec3>& positions = object.deforming ? state.deformed(id).positions : mesh.positions;
    const glm::uvec3 corner = mesh.triangles[triangle];
    const double b1 = static_cast<double>(u), b2 = static_cast<double>(v);
    const glm::dvec3 point = (1 - b1 - b2) * glm::dvec3(positions[corner.x]) + b1 * glm::dvec3(positions[corner.y]) +
                             b2 * glm::dvec3(positions[corner.z]);
    return object.skin != scene::none ? point : transform_point(state.world(object.node), point);
}

scene::MaterialId material_of(const scene::Scene& scene, scene::ObjectId object, std::uint32_t triangle)
{
    return scene.meshes[scene.objects[object].mesh].part_of(triangle).material;
}

// Returns the difference of two places in an image; 0 where one of them does not exist.
glm::dvec2 between(const std::optional<glm::dvec2>& before, const std::optional<glm::dvec2>& now)
{
    return before && now ? *now - *before : glm::dvec2(0);
}

void fit(auto& image, Size size, int channels)
{
    if (image.width == size.width && image.height == size.height && image.channels == channels) return;
    image = std::remove_reference_t<decltype(image)>(size.width, size.height, channels);
}

}   // namespace

// A square of pixels, and the memory for its rays.
struct CentreLayers::Block {
    int x = 0, y = 0;
    ray::RayQueue rays;
    std::vector<glm::ivec2> pixels;   // of the rays
    ray::Hits hits;
};

CentreLayers::CentreLayers(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                           const FrameBefore* before)
    : state_(state), rays_(rays), view_(view), before_(before), hides_surfaces_(hides_surfaces(state.scene()))
{
    if (before) GNOMON_CHECK_EQ(before->state->scene().objects.size(), state.scene().objects.size());
}

void CentreLayers::trace(bool ids, bool motion, Tasks& tasks, shading::FrameBuffers& out) const
{
    const Size size = view_.size;
    if (ids) fit(out.ids, size, 2);
    if (motion) fit(out.motion, size, 2);
    const int columns = (size.width + k_side - 1) / k_side, rows = (size.height + k_side - 1) / k_side;
    std::vector<Block> blocks(static_cast<std::size_t>(tasks.threads()));
    tasks.for_each(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows),
                   [&](std::size_t index, int worker) {
                       Block& block = blocks[static_cast<std::size_t>(worker)];
                       block.x = static_cast<int>(index) % columns * k_side;
                       block.y = static_cast<int>(index) / columns * k_side;
                       trace_block(block, ids, motion, out);
                   });
}

// Queues rays through the pixels' centres in Morton order, so that a packet covers neighbours, and traces them.
void CentreLayers::find_hits(Block& block) const
{
    block.rays.clear();
    block.rays.purpose = ray::RayClass::check;
    block.pixels.clear();
    for (std::uint32_t code = 0; code < k_side * k_side; ++code) {
        const glm::ivec2 pixel(block.x + static_cast<int>(even_bits(code)),
                               block.y + static_cast<int>(even_bits(code >> 1)));
        if (pixel.x >= view_.size.width || pixel.y >= view_.size.height) continue;
        glm::vec3 origin, direction;
        float tnear, tfar;
        view_.ray(static_cast<float>(pixel.x) + 0.5f, static_cast<float>(pixel.y) + 0.5f, origin, direction, tnear,
                  tfar);
        block.rays.push(origin, tnear, direction, tfar);
        block.pixels.push_back(pixel);
    }
    block.hits.resize(block.rays.size());
    rays_.closest(block.rays, 0, block.rays.size(), block.hits, ray::Sides::front);
    if (hides_surfaces_)
        pass_hidden_surfaces(
            state_.scene(), rays_, block.rays, [](std::size_t) { return true; }, block.hits);
}

// Stores what the rays of a block hit, and how it moved.
void CentreLayers::trace_block(Block& block, bool ids, bool motion, shading::FrameBuffers& out) const
{
    find_hits(block);
    const ray::Hits& hits = block.hits;
    for (std::size_t i = 0; i < block.pixels.size(); ++i) {
        const glm::ivec2 pixel = block.pixels[i];
        const scene::ObjectId object = hits.object[i];
        if (ids) {
            std::uint32_t* to = out.ids.pixel(pixel.x, pixel.y);
            to[0] = to[1] = 0;
            // A surface that catches shadows shows the background, and counts as it.
            const scene::MaterialId material =
                object == scene::none ? scene::none : material_of(state_.scene(), object, hits.triangle[i]);
            if (material != scene::none && !state_.scene().materials[material].catches_shadows) {
                to[0] = layer_id(state_.scene().objects[object].node);
                to[1] = layer_id(material);
            }
        }
        if (motion) {
            glm::dvec2 moved(0);
            if (before_)
                moved = object == scene::none ? background_motion(block.rays.direction(i))
                                              : surface_motion(object, hits.triangle[i], hits.u[i], hits.v[i]);
            float* to = out.motion.pixel(pixel.x, pixel.y);
            to[0] = static_cast<float>(moved.x), to[1] = static_cast<float>(moved.y);
        }
    }
}

// Projects the point as it is and as it was. Both come from the same formulas, so that what rests gives exactly 0. An
// object that was not there before counts as one that rests.
glm::dvec2 CentreLayers::surface_motion(scene::ObjectId object, std::uint32_t triangle, float u, float v) const
{
    const glm::dvec3 now = surface_point(state_, object, triangle, u, v);
    const glm::dvec3 before =
        before_->state->object_visible(object) ? surface_point(*before_->state, object, triangle, u, v) : now;
    return between(before_->view.project(before), view_.project(now));
}

// The background is infinitely far away, and moves by the view's rotation alone.
glm::dvec2 CentreLayers::background_motion(const glm::vec3& direction) const
{
    return between(before_->view.project_direction(direction), view_.project_direction(direction));
}

ViewHit CentreLayers::hit_at(const glm::ivec2& pixel) const
{
    GNOMON_CHECK(pixel.x >= 0 && pixel.y >= 0 && pixel.x < view_.size.width && pixel.y < view_.size.height);
    Block block;
    block.x = pixel.x / k_side * k_side, block.y = pixel.y / k_side * k_side;
    find_hits(block);
    const auto i =
        static_cast<std::size_t>(std::find(block.pixels.begin(), block.pixels.end(), pixel) - block.pixels.begin());
    ViewHit hit;
    hit.object = block.hits.object[i];
    if (hit.object == scene::none) return hit;
    hit.triangle = block.hits.triangle[i];
    hit.material = material_of(state_.scene(), hit.object, hit.triangle);
    if (state_.scene().materials[hit.material].catches_shadows) return {};
    hit.u = block.hits.u[i], hit.v = block.hits.v[i];
    hit.distance = block.hits.t[i];
    hit.direction = block.rays.direction(i);
    return hit;
}

}   // namespace gnomon::trace
