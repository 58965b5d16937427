// SPDX-License-Identifier: Apache-2.0
#pragma once
// The casters' triangles in world space, to which the entries of CasterCells refer.
//
// Each object has its own range: opaque triangles and alpha-tested ones in the order of its mesh's parts. Triangles
// that do not occlude light are omitted. A range is written on request, at most once per frame, and stays valid until
// the object moves; it must then be requested again. Cost: the triangles of the requested objects. Memory: 48 bytes per
// triangle of every object, on the device.

#include <memory>
#include <vector>

#include "light_views/vulkan/caster_geometry.h"

namespace gnomon::light_views {

class CasterTriangles {
 public:
    explicit CasterTriangles(std::shared_ptr<vk::Device> device) : device_(std::move(device)) {}

    /// The triangles of one object in the current state. Valid until the next call.
    struct Run {
        std::uint32_t first = 0;   // index of the first triangle
        std::span<const shared::CellTriangle> triangles;
    };
    Run of(const CasterGeometry& casters, const scene::SceneState& state, scene::ObjectId object);

    /// Uploads the ranges that were requested since the last call.
    void send(vk::Commands& commands);

    const vk::Buffer& buffer() const { return buffer_; }   // valid after the first send()

 private:
    static constexpr std::size_t k_not_written = ~std::size_t{0};
    void number(const scene::Scene& scene);
    void write(const CasterGeometry& casters, const scene::SceneState& state, scene::ObjectId object);

    std::shared_ptr<vk::Device> device_;
    std::vector<std::uint32_t> first_;      // by object, with one more at the end
    std::vector<std::size_t> written_at_;   // by object: index in written_, or k_not_written
    std::vector<shared::CellTriangle> written_;
    std::vector<scene::ObjectId> to_send_;
    std::vector<glm::vec3> world_;   // scratch
    vk::Buffer buffer_;
};

}   // namespace gnomon::light_views
