// SPDX-License-Identifier: Apache-2.0
#pragma once
// The casters' triangles where they are in the world: what the entries of CasterCells point to.
//
// Each object has its own run, opaque triangles and alpha-tested ones in the order of its mesh's parts. Triangles that
// block no light are not there. An object's run is written when somebody asks for it, at most once a frame, and holds
// until then: whoever points to it has to ask again after the object has moved.
// Cost: the triangles of the objects asked for. Memory: 48 bytes a triangle of every object, on the device.

#include <memory>
#include <vector>

#include "light_views/vulkan/caster_geometry.h"

namespace gnomon::light_views {

class CasterTriangles {
 public:
    explicit CasterTriangles(std::shared_ptr<vk::Device> device) : device_(std::move(device)) {}

    /// Of one object, as the state has it now. Valid until the next call.
    struct Run {
        std::uint32_t first = 0;   // number of the first
        std::span<const shared::CellTriangle> triangles;
    };
    Run of(const CasterGeometry& casters, const scene::SceneState& state, scene::ObjectId object);

    /// Sends what was asked for since the last time.
    void send(vk::Commands& commands);

    const vk::Buffer& buffer() const { return buffer_; }   // after the first send()

 private:
    static constexpr std::size_t k_not_written = ~std::size_t{0};
    void number(const scene::Scene& scene);
    void write(const CasterGeometry& casters, const scene::SceneState& state, scene::ObjectId object);

    std::shared_ptr<vk::Device> device_;
    std::vector<std::uint32_t> first_;      // by object, and one more
    std::vector<std::size_t> written_at_;   // by object: in written_, or k_not_written
    std::vector<shared::CellTriangle> written_;
    std::vector<scene::ObjectId> to_send_;
    std::vector<glm::vec3> world_;   // scratch
    vk::Buffer buffer_;
};

}   // namespace gnomon::light_views
