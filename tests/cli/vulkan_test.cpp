// SPDX-License-Identifier: Apache-2.0
// The program on machines with and without Vulkan.
#include <fstream>

#include "run_program.h"
#include "vk_helpers.h"

namespace gnomon::test {
namespace {

#ifdef GNOMON_VULKAN

TEST(VulkanProgram, DevicesSayWhichIsChosenAndWhy)
{
    const auto devices = run({"devices", "--json"}).json()["vulkan"]["devices"];
    ASSERT_FALSE(devices.empty());
    int chosen = 0;
    for (const auto& device : devices) {
        chosen += device["chosen"].get<bool>();
        EXPECT_FALSE(device["reasons"].empty());
        EXPECT_GT(device["memory_bytes"].get<std::uint64_t>(), 0u);
    }
    EXPECT_EQ(chosen, 1);
}

TEST(VulkanProgram, DevicesAnswerWithoutADriver)
{
    const Outcome outcome =
        run({"devices", "--json"}, {{"VK_DRIVER_FILES", "/nowhere.json"}, {"VK_ICD_FILENAMES", "/nowhere.json"}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(outcome.json()["vulkan"]["built"].get<bool>());
    EXPECT_TRUE(outcome.json()["vulkan"]["devices"].empty());
}

// A loader that is no library stands before the real one.
TEST(VulkanProgram, DevicesAnswerWithoutALoader)
{
    const ScratchFolder folder;
    for (const char* name : {"libvulkan.so.1", "libvulkan.so"}) std::ofstream(folder / name) << "no library";
    const Outcome outcome = run({"devices", "--json"}, {{"LD_LIBRARY_PATH", folder.path().string()}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.json()["vulkan"]["missing"].get<std::string>().find("no loader"), std::string::npos);
}

#else
TEST(VulkanProgram, LeftOut)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon::test
