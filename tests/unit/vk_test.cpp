// SPDX-License-Identifier: Apache-2.0
// The Vulkan foundation: devices, memory, barriers from declared uses, reflection, and every fault of the machine.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "base/random.h"
#include "gnomon/error.h"
#include "vk/barriers.h"

namespace gnomon::test {
namespace {

constexpr std::uint32_t k_double[] =
#include "shaders/double.comp.inc"
    ;
constexpr std::uint32_t k_triangle_vertex[] =
#include "shaders/triangle.vert.inc"
    ;
constexpr std::uint32_t k_triangle_fragment[] =
#include "shaders/triangle.frag.inc"
    ;
const vk::ShaderCode k_double_code{"double.comp", k_double};

struct Limits {
    std::uint32_t count, factor;
};
const std::vector<vk::SharedMember> k_limits{{"count", 0, 4, 0}, {"factor", 4, 4, 0}};
// std430 puts a float into the fourth component of a vec3.
struct Item {
    float place[3];
    float weight;
    std::uint32_t flags, unused[3];
};

const std::vector<vk::BlockExpectation> k_double_blocks{
    {"", sizeof(Limits), k_limits},
    {"Items", sizeof(Item), {{"place", 0, 12, 0}, {"weight", 12, 4, 0}, {"flags", 16, 4, 0}}}};

class Vulkan : public VulkanTest {};

// The message of the exception that a call throws, which must have the given type.
template <class Wanted, class Call>
std::string thrown(const Call& call)
{
    try {
        call();
    } catch (const Wanted& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "another type of exception: " << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no exception";
    return "";
}

bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST_F(Vulkan, ListsDevicesWithReasons)
{
    const auto devices = device_->instance().devices();
    ASSERT_FALSE(devices.empty());
    EXPECT_TRUE(devices[0].chosen);
    EXPECT_EQ(devices[0].name, device_->info().name);
    for (const vk::DeviceInfo& device : devices) EXPECT_FALSE(device.reasons.empty()) << device.name;
}

TEST_F(Vulkan, ReflectsBindingsSizesAndOffsets)
{
    const vk::Reflection r = vk::reflect(k_double_code);
    EXPECT_EQ(r.local_size[0], 64u);
    EXPECT_EQ(r.push_bytes, sizeof(Limits));
    ASSERT_EQ(r.bindings.size(), 3u);
    EXPECT_EQ(r.bindings[0].bytes, 4u);
    EXPECT_FALSE(r.bindings[0].writes);
    EXPECT_TRUE(r.bindings[1].writes);
    EXPECT_EQ(r.bindings[2].bytes, sizeof(Item));

    const auto check = [&](const vk::BlockExpectation& e) { vk::check_block(r, k_double_code, e); };
    const std::string items = r.bindings[2].name;
    const std::vector<vk::SharedMember> good{{"place", 0, 12, 0}, {"weight", 12, 4, 0}, {"flags", 16, 4, 0}};
    check({"", sizeof(Limits), k_limits});
    check({items, sizeof(Item), good});
    // Every way of differing is found, and named.
    const auto refusal = [&](std::size_t bytes, std::vector<vk::SharedMember> members) {
        return thrown<InternalError>([&] { check({items, bytes, std::move(members)}); });
    };
    EXPECT_TRUE(has(refusal(sizeof(Item) + 4, good), "36 on the host"));
    const auto changed = [&](std::size_t which, const vk::SharedMember& member) {
        std::vector<vk::SharedMember> members = good;
        members[which] = member;
        return members;
    };
    EXPECT_TRUE(has(refusal(32, changed(2, {"flags", 12, 4, 0})), "the offset of 'flags' is 16 in the shader, 12"));
    EXPECT_TRUE(has(refusal(32, changed(0, {"place", 0, 16, 0})), "the size of 'place' is 12 in the shader, 16"));
    EXPECT_TRUE(has(refusal(32, changed(0, {"place", 0, 12, 4})), "the stride of 'place' is 0 in the shader, 4"));
    EXPECT_TRUE(has(refusal(32, changed(2, {"flag", 16, 4, 0})), "no member 'flag' in the shader"));
    for (std::size_t left_out = 0; left_out < good.size(); ++left_out) {
        std::vector<vk::SharedMember> fewer = good;
        fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(left_out));
        EXPECT_TRUE(has(refusal(32, fewer), "no member '" + good[left_out].name + "' on the host"));
    }
    // A pipeline is refused where a block of structures, or its push constants, are not expected.
    const vk::BlockExpectation limits{"", sizeof(Limits), k_limits}, some{items, sizeof(Item), good};
    vk::check_all_expected(r, k_double_code, std::vector{limits, some});
    EXPECT_TRUE(has(thrown<InternalError>([&] { vk::check_all_expected(r, k_double_code, std::vector{some}); }),
                    "no push constants"));
    EXPECT_TRUE(has(thrown<InternalError>([&] { vk::check_all_expected(r, k_double_code, std::vector{limits}); }),
                    "no structures in '" + items + "'"));
    EXPECT_TRUE(has(thrown<InternalError>([&] { check({"elsewhere", 4, {}}); }), "no such binding"));
}

TEST_F(Vulkan, ComputesOnUploadedDataAndReadsItBack)
{
    const vk::Pipeline pipeline(device_,
                                vk::ComputeDesc{.name = "double", .code = k_double_code, .blocks = k_double_blocks});
    std::vector<std::uint32_t> numbers(1000);
    std::iota(numbers.begin(), numbers.end(), 7u);
    Item item{};
    item.flags = 5;
    const vk::Buffer source(device_, "source", 4000), target(device_, "target", 4000), items(device_, "items", 32);
    vk::Commands commands(device_);
    const vk::Upload uploads[] = {vk::upload_of(source, std::span<const std::uint32_t>(numbers)),
                                  vk::upload_of(items, std::span<const Item>(&item, 1))};
    commands.upload("numbers", uploads);
    // Run twice, the second time on the first's result: the barrier in between comes from the declared uses.
    const vk::Buffer* from = &source;
    const vk::Buffer* to = &target;
    for (int turn = 0; turn < 2; ++turn, std::swap(from, to))
        commands.pass("double")
            .reads(*from, vk::Use::storage_read)
            .reads(items, vk::Use::storage_read)
            .writes(*to)
            .compute([&](vk::Recorder& r) {
                r.bind(pipeline);
                r.set(pipeline.bindings()[0].name, *from);
                r.set(pipeline.bindings()[1].name, *to);
                r.set(pipeline.bindings()[2].name, items);
                r.push(Limits{1000, 2});
                r.dispatch_over(1000);
            });
    const vk::Buffer result = commands.read_back(source);
    commands.submit();
    for (std::uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(result.as<std::uint32_t>()[i], 4 * (i + 7) + 15);
    EXPECT_EQ(commands.timings().size(), 4u);
    EXPECT_EQ(commands.draw_calls(), 2u);
}

TEST_F(Vulkan, DrawsIndirectlyIntoColourAndReversedDepth)
{
    const vk::Pipeline pipeline(device_, vk::GraphicsDesc{.name = "triangle",
                                                          .vertex = {"triangle.vert", k_triangle_vertex},
                                                          .fragment = {"triangle.frag", k_triangle_fragment},
                                                          .colors = {VK_FORMAT_R32G32_UINT},
                                                          .depth = VK_FORMAT_D32_SFLOAT});
    // Covers the left half; counter-clockwise on the screen.
    const float corners[] = {-1, -1, 0.25f, -1, 3, 0.25f, 0, 1, 0.25f, 0, -1, 0.25f};
    const std::uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    const VkDrawIndexedIndirectCommand draws[] = {{6, 1, 0, 0, 0}, {6, 0, 0, 0, 1}, {6, 1, 0, 0, 2}};
    const vk::Buffer vertices(device_, "vertices", sizeof corners), triangles(device_, "triangles", sizeof indices),
        parameters(device_, "parameters", sizeof draws);
    const vk::Image ids(device_, {.name = "ids",
                                  .width = 8,
                                  .height = 8,
                                  .format = VK_FORMAT_R32G32_UINT,
                                  .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT});
    const vk::Image depth(device_, {.name = "depth",
                                    .width = 8,
                                    .height = 8,
                                    .format = VK_FORMAT_D32_SFLOAT,
                                    .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT});
    vk::Commands commands(device_);
    const vk::Upload uploads[] = {vk::upload_of(vertices, std::span<const float>(corners)),
                                  vk::upload_of(triangles, std::span<const std::uint32_t>(indices)),
                                  vk::upload_of(parameters, std::span<const VkDrawIndexedIndirectCommand>(draws))};
    commands.upload("triangle", uploads);
    commands.pass("draw")
        .reads(vertices, vk::Use::vertices)
        .reads(triangles, vk::Use::vertices)
        .reads(parameters, vk::Use::indirect)
        .color({.image = &ids, .clear = VkClearColorValue{}})
        .depth({.image = &depth, .clear = 0.0f})
        .render([&](vk::Recorder& r) {
            r.bind(pipeline);
            r.vertex_buffer(0, vertices);
            r.index_buffer(triangles);
            r.draw_indexed_indirect(parameters, 0, 3);
        });
    const vk::Buffer id = commands.read_back(ids), z = commands.read_back(depth);
    commands.submit();
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x) {
            const bool inside = id.as<std::uint32_t>()[2 * (8 * y + x)] != 0;
            ASSERT_EQ(id.as<std::uint32_t>()[2 * (8 * y + x)], x < 4 && inside ? 3u : 0u) << x << ' ' << y;
            ASSERT_EQ(z.as<float>()[8 * y + x], inside ? 0.75f : 0.0f);
            if (x < 3) {
                ASSERT_TRUE(inside) << x << ' ' << y;
            }
        }
}

TEST_F(Vulkan, RefusesUndeclaredUses)
{
    const vk::Pipeline pipeline(device_,
                                vk::ComputeDesc{.name = "double", .code = k_double_code, .blocks = k_double_blocks});
    const vk::Buffer a(device_, "a", 64), b(device_, "b", 64);
    vk::Commands commands(device_);
    const auto record = [&](const std::function<void(vk::Recorder&)>& body) {
        return thrown<InternalError>([&] {
            commands.pass("p").reads(a, vk::Use::storage_read).compute([&](vk::Recorder& r) {
                r.bind(pipeline);
                body(r);
            });
        });
    };
    const auto& names = pipeline.bindings();
    EXPECT_TRUE(has(record([&](vk::Recorder& r) { r.set(names[0].name, b); }), "'b' differently from its declaration"));
    EXPECT_TRUE(has(record([&](vk::Recorder& r) { r.set(names[1].name, a); }), "'a' differently from its declaration"));
    EXPECT_TRUE(has(record([&](vk::Recorder& r) { r.set("nothing", a); }), "no binding 'nothing'"));
    EXPECT_TRUE(has(record([&](vk::Recorder& r) { r.dispatch(1); }), "is not set"));
    EXPECT_TRUE(has(record([&](vk::Recorder& r) { r.push(1.0f); }), "bytes"));
}

// The expected barriers for every pair of a write and a following use.
TEST(VulkanBarriers, WaitOnceForEveryHazard)
{
    const VkPipelineStageFlags2 compute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    const auto use = [&](vk::Use u) { return vk::meaning(u, compute); };
    vk::UseState state;
    EXPECT_FALSE(vk::follow(state, use(vk::Use::storage_read), false));   // nothing was written
    const auto war = vk::follow(state, use(vk::Use::storage_write), false);
    ASSERT_TRUE(war);
    EXPECT_EQ(war->from_stages, compute);
    ASSERT_TRUE(vk::follow(state, use(vk::Use::storage_read), false));   // in the same stage, by the next dispatch
    EXPECT_FALSE(vk::follow(state, use(vk::Use::storage_read), false));
    const auto raw = vk::follow(state, use(vk::Use::vertices), false);
    ASSERT_TRUE(raw);
    EXPECT_EQ(raw->from_stages, compute);
    EXPECT_NE(raw->from_access & VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, 0u);
    EXPECT_FALSE(vk::follow(state, use(vk::Use::vertices), false));   // already visible
    ASSERT_TRUE(vk::follow(state, use(vk::Use::indirect), false));    // to another stage
    const auto waw = vk::follow(state, use(vk::Use::copy_target), false);
    ASSERT_TRUE(waw);
    EXPECT_EQ(waw->from_stages & VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT, VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT);
    EXPECT_EQ(waw->from_stages & VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT);

    // Images wait where their layout changes, also between two reads, and a later read waits for that change.
    vk::UseState image;
    ASSERT_TRUE(vk::follow(image, use(vk::Use::color_target), true));
    ASSERT_TRUE(vk::follow(image, use(vk::Use::sampled), true));
    EXPECT_FALSE(vk::follow(image, use(vk::Use::sampled), true));
    ASSERT_TRUE(vk::follow(image, use(vk::Use::copy_source), true));
    const auto back = vk::follow(image, use(vk::Use::sampled), true);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->from_layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

TEST_F(Vulkan, MemoryIsSuballocatedReusedAndFreed)
{
    Random random(3);
    std::vector<vk::Buffer> buffers;
    std::uint64_t stamp = 0;
    std::vector<std::uint64_t> stamps;
    for (int turn = 0; turn < 400; ++turn) {
        if (buffers.size() < 40 || random.below(2)) {
            buffers.emplace_back(device_, "piece", 8 + 8 * random.below(20000), vk::Access::upload);
            for (std::uint64_t& word : buffers.back().as<std::uint64_t>()) word = stamp;
            stamps.push_back(stamp++);
        } else {
            const std::uint32_t which = random.below(static_cast<std::uint32_t>(buffers.size()));
            std::swap(buffers[which], buffers.back());
            std::swap(stamps[which], stamps.back());
            buffers.pop_back();
            stamps.pop_back();
        }
    }
    // No two allocations overlap: each still holds its own stamp.
    for (std::size_t i = 0; i < buffers.size(); ++i)
        for (const std::uint64_t word : buffers[i].as<std::uint64_t>()) ASSERT_EQ(word, stamps[i]);
    EXPECT_EQ(device_->memory().counts().pieces, buffers.size());
    EXPECT_LE(device_->memory().counts().blocks, 2u);
    buffers.clear();
    EXPECT_EQ(device_->memory().counts().bytes_allocated, 0u);
    const vk::Buffer large(device_, "large", vk::Memory::k_block_bytes + 1);
    EXPECT_EQ(device_->memory().counts().blocks, 1u);
}

// What nothing wrote is no zeros, as on graphics cards, so that a shader that reads it shows in any test.
TEST_F(Vulkan, UnwrittenMemoryIsMarked)
{
    if (device_->info().kind != "software") GTEST_SKIP() << "the host does not see the device's memory";
    const vk::Buffer buffer(device_, "unwritten", 64);
    vk::Commands commands(device_);
    const vk::Buffer seen = commands.read_back(buffer);
    commands.submit();
    for (const std::uint32_t word : seen.as<std::uint32_t>()) EXPECT_EQ(word, 0xffffffffu);
}

// Faults, simulated at the loader's entry points. Each is a MissingError of one line.

TEST_F(Vulkan, MissingDriverIsAMissingError)
{
    const Replaced none(
        vkEnumeratePhysicalDevices, +[](VkInstance, std::uint32_t* count, VkPhysicalDevice*) -> VkResult {
            *count = 0;
            return VK_SUCCESS;
        });
    EXPECT_TRUE(has(thrown<MissingError>([] { vk::Device::open(); }), "no device"));
}

TEST_F(Vulkan, FailingInstanceIsAMissingError)
{
    device_.reset();
    const Replaced broken(
        vkCreateInstance, +[](const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance*) -> VkResult {
            return VK_ERROR_INCOMPATIBLE_DRIVER;
        });
    EXPECT_TRUE(has(thrown<MissingError>([] { vk::Device::open(); }), "no driver is installed"));
}

TEST_F(Vulkan, OldDriverIsAMissingError)
{
    static PFN_vkGetPhysicalDeviceProperties2 real;
    real = vkGetPhysicalDeviceProperties2;
    const Replaced old(
        vkGetPhysicalDeviceProperties2, +[](VkPhysicalDevice d, VkPhysicalDeviceProperties2* p) {
            real(d, p);
            p->properties.apiVersion = VK_API_VERSION_1_1;
        });
    EXPECT_TRUE(has(thrown<MissingError>([] { vk::Device::open(); }), "Vulkan 1.1; 1.3 is required"));
}

TEST_F(Vulkan, MissingFeatureIsAMissingError)
{
    static PFN_vkGetPhysicalDeviceFeatures2 real;
    real = vkGetPhysicalDeviceFeatures2;
    const Replaced less(
        vkGetPhysicalDeviceFeatures2, +[](VkPhysicalDevice d, VkPhysicalDeviceFeatures2* f) {
            real(d, f);
            f->features.multiDrawIndirect = VK_FALSE;
        });
    EXPECT_TRUE(has(thrown<MissingError>([] { vk::Device::open(); }), "lacks multiDrawIndirect"));
}

TEST_F(Vulkan, MissingExtensionIsAMissingError)
{
    const Replaced less(
        vkEnumerateDeviceExtensionProperties,
        +[](VkPhysicalDevice, const char*, std::uint32_t* count, VkExtensionProperties*) -> VkResult {
            *count = 0;
            return VK_SUCCESS;
        });
    EXPECT_TRUE(has(thrown<MissingError>([] { vk::Device::open(); }), "VK_KHR_push_descriptor"));
}

TEST_F(Vulkan, TooLittleDeviceMemoryIsAMissingError)
{
    const Replaced full(
        vkAllocateMemory,
        +[](VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*, VkDeviceMemory*) -> VkResult {
            return VK_ERROR_OUT_OF_DEVICE_MEMORY;
        });
    EXPECT_TRUE(has(thrown<MissingError>([&] { vk::Buffer(device_, "big", 64 << 20); }),
                    "allocating 64 MiB for buffer 'big' failed: out of device memory"));
    EXPECT_TRUE(
        has(thrown<MissingError>([&] { vk::Image(device_, {.name = "image", .usage = VK_IMAGE_USAGE_SAMPLED_BIT}); }),
            "image 'image'"));
}

// For drivers that grant every request and let the process be killed for it.
TEST_F(Vulkan, MoreMemoryThanTheMachineHasIsAMissingError)
{
    const Replaced takes(
        vkAllocateMemory,
        +[](VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*, VkDeviceMemory* memory) -> VkResult {
            *memory = VK_NULL_HANDLE;
            return VK_SUCCESS;
        });
    const Replaced maps(
        vkMapMemory,
        +[](VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void** mapped) -> VkResult {
            *mapped = nullptr;
            return VK_SUCCESS;
        });
    vk::Memory memory(device_->physical(), device_->handle(), false, false);
    VkPhysicalDeviceMemoryProperties has_heaps{};
    vkGetPhysicalDeviceMemoryProperties(device_->physical(), &has_heaps);
    VkMemoryRequirements needs{has_heaps.memoryHeaps[has_heaps.memoryTypes[0].heapIndex].size + 1, 256, 1};
    const vk::Access any = vk::Access::device;
    EXPECT_TRUE(has(thrown<MissingError>([&] { memory.take(needs, any, false, "wall"); }), "out of device memory"));
    if (device_->info().kind != "software") GTEST_SKIP() << "only a software driver grants more than there is";
    needs.size = 1 << 30;
    const std::uint64_t machine =
        static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
    std::vector<vk::MemoryPiece> pieces;
    EXPECT_TRUE(has(thrown<MissingError>([&] {
                        while (memory.counts().bytes_used <= machine)
                            pieces.push_back(memory.take(needs, any, false, "brick"));
                    }),
                    "allocating 1024 MiB for brick failed: out of device memory"));
}

TEST_F(Vulkan, TooLargeImageIsAMissingError)
{
    EXPECT_TRUE(has(thrown<MissingError>([&] {
                        vk::Image(device_,
                                  {.name = "wall", .width = 1 << 20, .height = 1, .usage = VK_IMAGE_USAGE_SAMPLED_BIT});
                    }),
                    "exceeds the device's limit"));
}

TEST_F(Vulkan, BufferBeyondTheShaderLimitIsAMissingError)
{
    const Replaced small(
        vkGetPhysicalDeviceProperties, +[](VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
            VkPhysicalDeviceProperties2 all{};
            all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
            vkGetPhysicalDeviceProperties2(device, &all);
            *properties = all.properties;
            properties->limits.maxStorageBufferRange = 1 << 20;
        });
    const std::shared_ptr<vk::Device> device = vk::Device::open();
    const vk::Pipeline pipeline(device,
                                vk::ComputeDesc{.name = "double", .code = k_double_code, .blocks = k_double_blocks});
    const vk::Buffer buffer(device, "many", (1 << 20) + 256);
    vk::Commands commands(device);
    const auto set = [&](VkDeviceSize offset, VkDeviceSize bytes) {
        commands.pass("p").reads(buffer, vk::Use::storage_read).compute([&](vk::Recorder& r) {
            r.bind(pipeline);
            r.set(pipeline.bindings()[0].name, buffer, offset, bytes);
        });
    };
    EXPECT_TRUE(has(thrown<MissingError>([&] { set(0, VK_WHOLE_SIZE); }),
                    "'many' needs 2 MiB, but the device can address only 1 MiB"));
    set(256, VK_WHOLE_SIZE);
    set(0, 1 << 20);
}

TEST_F(Vulkan, LostDeviceIsAMissingError)
{
    vk::Commands commands(device_);
    const vk::Buffer buffer(device_, "buffer", 64);
    commands.pass("fill").writes(buffer, vk::Use::copy_target).copy([&](vk::Recorder& r) { r.fill(buffer, 1); });
    const Replaced lost(
        vkQueueSubmit2,
        +[](VkQueue, std::uint32_t, const VkSubmitInfo2*, VkFence) -> VkResult { return VK_ERROR_DEVICE_LOST; });
    EXPECT_TRUE(has(thrown<MissingError>([&] { commands.submit(); }), "the device was lost"));
}

TEST_F(Vulkan, LostDeviceWhileWaitingIsAMissingError)
{
    vk::Commands commands(device_);
    const vk::Buffer buffer(device_, "buffer", 64);
    commands.pass("fill").writes(buffer, vk::Use::copy_target).copy([&](vk::Recorder& r) { r.fill(buffer, 1); });
    static PFN_vkWaitForFences real;
    real = vkWaitForFences;
    const Replaced lost(
        vkWaitForFences,
        +[](VkDevice d, std::uint32_t n, const VkFence* f, VkBool32 all, std::uint64_t time) -> VkResult {
            real(d, n, f, all, time);
            return VK_ERROR_DEVICE_LOST;
        });
    EXPECT_TRUE(has(thrown<MissingError>([&] { commands.submit(); }), "waiting for the device failed"));
}

// Validation is on, and a message fails the work: copy beyond a buffer's end.
TEST_F(Vulkan, ValidationMessagesAreErrors)
{
    const vk::Buffer a(device_, "a", 64), b(device_, "b", 64);
    vk::Commands commands(device_);
    commands.pass("copy").reads(a, vk::Use::copy_source).writes(b, vk::Use::copy_target).copy([&](vk::Recorder& r) {
        const VkBufferCopy beyond{0, 32, 64};
        r.copy(a, b, {&beyond, 1});
    });
    EXPECT_TRUE(has(thrown<InternalError>([&] { commands.submit(); }), "Vulkan validation"));
}

// Synchronisation too: two writes to the same memory without a barrier.
TEST_F(Vulkan, SynchronisationErrorsAreErrors)
{
    const vk::Buffer a(device_, "a", 64);
    vk::Commands commands(device_);
    commands.pass("race").writes(a, vk::Use::copy_target).copy([&](vk::Recorder& r) {
        r.fill(a, 1);
        r.fill(a, 2);
    });
    EXPECT_TRUE(has(thrown<InternalError>([&] { commands.submit(); }), "HAZARD"));
}

}   // namespace
}   // namespace gnomon::test
#else
TEST(Vulkan, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
