// SPDX-License-Identifier: Apache-2.0
// bench shadow-textures: its output, consistent counts, and refused options.
#include "run_program.h"

namespace gnomon::test {
namespace {

using nlohmann::json;

#ifdef GNOMON_VULKAN

TEST(BenchShadowTextures, CountsTheWorkOfEachMethod)
{
    const Outcome outcome =
        run({"bench",      "shadow-textures", "--objects", "10",     "20",     "--dynamic", "0", "50",
             "100",        "--vertices",      "60",        "--size", "32x24",  "--frames",  "2", "--method",
             "per-caster", "depth",           "coherent",  "items",  "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const json document = outcome.json();
    EXPECT_EQ(document["rows"].size(), 2u * 3 * 4);
    EXPECT_EQ(document["exponents"].size(), 4u);
    for (const json& row : document["rows"]) {
        SCOPED_TRACE(row.dump());
        const int objects = row["objects"];
        const std::string method = row["method"];
        EXPECT_TRUE(row["identical_to_full"].get<bool>());
        EXPECT_NEAR(row["dynamic_percent"].get<double>(), 100.0 * row["movers"].get<int>() / objects, 1e-9);
        EXPECT_GT(row["frame_ms"].get<double>(), row["shadow_ms"].get<double>());
        if (method == "per-caster") {
            // Every receiver, at least for itself.
            EXPECT_EQ(row["textures_updated"], objects);
            EXPECT_GE(row["draws"], 2 * objects);
        } else if (method == "depth") {
            EXPECT_EQ(row["textures_updated"], objects);
            EXPECT_EQ(row["draws"], 2 * objects);
        } else if (row["movers"] == 0) {
            for (const char* nothing : {"draws", "copies", "textures_updated"}) EXPECT_EQ(row[nothing], 0) << nothing;
        } else {
            EXPECT_GE(row["draws"], row["movers"]);
            EXPECT_LE(row["draws"], 2 * objects);
        }
    }
}

// As published, textures of receivers nearer to the light than a change are made again, too: the result is the same.
TEST(BenchShadowTextures, FootprintsAloneMakeMoreTexturesAgain)
{
    const Outcome outcome =
        run({"bench", "shadow-textures", "--objects", "40", "--dynamic", "10", "--vertices", "60", "--size", "32x24",
             "--frames", "3", "--method", "coherent", "--by-footprints", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json rows = outcome.json()["rows"];
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0]["method"], "coherent");
    EXPECT_EQ(rows[1]["method"], "by-footprints");
    EXPECT_GT(rows[0]["textures_updated"], 0);
    EXPECT_GT(rows[1]["textures_updated"].get<double>(), rows[0]["textures_updated"].get<double>());
    for (const json& row : rows) EXPECT_TRUE(row["identical_to_full"].get<bool>());
}

// The previous method leaves out casters beside the receiver, as printed it draws them; the textures are the same.
TEST(BenchShadowTextures, PreviousMethodDrawsMoreAsPrinted)
{
    const auto rows = [](bool as_printed) {
        std::vector<std::string> words{"bench",    "shadow-textures", "--objects", "30",       "--vertices",
                                       "60",       "--size",          "64x64",     "--frames", "1",
                                       "--method", "per-caster",      "items",     "--json",   "--quiet"};
        if (as_printed) words.emplace_back("--as-printed");
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        const json document = outcome.json();
        EXPECT_EQ(document["as_printed"], as_printed);
        return document["rows"];
    };
    const json fair = rows(false), printed = rows(true);
    ASSERT_EQ(fair.size(), 2u);
    for (const json* list : {&fair, &printed})
        for (const json& row : *list) {
            EXPECT_TRUE(row["identical_to_full"].get<bool>());
            EXPECT_GT(row["printed_wrong_percent"], 0);
            EXPECT_LT(row["printed_wrong_percent"], 60);
        }
    EXPECT_LT(fair[0]["draws"].get<double>(), 0.8 * printed[0]["draws"].get<double>());
    EXPECT_EQ(fair[0]["draws_of_all_between"], printed[0]["draws"]);
    EXPECT_EQ(fair[0]["printed_wrong_percent"], printed[0]["printed_wrong_percent"]);
    EXPECT_EQ(fair[0]["printed_wrong_percent"], fair[1]["printed_wrong_percent"]) << "textures and items agree";
}

TEST(BenchShadowTextures, DoesNotUpdateReceiversFarFromDynamicObjects)
{
    const Outcome outcome =
        run({"bench", "shadow-textures", "--objects", "110", "1010", "4010", "--movers", "10", "--vertices", "60",
             "--size", "16x16", "--frames", "3", "--method", "coherent", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json rows = outcome.json()["rows"];
    ASSERT_EQ(rows.size(), 3u);
    for (const json& row : rows) {
        EXPECT_EQ(row["movers"], 10);
        EXPECT_TRUE(row["identical_to_full"].get<bool>());
        for (const char* same : {"touched", "draws", "copies", "textures_updated"})
            EXPECT_EQ(row[same], rows[0][same]) << same;
    }
    EXPECT_GT(rows[0]["textures_updated"], 10);   // some static objects receive dynamic shadows
}

TEST(BenchShadowTextures, ReportContainsBothFigures)
{
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "shadow-textures", "--objects", "5", "10", "--dynamic", "10", "50",
                                 "--vertices", "40", "--size", "16x16", "--frames", "1", "--report", folder / "r"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string html = bytes_of(folder / "r/index.html");
    for (const char* there : {"Figure 7: the whole frame", "Figure 7: the shadow pass", "Figure 8: the whole frame",
                              "Figure 8: the shadow pass", "23.4", "Figure 6 of the paper", "as printed"})
        EXPECT_NE(html.find(there), std::string::npos) << there;
}

TEST(BenchShadowTextures, ReportsMissingDriver)
{
    expect_failure(run({"bench", "shadow-textures", "--objects", "3"},
                       {{"VK_DRIVER_FILES", "/nowhere.json"}, {"VK_ICD_FILENAMES", "/nowhere.json"}}),
                   4, "Vulkan");
}

#else

TEST(BenchShadowTextures, ReportsBuildWithoutVulkan)
{
    expect_failure(run({"bench", "shadow-textures", "--objects", "3"}), 4, "Vulkan");
}

#endif

TEST(BenchShadowTextures, RefusesInvalidOptions)
{
    expect_failure(run({"bench", "shadow-textures", "--movers", "3", "--dynamic", "10"}), 2, "--dynamic");
    expect_failure(run({"bench", "shadow-textures", "--objects", "20", "5", "--movers", "10"}), 2, "only 5");
    expect_failure(run({"bench", "shadow-textures", "--objects", "0"}), 2, "--objects");
    expect_failure(run({"bench", "shadow-textures", "--objects", "5", "ten"}), 2, "takes 0 arguments");
    expect_failure(run({"bench", "shadow-textures", "--dynamic", "101"}), 2, "--dynamic");
    expect_failure(run({"bench", "shadow-textures", "--method", "none"}), 2, "none");
}

}   // namespace
}   // namespace gnomon::test
