// SPDX-License-Identifier: Apache-2.0
// The program on machines with and without Vulkan.
#include <fstream>

#include "run_program.h"
#include "vk_helpers.h"

namespace gnomon::test {
namespace {

#ifdef GNOMON_VULKAN

TEST(VulkanProgram, DevicesShowsTheChosenDeviceAndWhy)
{
    const auto devices = run({"devices", "--json"}).json()["vulkan"]["devices"];
    ASSERT_FALSE(devices.empty());
    int chosen = 0;
    for (const auto& device : devices) {
        chosen += device["chosen"].get<bool>();
        EXPECT_FALSE(device["reasons"].empty());
        EXPECT_GT(device["memory_bytes"].get<std::uint64_t>(), 0u);
        EXPECT_TRUE(device["traces_rays"].is_boolean());
    }
    EXPECT_EQ(chosen, 1);
}

TEST(VulkanProgram, DevicesWorksWithoutADriver)
{
    const Outcome outcome =
        run({"devices", "--json"}, {{"VK_DRIVER_FILES", "/nowhere.json"}, {"VK_ICD_FILENAMES", "/nowhere.json"}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(outcome.json()["vulkan"]["built"].get<bool>());
    EXPECT_TRUE(outcome.json()["vulkan"]["devices"].empty());
}

// A loader that is not a library is found before the real one.
TEST(VulkanProgram, DevicesWorksWithoutALoader)
{
    const ScratchFolder folder;
    for (const char* name : {"libvulkan.so.1", "libvulkan.so"}) std::ofstream(folder / name) << "not a library";
    const Outcome outcome = run({"devices", "--json"}, {{"LD_LIBRARY_PATH", folder.path().string()}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.json()["vulkan"]["missing"].get<std::string>().find("no loader"), std::string::npos);
}

TEST(VulkanProgram, RendersRasterisedFrames)
{
    const ScratchFolder folder;
    const auto json = run({"render", "builtin:cornell", "-o", folder / "a.png", "--renderer", "raster", "--size",
                           "64x64", "--frames", "1-1", "--json"})
                          .json();
    EXPECT_EQ(json["renderer"], "raster");
    EXPECT_FALSE(json["device"].get<std::string>().empty());
    EXPECT_GT(json["frames"][0]["draws"].get<int>(), 0);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.png"});
}

TEST(VulkanProgram, CountersOfKeptFramesAreNull)
{
    const ScratchFolder folder;
    const auto render = [&](const char* frames) {
        return run({"render", "builtin:cornell", "-o", folder / "{frame}.png", "--renderer", "raster", "--size",
                    "16x16", "--frames", frames, "--resume", "--json"})
            .json();
    };
    const auto made = render("1-2"), all_kept = render("1-2"), one_kept = render("2-3");
    EXPECT_TRUE(made["device"].is_string());
    EXPECT_TRUE(all_kept["device"].is_null());
    EXPECT_EQ(one_kept["device"], made["device"]);
    EXPECT_FALSE(made["frames"][1].contains("kept"));
    EXPECT_FALSE(one_kept["frames"][1].contains("kept"));
    EXPECT_TRUE(one_kept["frames"][1]["indirect"].contains("gather"));
    for (const auto& frame : {all_kept["frames"][1], one_kept["frames"][0]}) {
        EXPECT_TRUE(frame["kept"].get<bool>());
        EXPECT_EQ(frame["ms"], 0);
        EXPECT_TRUE(frame["shadow"]["rays"].is_null());
        EXPECT_TRUE(frame["indirect"]["clusters"].is_null());
        EXPECT_TRUE(frame["draws"].is_null());
        EXPECT_FALSE(frame["indirect"].contains("gather"));
    }
}

TEST(VulkanProgram, ReportsWhereIndirectLightIsComputed)
{
    const ScratchFolder folder;
    const auto indirect = [&](const char* how, const char* on = "auto") {
        return run({"render", "builtin:cornell", "-o", folder / "a.png", "--renderer", "raster", "--size", "64x64",
                    "--frame", "1", "--indirect", how, "--indirect-on", on, "--json"})
            .json()["frames"][0]["indirect"];
    };
    const auto by_device = indirect("visible", "vulkan"), by_processor = indirect("visible", "cpu");
    EXPECT_EQ(by_device["cut"], "vulkan");
    EXPECT_EQ(by_device["gather"], "vulkan");
    const auto devices = run({"devices", "--json"}).json();
    EXPECT_EQ(by_device["visibility"] == "vulkan", devices["vulkan"]["devices"][0]["traces_rays"].get<bool>());
    EXPECT_EQ(by_processor["cut"], "cpu");
    EXPECT_EQ(by_processor["visibility"], "cpu");
    EXPECT_EQ(by_processor["gather"], "cpu");
    const auto visible = indirect("visible"), quadtree = indirect("quadtree"), rsm = indirect("rsm");
    EXPECT_EQ(visible["gather"] == "vulkan", visible["cut"] == "vulkan");
    EXPECT_GT(visible["rays"].get<int>(), 0);
    EXPECT_EQ(quadtree["light_map"], "vulkan");
    EXPECT_EQ(quadtree["gather"], "vulkan");
    EXPECT_EQ(quadtree["rays"], 0);
    EXPECT_GT(quadtree["clusters"].get<int>(), 50);
    EXPECT_EQ(rsm["clusters"], 256);
    EXPECT_FALSE(indirect("off").contains("visibility"));
}

TEST(VulkanProgram, BenchIndirectRunsOnTheDevice)
{
    const auto json =
        run({"bench",      "indirect", "builtin:cornell", "--renderer", "raster",   "--frames", "1-3",
             "--size",     "64x64",    "--spp",           "16",         "--judged", "1",        "--method",
             "quadtree:5", "--method", "rsm:64:1",        "--method",   "visible",  "--json"})
            .json();
    EXPECT_FALSE(json["device"].get<std::string>().empty());
    ASSERT_EQ(json["rows"].size(), 3u);
    for (int r = 0; r < 2; ++r) {
        const auto& row = json["rows"][static_cast<std::size_t>(r)];
        EXPECT_EQ(row["on"], "vulkan");
        EXPECT_GT(row["ms_moving"].get<double>(), 0);
        EXPECT_GT(row["clusters"].get<int>(), 20);
        EXPECT_LT(row["nrmse_brute"].get<double>(), 0.5);
        EXPECT_GT(row["dirty_pixels"].get<int>(), 0);
    }
    EXPECT_EQ(json["rows"][2]["on"], "cpu");
    const Outcome missing = run({"bench", "indirect", "builtin:cornell", "--renderer", "raster"},
                                {{"VK_DRIVER_FILES", "/nowhere.json"}, {"VK_ICD_FILENAMES", "/nowhere.json"}});
    EXPECT_EQ(missing.code, 4);
    EXPECT_EQ(std::count(missing.err.begin(), missing.err.end(), '\n'), 1) << missing.err;
}

TEST(VulkanProgram, RasterWithoutADriverIsAMissingError)
{
    const ScratchFolder folder;
    const Outcome outcome =
        run({"render", "builtin:cornell", "-o", folder / "a.png", "--renderer", "raster", "--size", "64x64"},
            {{"VK_DRIVER_FILES", "/nowhere.json"}, {"VK_ICD_FILENAMES", "/nowhere.json"}});
    EXPECT_EQ(outcome.code, 4);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find("Vulkan"), std::string::npos) << outcome.err;
    EXPECT_TRUE(names_in(folder.path()).empty());
}

// Renders six frames with a loader that fails as `fault` says (failing_vulkan.cpp); with "" it does not fail. Quiet: on
// a busy machine there would be progress lines.
Outcome video(const ScratchFolder& folder, const std::string& fault)
{
    return run({"render", "builtin:cornell", "-o", folder / "{frame:04}.png", "--renderer", "raster", "--size", "48x48",
                "--frames", "1-6", "--exposure", "0", "--quiet"},
               {{"LD_LIBRARY_PATH", places::failing_vulkan}, {"GNOMON_TEST_VULKAN_FAULT", fault}});
}

TEST(VulkanProgram, DeviceFaultsAreCode4OneLineAndCompleteFrames)
{
    if (places::failing_vulkan.empty()) GTEST_SKIP() << "no Vulkan loader";
    const ScratchFolder undisturbed;
    const Outcome whole = video(undisturbed, "");
    ASSERT_EQ(whole.code, 0) << whole.err;
    ASSERT_EQ(names_in(undisturbed.path()).size(), 6u);

    struct Fault {
        const char *name, *about;
        bool begins;   // so late that there are frames
    };
    for (const Fault& fault :
         {Fault{"lost:1", "lost", false}, Fault{"lost:60", "lost", true},
          Fault{"waiting:1", "waiting for the device failed", false},
          Fault{"waiting:58", "waiting for the device failed", true}, Fault{"memory:1", "out of device memory", false},
          Fault{"memory:4", "out of device memory", false}, Fault{"feature", "multiDrawIndirect", false},
          Fault{"extension", "VK_KHR_push_descriptor", false}}) {
        SCOPED_TRACE(fault.name);
        const ScratchFolder folder;
        expect_failure(video(folder, fault.name), 4, fault.about);
        const std::vector<std::string> frames = names_in(folder.path());
        EXPECT_EQ(!frames.empty(), fault.begins);
        EXPECT_LT(frames.size(), 6u);
        for (const std::string& frame : frames)
            EXPECT_EQ(bytes_of(folder / frame), bytes_of(undisturbed / frame)) << frame;
    }
}

TEST(VulkanProgram, RefusesOptionsOfTheOtherRenderer)
{
    const ScratchFolder folder;
    const std::vector<std::string> base{"render", "builtin:cornell", "-o", folder / "a.png", "--size", "64x64"};
    const auto code = [&](std::vector<std::string> more) {
        more.insert(more.begin(), base.begin(), base.end());
        return run(more).code;
    };
    EXPECT_EQ(code({"--renderer", "raster", "--shadow-culling", "off"}), 2);
    EXPECT_EQ(code({"--renderer", "raster", "--overlay", "clusters", "--indirect", "quadtree"}), 2);
    EXPECT_EQ(code({"--shadow-textures", "depth"}), 2);
    EXPECT_EQ(code({"--shadow-filter", "0"}), 2);
    EXPECT_EQ(code({"--as-printed"}), 2);
    EXPECT_EQ(code({"--cluster-shadows"}), 2);
    EXPECT_EQ(code({"--cluster-shadows", "--indirect", "quadtree", "--renderer", "raster"}), 2);
    EXPECT_EQ(code({"--separate-trees"}), 2);
    EXPECT_EQ(code({"--separate-trees", "--indirect", "quadtree", "--renderer", "raster"}), 2);
    EXPECT_EQ(code({"--indirect", "quadtree", "--indirect-level", "8"}), 2);
    EXPECT_EQ(code({"--renderer", "raster", "--overlay", "shadow-states"}), 2);
    EXPECT_EQ(code({"--renderer", "raster", "--overlay", "redrawn", "--lights", "0"}), 2);
#ifdef GNOMON_VIEWER
    EXPECT_EQ(run({"view", "builtin:cornell", "--overlay", "redrawn"}).code, 2);
#endif
}

#else
TEST(VulkanProgram, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon::test
