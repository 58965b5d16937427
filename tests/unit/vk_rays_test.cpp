// SPDX-License-Identifier: Apache-2.0
// Tracing rays on the device: feature detection, acceleration structures, the any-hit shader, instance masks,
// rebuilding.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN

#include <cstring>

#include "gnomon/error.h"
#include "vk/barriers.h"

namespace gnomon::test {
namespace {

constexpr std::uint32_t k_generation[] =
#include "shaders/rays.rgen.inc"
    ;
constexpr std::uint32_t k_miss[] =
#include "shaders/rays.rmiss.inc"
    ;
constexpr std::uint32_t k_any_hit[] =
#include "shaders/rays.rahit.inc"
    ;
constexpr std::uint32_t k_side = 16;   // rays per side

class VulkanRays : public VulkanTest {};

// Two triangles, each with a BLAS of its own, and a TLAS over both.
struct Stage {
    explicit Stage(const std::shared_ptr<vk::Device>& the_device, bool masked)
        : device(the_device), commands(the_device)
    {
        // The lower left half of a unit square, and the upper right one.
        const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
        const std::uint32_t numbers[] = {0, 1, 2, 3, 2, 1};
        positions = vk::Buffer(device, "positions", sizeof corners);
        indices = vk::Buffer(device, "indices", sizeof numbers);
        instances = vk::Buffer(device, "instances", 2 * sizeof(VkAccelerationStructureInstanceKHR));
        limit = vk::Buffer(device, "limit", sizeof(float));
        answers = vk::Buffer(device, "answers", k_side * k_side * sizeof(std::uint32_t));
        const float half = 0.5f;
        const vk::Upload uploads[] = {vk::upload_of(positions, std::span<const float>(corners)),
                                      vk::upload_of(indices, std::span<const std::uint32_t>(numbers)),
                                      vk::upload_of(limit, std::span<const float>(&half, 1))};
        commands.upload("triangles", uploads);
        VkDeviceSize scratch_bytes = 0;
        for (std::uint32_t t = 0; t < 2; ++t) {
            descs[t].triangles = {{.positions = &positions,
                                   .position_count = 4,
                                   .indices = &indices,
                                   .first_index = 3 * t,
                                   .triangles = 1,
                                   .opaque = !masked}};
            const vk::StructureBytes needs = vk::structure_bytes(*device, descs[t]);
            bottoms[t] = vk::AccelerationStructure(device, "triangle", false, needs.storage);
            scratch_bytes += needs.scratch;
        }
        top_desc = {.instances = &instances, .instance_count = 2};
        const vk::StructureBytes needs = vk::structure_bytes(*device, top_desc);
        top = vk::AccelerationStructure(device, "top", true, needs.storage);
        const VkDeviceSize alignment = device->ray_limits().scratch_alignment;
        scratch = vk::Buffer(device, "scratch", std::max(scratch_bytes, needs.scratch) + alignment);
        scratch_at = vk::round_up(scratch.address(), alignment);
        const vk::StructureBuild builds[] = {
            {&descs[0], &bottoms[0], scratch_at},
            {&descs[1], &bottoms[1], scratch_at + vk::structure_bytes(*device, descs[0]).scratch}};
        commands.pass("build triangles")
            .reads(positions, vk::Use::build_input)
            .reads(indices, vk::Use::build_input)
            .writes(bottoms[0].storage(), vk::Use::build_target)
            .writes(bottoms[1].storage(), vk::Use::build_target)
            .writes(scratch, vk::Use::build_target)
            .build([&](vk::Recorder& r) { r.build(builds, scratch); });
        pipeline = vk::Pipeline(device, vk::RayDesc{.name = "rays",
                                                    .generation = {"rays.rgen", k_generation},
                                                    .miss = {"rays.rmiss", k_miss},
                                                    .any_hit = {"rays.rahit", k_any_hit},
                                                    .blocks = {{"", sizeof(std::uint32_t), {{"mask", 0, 4, 0}}}}});
    }

    // Translates both along x, and builds the TLAS.
    void place(const float (&x)[2])
    {
        VkAccelerationStructureInstanceKHR list[2]{};
        for (std::uint32_t t = 0; t < 2; ++t) {
            for (int i = 0; i < 3; ++i) list[t].transform.matrix[i][i] = 1;
            list[t].transform.matrix[0][3] = x[t];
            list[t].mask = 1u << t;
            list[t].accelerationStructureReference = bottoms[t].address();
        }
        const vk::Upload upload = vk::upload_of(instances, std::span<const VkAccelerationStructureInstanceKHR>(list));
        commands.upload("instances", {&upload, 1});
        const vk::StructureBuild build{&top_desc, &top, scratch_at};
        commands.pass("build top")
            .reads(instances, vk::Use::build_input)
            .reads(bottoms[0].storage(), vk::Use::build_source)
            .reads(bottoms[1].storage(), vk::Use::build_source)
            .writes(top.storage(), vk::Use::build_target)
            .writes(scratch, vk::Use::build_target)
            .build([&](vk::Recorder& r) {
                r.build({&build, 1}, scratch);
            });
    }

