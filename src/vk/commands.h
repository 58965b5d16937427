// SPDX-License-Identifier: Apache-2.0
#pragma once
// Records work for the device in passes. A pass declares the resources that it reads and writes; barriers and image
// layouts are derived from these declarations and from each resource's previous use. Every pass is labelled for
// debuggers and timed.
//
//     Commands commands(device);
//     commands.pass("depth").uses(pipeline).binds("matrices", matrices).reads(vertices, Use::vertices)
//         .depth({.image = &depth, .clear = 0.f}).render([&](Recorder& r) {
//             r.vertex_buffer(0, vertices);
//             r.draw(vertex_count);
//         });
//     Buffer result = commands.read_back(depth);
//     commands.submit();                        // waits; then result.as<float>()
//
// A pass of several pipelines declares its resources by reads() and writes(), and binds them in its body.
// A check fails if a pass uses a resource without declaring it, or writes one that it declared as read. Resources must
// live until submit() returns. Cost: a few comparisons per resource and pass.

#include <functional>
#include <optional>
#include <string_view>

#include "vk/acceleration.h"
#include "vk/pipeline.h"
#include "vk/resource.h"
#include "vk/submission.h"

namespace gnomon::vk {

/// How a pass uses a resource.
enum class Use : std::uint8_t {
    sampled,         // by a sampler or texelFetch: images, texel buffers
    storage_read,    // storage buffers and images
    storage_write,   // the same for writing, and possibly reading
    uniform,         // uniform buffers
    vertices,        // vertex and index buffers
    indirect,        // draw parameters
    copy_source,
    copy_target,
    color_target,   // by Pass::color
    depth_target,   // by Pass::depth
    depth_test,     // by Pass::depth without writing
    host_read,      // by read_back
    build_input,    // inputs of acceleration structure builds: vertices, indices, matrices, instances
    build_source,   // bottom levels that are inputs of a top level's build
    build_target,   // structures that are built, and the scratch memory of builds
    traced,         // structures that rays traverse: the top level, and all below it
};

struct Rect {
    std::int32_t x = 0, y = 0;
    std::uint32_t width = 0, height = 0;
};

/// An image to render into. Without `clear`, its contents are kept.
struct ColorTarget {
    const Image* image = nullptr;
    std::uint32_t layer = 0;
    std::optional<VkClearColorValue> clear{};
};
struct DepthTarget {
    const Image* image = nullptr;
    std::uint32_t layer = 0;
    std::optional<float> clear{};
    bool write = true;   // false: depth test only
};

struct PassTiming {
    std::string name;
    double ms = 0;
};

class Commands;

/// A declared use of a buffer or an image.
struct ResourceUse {
    const Buffer* buffer = nullptr;
    const Image* image = nullptr;
    Use use{};
};

/// Records commands inside one pass.
class Recorder {
 public:
    void bind(const Pipeline& pipeline);

    /// Binds a resource to a binding, given by its name in the shader. Texel buffers need a format.
    /// @throws MissingError  a larger range of a buffer than the device allows for a shader
    void set(std::string_view binding, const Buffer& buffer, VkDeviceSize offset = 0,
             VkDeviceSize bytes = VK_WHOLE_SIZE);
    void set_texels(std::string_view binding, const Buffer& buffer, VkFormat format);
    void set(std::string_view binding, const Image& image);   // storage image, or sampled image without a sampler
    void set(std::string_view binding, const Image& image, VkSampler sampler);   // combined
    void set(std::string_view binding, const AccelerationStructure& top);
    void push_constants(const void* data, std::size_t bytes);
    template <class T>
    void push(const T& constants)
    {
        push_constants(&constants, sizeof constants);
    }

    // In a rendering pass. Initially, viewport and scissor cover the whole target, and culling is off.
    void viewport(const Rect& rect);
    void scissor(const Rect& rect);
    /// Front faces are counter-clockwise on the screen (y down).
    void cull(VkCullModeFlags mode);
    void vertex_buffer(std::uint32_t location, const Buffer& buffer, VkDeviceSize offset = 0);
    void index_buffer(const Buffer& buffer, VkDeviceSize offset = 0);   // 32-bit
    void draw(std::uint32_t vertices, std::uint32_t instances = 1, std::uint32_t first_vertex = 0,
              std::uint32_t first_instance = 0);
    void draw_indexed(std::uint32_t indices, std::uint32_t instances = 1, std::uint32_t first_index = 0,
                      std::int32_t vertex_offset = 0, std::uint32_t first_instance = 0);
    /// Consecutive VkDrawIndexedIndirectCommand structures.
    void draw_indexed_indirect(const Buffer& buffer, VkDeviceSize offset, std::uint32_t draws);
    void clear_depth(const Rect& rect, float value);

    // In a compute pass.
    void dispatch(std::uint32_t x, std::uint32_t y = 1, std::uint32_t z = 1);
    /// Dispatches enough groups to cover that many invocations.
    void dispatch_over(std::uint32_t x, std::uint32_t y = 1, std::uint32_t z = 1);

    // In a ray-tracing pass.
    /// One ray generation invocation per element; at most Device::ray_limits().most_rays in total.
    void trace(std::uint32_t width, std::uint32_t height = 1);

    // In a build pass.
    /// Builds all structures at once, each with its own range of the scratch memory; none may depend on another.
    /// @param scratch  the buffer with all scratch memory
    void build(std::span<const StructureBuild> builds, const Buffer& scratch);

    // In a copy pass.
    void copy(const Buffer& from, const Buffer& to, std::span<const VkBufferCopy> regions);
    void copy(const Buffer& from, const Image& to, std::span<const VkBufferImageCopy> regions);
    void copy(const Image& from, const Buffer& to, std::span<const VkBufferImageCopy> regions);
    void copy(const Image& from, const Image& to, std::span<const VkImageCopy> regions);
    void fill(const Buffer& buffer, std::uint32_t word, VkDeviceSize offset = 0, VkDeviceSize bytes = VK_WHOLE_SIZE);

    /// Clears all channels of all layers of a floating-point or normalised image.
    void clear(const Image& image, float value);

    VkCommandBuffer handle() const { return buffer_; }

 private:
    friend class Commands;
    friend class Pass;
    enum class Kind : std::uint8_t { render, compute, trace, build, copy };
    Recorder(VkCommandBuffer buffer, Kind kind, const std::vector<ResourceUse>& uses, const std::string& pass)
        : buffer_(buffer), kind_(kind), uses_(uses), pass_(pass)
    {
    }
    const Binding& binding(std::string_view name, VkDescriptorType type) const;
    void write(const Binding& binding, const VkDescriptorBufferInfo* buffer, const VkDescriptorImageInfo* image,
               const VkBufferView* texels, const void* more = nullptr);
    void declared(const Buffer* buffer, const Image* image, std::initializer_list<Use> any_of) const;
    void ready() const;

    VkCommandBuffer buffer_;
    Kind kind_;
    const std::vector<ResourceUse>& uses_;
    const std::string& pass_;
    const Pipeline* pipeline_ = nullptr;
    std::uint64_t set_ = 0;   // bit mask of bound bindings, by index in the pipeline's list
    bool pushed_ = false;
    std::uint64_t calls_ = 0;   // draws, dispatches and traces
};

/// Declares one pass; the last call records it.
class Pass {
 public:
    /// The pipeline of all calls of the pass: it is bound before the body runs. Before binds().
    Pass& uses(const Pipeline& pipeline);
    /// Declares a resource of that pipeline and fills its binding, by the name in the shader; reflection says whether
    /// the shader reads or writes it. The body then only pushes constants, and draws or dispatches.
    Pass& binds(const char* binding, const Buffer& buffer);
    Pass& binds(const char* binding, const Image& image);
    Pass& binds_texels(const char* binding, const Buffer& buffer, VkFormat format);
    Pass& reads(const Buffer& buffer, Use use);
    Pass& reads(const Image& image, Use use);
    Pass& writes(const Buffer& buffer, Use use = Use::storage_write);
    Pass& writes(const Image& image, Use use = Use::storage_write);
    Pass& color(const ColorTarget& target);
    Pass& depth(const DepthTarget& target);
    /// Restricts rendering and clearing to a part of the targets.
    Pass& area(const Rect& rect);