    // The hits of the ray grid as text: rows from y = 0 on.
    std::string trace_grid(std::uint32_t mask)
    {
        commands.pass("trace")
            .reads(top.storage(), vk::Use::traced)
            .reads(bottoms[0].storage(), vk::Use::traced)
            .reads(bottoms[1].storage(), vk::Use::traced)
            .reads(limit, vk::Use::storage_read)
            .writes(answers)
            .trace([&](vk::Recorder& r) {
                r.bind(pipeline);
                r.set("scene", top);
                for (const vk::Binding& b : pipeline.bindings())
                    if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) r.set(b.name, b.writes ? answers : limit);
                r.push(mask);
                r.trace(k_side, k_side);
            });
        const vk::Buffer result = commands.read_back(answers);
        commands.submit();
        std::string text;
        for (const std::uint32_t answer : result.as<std::uint32_t>()) text += answer ? '#' : '.';
        return text;
    }

    std::shared_ptr<vk::Device> device;
    vk::Commands commands;
    vk::Buffer positions, indices, instances, scratch, limit, answers;
    vk::StructureDesc descs[2], top_desc;
    vk::AccelerationStructure bottoms[2], top;
    VkDeviceAddress scratch_at = 0;
    vk::Pipeline pipeline;
};

// The expected grid from a predicate on the position. Positions on the diagonal belong to either triangle.
template <class Impl>
void expect_grid(const std::string& answers, const Impl& inside)
{
    ASSERT_EQ(answers.size(), k_side * k_side);
    for (std::uint32_t y = 0; y < k_side; ++y)
        for (std::uint32_t x = 0; x < k_side; ++x) {
            if (x + y + 1 == k_side) continue;
            const float u = (static_cast<float>(x) + 0.5f) / k_side, v = (static_cast<float>(y) + 0.5f) / k_side;
            ASSERT_EQ(answers[y * k_side + x], inside(u, v) ? '#' : '.') << x << ' ' << y;
        }
}

#define GNOMON_NEED_RAYS                                                                    \
    if (!device_->traces_rays())                                                            \
    GTEST_SKIP() << "the device '" << device_->info().name << "' traces no rays: it lacks " \
                 << device_->info().no_rays.front()

TEST_F(VulkanRays, HonoursMasksOfInstances)
{
    GNOMON_NEED_RAYS;
    Stage stage(device_, false);
    stage.place({0, 0});
    expect_grid(stage.trace_grid(1), [](float u, float v) { return u + v < 1; });
    expect_grid(stage.trace_grid(2), [](float u, float v) { return u + v > 1; });
    expect_grid(stage.trace_grid(3), [](float, float) { return true; });
    expect_grid(stage.trace_grid(4), [](float, float) { return false; });
}

TEST_F(VulkanRays, AnyHitShaderLetsRaysPass)
{
    GNOMON_NEED_RAYS;
    Stage stage(device_, true);
    stage.place({0, 0});
    // The second corners are (1, 0) and (0, 1).
    expect_grid(stage.trace_grid(1), [](float u, float v) { return u + v < 1 && u <= 0.5f; });
    expect_grid(stage.trace_grid(2), [](float u, float v) { return u + v > 1 && 1 - u <= 0.5f; });
}

// The next trace waits for the next build: moved triangles are hit at their new places.
TEST_F(VulkanRays, TraceWaitsForTheRebuiltTlas)
{
    GNOMON_NEED_RAYS;
    Stage stage(device_, false);
    stage.place({0, 0});
    stage.trace_grid(3);
    stage.place({4, 0});
    expect_grid(stage.trace_grid(3), [](float u, float v) { return u + v > 1; });
    stage.place({0, -3});
    expect_grid(stage.trace_grid(3), [](float u, float v) { return u + v < 1; });
}

// Some drivers add the offset of a matrix even to the null address.
TEST_F(VulkanRays, GeometriesWithoutMatricesHaveNoOffsetToOne)
{
    GNOMON_NEED_RAYS;
    const vk::Buffer buffer(device_, "triangles", 64);
    const vk::StructureDesc desc{
        .triangles = {
            {.positions = &buffer, .position_count = 3, .indices = &buffer, .triangles = 1, .matrix = 0xffffffffu}}};
    vk::BuildInfo info;
    info.fill(desc);
    EXPECT_EQ(info.ranges[0].transformOffset, 0u);
}

TEST_F(VulkanRays, ReflectsRayStages)
{
    const vk::Reflection generation = vk::reflect({"rays.rgen", k_generation}),
                         miss = vk::reflect({"rays.rmiss", k_miss}), any_hit = vk::reflect({"rays.rahit", k_any_hit});
    EXPECT_EQ(generation.stage, VK_SHADER_STAGE_RAYGEN_BIT_KHR);
    EXPECT_EQ(miss.stage, VK_SHADER_STAGE_MISS_BIT_KHR);
    EXPECT_EQ(any_hit.stage, VK_SHADER_STAGE_ANY_HIT_BIT_KHR);
    EXPECT_EQ(generation.push_bytes, 4u);
    ASSERT_EQ(generation.bindings.size(), 2u);
    EXPECT_EQ(generation.bindings[0].name, "scene");
    EXPECT_EQ(generation.bindings[0].type, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR);
    EXPECT_TRUE(generation.bindings[1].writes);
    ASSERT_EQ(any_hit.bindings.size(), 1u);
    EXPECT_EQ(any_hit.bindings[0].binding, 2u);
}

// Builds and traces wait for what they read, and for earlier users of the same scratch memory.
TEST(VulkanBarriers, OrderBuildsAndTraces)
{
    const VkPipelineStageFlags2 tracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
    const VkPipelineStageFlags2 building = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    const auto use = [&](vk::Use u) { return vk::meaning(u, tracing); };
    vk::UseState vertices;
    ASSERT_FALSE(vk::follow(vertices, use(vk::Use::copy_target), false));
    const auto input = vk::follow(vertices, use(vk::Use::build_input), false);
    ASSERT_TRUE(input);
    EXPECT_EQ(input->to_stages, building);
    EXPECT_EQ(input->to_access, VK_ACCESS_2_SHADER_READ_BIT);

    vk::UseState structure;
    ASSERT_FALSE(vk::follow(structure, use(vk::Use::build_target), false));
    const auto source = vk::follow(structure, use(vk::Use::build_source), false);
    ASSERT_TRUE(source);
    EXPECT_EQ(source->from_stages, building);
    EXPECT_NE(source->from_access & VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR, 0u);
    const auto traced = vk::follow(structure, use(vk::Use::traced), false);   // of another stage
    ASSERT_TRUE(traced);
    EXPECT_EQ(traced->to_stages, tracing);
    EXPECT_FALSE(vk::follow(structure, use(vk::Use::traced), false));
    const auto again = vk::follow(structure, use(vk::Use::build_target), false);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->from_stages & tracing, tracing);