    void render(const std::function<void(Recorder&)>& body);
    void compute(const std::function<void(Recorder&)>& body);
    void trace(const std::function<void(Recorder&)>& body);   // traces rays
    void build(const std::function<void(Recorder&)>& body);   // builds acceleration structures
    void copy(const std::function<void(Recorder&)>& body);

 private:
    friend class Commands;
    Pass(Commands& commands, std::string name) : commands_(commands), name_(std::move(name)) {}
    void record(Recorder::Kind kind, const std::function<void(Recorder&)>& body);
    const Binding& binding(const char* name) const;
    void fill_bindings(Recorder& recorder) const;
    void begin_rendering(VkCommandBuffer buffer) const;

    struct Bound {
        const char* binding;
        const Buffer* buffer = nullptr;
        const Image* image = nullptr;
        VkFormat format = VK_FORMAT_UNDEFINED;   // of a texel buffer
    };
    Commands& commands_;
    std::string name_;
    const Pipeline* pipeline_ = nullptr;
    std::vector<Bound> bound_;
    std::vector<ResourceUse> uses_;
    std::vector<ColorTarget> colors_;
    std::optional<DepthTarget> depth_;
    std::optional<Rect> area_;
};

/// Bytes to copy to a position in a buffer.
struct Upload {
    const Buffer* to = nullptr;
    VkDeviceSize offset = 0;
    std::span<const std::byte> bytes;
};
template <class T>
Upload upload_of(const Buffer& to, std::span<const T> values, VkDeviceSize offset = 0)
{
    return {&to, offset, std::as_bytes(values)};
}

class Commands {
 public:
    explicit Commands(const std::shared_ptr<Device>& device);
    ~Commands();
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;

    Pass pass(std::string name) { return {*this, std::move(name)}; }
    /// Copies the bytes to staging memory immediately, and records the transfer to the buffers as one pass.
    void upload(const std::string& name, std::span<const Upload> uploads);
    /// Records a copy to host memory; its contents are valid after submit().
    /// @param bytes  from the start; VK_WHOLE_SIZE: all
    Buffer read_back(const Buffer& from, VkDeviceSize bytes = VK_WHOLE_SIZE);
    Buffer read_back(const Image& from, std::uint32_t layer = 0);
    /// The same for the first bytes, into an existing buffer.
    void read_back(const Buffer& from, const Buffer& to, VkDeviceSize bytes);

    /// Submits everything that was recorded and waits for it.
    /// @throws MissingError   the device was lost, or has too little memory
    /// @throws InternalError  validation reported a message
    void submit();

    /// Device time of each pass of the last submit. Mesa's software driver measures draws correctly, but reports too
    /// little time for compute passes.
    const std::vector<PassTiming>& timings() const { return timings_; }
    /// Draws, dispatches and traces of the last submit.
    std::uint64_t draw_calls() const { return draw_calls_; }
    const std::shared_ptr<Device>& device() const { return device_; }

 private:
    friend class Pass;
    friend class Recorder;
    static constexpr std::uint32_t k_max_timed = 512;   // passes per submit
    void begin();
    void barriers(const std::vector<ResourceUse>& uses, Recorder::Kind kind);

    std::shared_ptr<Device> device_;
    Submission submission_;
    Owned<VkQueryPool> queries_;
    bool recording_ = false;
    std::vector<Buffer> staging_;   // kept until submit
    std::vector<std::string> timed_;
    std::vector<PassTiming> timings_;
    std::uint64_t draw_calls_ = 0;
};

}   // namespace gnomon::vk