    vk::UseState scratch;
    ASSERT_FALSE(vk::follow(scratch, use(vk::Use::build_target), false));
    ASSERT_TRUE(vk::follow(scratch, use(vk::Use::build_target), false));
}

// A device without the extensions works otherwise, and reports what it lacks.
TEST_F(VulkanRays, AcceptsADeviceWithoutRayTracing)
{
    static PFN_vkEnumerateDeviceExtensionProperties real;
    real = vkEnumerateDeviceExtensionProperties;
    const Replaced fewer(
        vkEnumerateDeviceExtensionProperties,
        +[](VkPhysicalDevice d, const char* layer, std::uint32_t* count, VkExtensionProperties* all) -> VkResult {
            const VkResult result = real(d, layer, count, all);
            for (std::uint32_t i = 0; all && i < *count; ++i)
                if (!std::strcmp(all[i].extensionName, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME))
                    all[i].extensionName[0] = 'x';
            return result;
        });
    const auto device = vk::Device::open();
    EXPECT_FALSE(device->traces_rays());
    EXPECT_EQ(device->info().no_rays.back(), VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME);
    const vk::Buffer buffer(device, "buffer", 64);
    EXPECT_THROW(buffer.address(), InternalError);
}

// The inputs and outputs of a build must be declared, as for all passes.
TEST_F(VulkanRays, RefusesUndeclaredUses)
{
    GNOMON_NEED_RAYS;
    Stage stage(device_, false);
    const vk::StructureBuild build{&stage.descs[0], &stage.bottoms[0], stage.scratch_at};
    EXPECT_THROW(stage.commands.pass("build")
                     .reads(stage.positions, vk::Use::build_input)
                     .writes(stage.bottoms[0].storage(), vk::Use::build_target)
                     .writes(stage.scratch, vk::Use::build_target)
                     .build([&](vk::Recorder& r) {
                         r.build({&build, 1}, stage.scratch);
                     }),
                 InternalError);
    EXPECT_THROW(stage.commands.pass("trace").writes(stage.answers).trace([&](vk::Recorder& r) {
        r.bind(stage.pipeline);
        r.set("scene", stage.top);
    }),
                 InternalError);
}

}   // namespace
}   // namespace gnomon::test
#else
TEST(VulkanRays, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
