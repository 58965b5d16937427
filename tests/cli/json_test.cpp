// SPDX-License-Identifier: Apache-2.0
// The JSON documents: their keys are a stable interface.
#include "run_program.h"

namespace gnomon::test {
namespace {

using nlohmann::json;

std::vector<std::string> keys_of(const json& object)
{
    std::vector<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.push_back(key);
    std::sort(keys.begin(), keys.end());
    return keys;
}

using Keys = std::vector<std::string>;

TEST(Json, KeysOfRender)
{
    const ScratchFolder folder;
    const std::string out = folder / "{frame:03}.png";
    const Outcome outcome =
        run({"render", "builtin:cornell", "-o", out, "--frames", "2-4", "--size", "48x32", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"device", "frames", "height", "instruction_set", "isa", "peak_memory_bytes",
                                       "renderer", "scene", "version", "width"}));
    EXPECT_EQ(document["isa"], "auto");
    EXPECT_FALSE(document["instruction_set"].get<std::string>().empty());
    EXPECT_EQ(document["scene"], "builtin:cornell");
    EXPECT_EQ(document["renderer"], "trace");
    EXPECT_EQ(document["width"], 48);
    EXPECT_EQ(document["height"], 32);
    EXPECT_GT(document["peak_memory_bytes"].get<std::uint64_t>(), 1u << 20);
    ASSERT_EQ(document["frames"].size(), 3u);
    for (int i = 0; i < 3; ++i) {
        const json& frame = document["frames"][static_cast<std::size_t>(i)];
        EXPECT_EQ(keys_of(frame), (Keys{"draws", "exposure", "file", "frame", "indirect", "ms", "samples", "shadow",
                                        "stages", "time"}));
        EXPECT_EQ(keys_of(frame["samples"]), (Keys{"pixels", "shaded", "taken"}));
        EXPECT_EQ(keys_of(frame["shadow"]), (Keys{"rays", "rays_dynamic_only", "rays_skipped"}));
        EXPECT_EQ(keys_of(frame["indirect"]), (Keys{"clusters", "rays"}));
        EXPECT_EQ(frame["frame"], i + 2);
        EXPECT_NEAR(frame["time"].get<double>(), (i + 1) / 24.0, 1e-9);
        EXPECT_GT(frame["ms"].get<double>(), 0);
        double stages = 0;
        for (const auto& [name, ms] : frame["stages"].items()) stages += ms.get<double>();
        EXPECT_GT(frame["stages"]["rays"].get<double>(), 0);
        EXPECT_LE(stages, 1.001 * frame["ms"].get<double>());
        EXPECT_GT(frame["shadow"]["rays"].get<int>(), 0);
        EXPECT_TRUE(std::filesystem::exists(frame["file"].get<std::string>()));
    }
}

TEST(Json, KeysOfRenderWithCountingKdTree)
{
    const ScratchFolder folder;
    const Outcome outcome = run({"render", "builtin:cornell", "-o", folder / "p.png", "--frame", "2", "--size", "48x32",
                                 "--accelerator", "kdtree", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json frame = outcome.json()["frames"][0];
    EXPECT_EQ(keys_of(frame), (Keys{"draws", "exposure", "file", "frame", "indirect", "kdtree", "ms", "samples",
                                    "shadow", "stages", "time"}));
    EXPECT_EQ(keys_of(frame["kdtree"]), (Keys{"indirect", "primary", "reflection", "refraction", "shadow"}));
    for (const json& work : frame["kdtree"]) EXPECT_EQ(keys_of(work), (Keys{"nodes", "tests"}));
    EXPECT_GT(frame["kdtree"]["shadow"]["nodes"].get<int>(), frame["shadow"]["rays"].get<int>());
    EXPECT_GT(frame["kdtree"]["primary"]["tests"].get<int>(), 0);
}

TEST(Json, KeysOfInfo)
{
    const Outcome outcome = run({"info", "builtin:cornell", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    for (const char* key :
         {"triangles", "triangles_dynamic", "objects", "objects_dynamic", "lights", "cameras", "frames", "warnings"})
        ASSERT_TRUE(document.contains(key)) << key;
    EXPECT_EQ(document["frames"], 40);
    EXPECT_EQ(document["lights"], 1);
    EXPECT_EQ(document["cameras"], 1);
    EXPECT_EQ(document["objects_dynamic"], 1);   // the ball
    EXPECT_GT(document["triangles"].get<int>(), document["triangles_dynamic"].get<int>());
    EXPECT_EQ(document["warnings"], json::array());
    EXPECT_NE(outcome.err.find("triangles"), std::string::npos) << "text is written to standard error";
}

TEST(Json, KeysOfDevices)
{
    const Outcome outcome = run({"devices", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"cpu", "vulkan"}));
    EXPECT_GE(document["cpu"]["threads"].get<int>(), 1);
    EXPECT_GE(document["cpu"]["packet_width"].get<int>(), 4);
    EXPECT_TRUE(document["vulkan"]["devices"].is_array());
}

TEST(Json, KeysOfBenchTrace)
{
    const Outcome outcome = run({"bench", "trace", "builtin:cornell", "--size", "64x64", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"bare_ms", "bytes", "frame_ms", "load_ms", "ratio", "rays", "update_ms"}));
    for (const auto& [key, value] : document.items()) EXPECT_GE(value.get<double>(), 0) << key;
    EXPECT_GE(document["rays"].get<int>(), 64 * 64);
}

// One of the two cameras sees a triangle, the other nothing that could be in shadow.
TEST(Json, BenchesUseTheNamedCamera)
{
    const ScratchFolder folder;
    const float corners[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
    std::ofstream(folder / "corners.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(corners), sizeof corners);
    std::ofstream(folder / "two.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0}, {"name": "at it", "camera": 0, "translation": [0, 0, 3]},
                  {"name": "away", "camera": 1, "translation": [0, 0, 3], "rotation": [0, 1, 0, 0]}],
        "cameras": [{"name": "at it", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}},
                    {"name": "away", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "buffers": [{"byteLength": 36, "uri": "corners.bin"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]})";
    const auto bench = [&](const std::string& what, const std::string& camera) {
        const Outcome outcome = run({"bench", what, (folder / "two.gltf").string(), "--camera", camera, "--light",
                                     "point 0 0 3 1 1 1", "--size", "32x32", "--json", "--quiet"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.code == 0 ? outcome.json() : json();
    };
    EXPECT_GT(bench("trace", "at it")["rays"].get<int>(), bench("trace", "away")["rays"].get<int>());
    EXPECT_GT(bench("culling", "0")["frames"][0]["off"]["rays"].get<int>(), 0);
    EXPECT_EQ(bench("culling", "1")["frames"][0]["off"]["rays"].get<int>(), 0);
}

TEST(Json, KeysOfBenchCulling)
{
    const Outcome outcome = run({"bench", "culling", "builtin:cornell", "--frames", "2-4", "--size", "48x32",
                                 "--repeat", "2", "--max-depth", "2", "--moving-lights", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"frames", "summary"}));
    ASSERT_EQ(document["frames"].size(), 3u);
    for (const json& frame : document["frames"]) {
        EXPECT_EQ(keys_of(frame), (Keys{"certified", "frame", "off", "paper"}));
        EXPECT_EQ(keys_of(frame["off"]), (Keys{"ms", "nodes", "rays", "tests", "wall_ms"}));
        EXPECT_EQ(keys_of(frame["paper"]), (Keys{"dynamic_only", "extra_tests_per_pixel", "ms", "nodes", "rays",
                                                 "skipped", "tests", "traced", "wrong"}));
        EXPECT_EQ(keys_of(frame["certified"]), (Keys{"certificates", "dynamic_only", "ms", "nodes", "partial", "rays",
                                                     "skipped", "tests", "wall_ms", "wrong"}));
    }
    EXPECT_EQ(keys_of(document["summary"]["paper"]),
              (Keys{"bytes", "extra_tests_per_pixel", "nodes_saved_best", "nodes_saved_best_frame", "nodes_saved_mean",
                    "nodes_saved_of_totals", "tests_saved_best", "tests_saved_best_frame", "tests_saved_mean",
                    "tests_saved_of_totals", "wrong_mean"}));
    EXPECT_EQ(keys_of(document["summary"]["tree"]), (Keys{"group_splits", "nodes"}));
    EXPECT_EQ(
        keys_of(document["summary"]["certified"]),
        (Keys{"bytes", "bytes_per_triangle_light", "first_frame_ratio", "mask_bytes", "most_evidence_bytes",
              "moving_lights_ratio", "nodes_saved_best", "nodes_saved_best_frame", "nodes_saved_mean",
              "nodes_saved_of_totals", "speedup_mean", "speedup_steady", "tests_saved_best", "tests_saved_best_frame",
              "tests_saved_mean", "tests_saved_of_totals", "visible_triangles", "worst_frame_ratio", "wrong_total"}));
    EXPECT_EQ(document["summary"]["certified"]["wrong_total"], 0);
}

TEST(Json, KeysOfBenchCullingWithoutCountsAndWithOneMethod)
{
    const Outcome outcome = run({"bench", "culling", "builtin:cornell", "--frames", "1-2", "--size", "48x32",
                                 "--no-counts", "--method", "certified", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document["frames"][0]), (Keys{"certified", "frame", "off"}));
    EXPECT_EQ(keys_of(document["frames"][0]["off"]), (Keys{"ms", "rays", "wall_ms"}));
    EXPECT_EQ(keys_of(document["summary"]), Keys{"certified"});
}

TEST(Json, BenchCullingAsPrintedDiffersFromTheDefault)
{
    const auto summary = [](const std::vector<std::string>& more) {
        std::vector<std::string> words{"bench",  "culling",     "builtin:kinetic", "--frames", "60-63",  "--size",
                                       "128x72", "--no-counts", "--method",        "paper",    "--json", "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json()["summary"]["paper"];
    };
    const json read = summary({}), printed = summary({"--as-printed"});
    EXPECT_FALSE(read.contains("as_printed"));
    EXPECT_EQ(printed["as_printed"], true);
    EXPECT_NE(printed["extra_tests_per_pixel"], read["extra_tests_per_pixel"]);
    EXPECT_NE(printed["wrong_mean"], read["wrong_mean"]) << "a moving shadow is stored, or not";
    expect_failure(run({"bench", "culling", "builtin:cornell", "--as-printed", "--method", "certified"}), 2,
                   "--as-printed");
}

TEST(Json, BenchCullingAtStepsWithReadings)
{
    const Outcome outcome =
        run({"bench",      "culling", "builtin:cornell", "--frames", "1-3",      "--size", "48x32",     "--step",
             "0.5",        "0.25",    "--start",         "-0.5",     "--method", "paper",  "--reading", "cached",
             "as-printed", "--tree",  "mixed",           "--json",   "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"frames", "steps", "summary"}));
    EXPECT_EQ(document["frames"][2]["time"], 0.5);
    EXPECT_EQ(keys_of(document["frames"][0]["readings"]), (Keys{"as-printed", "cached"}));
    EXPECT_EQ(keys_of(document["frames"][0]["paper"]["traced"]),
              (Keys{"dynamic", "not_seen", "not_shadowed", "partially_occluded", "partly_shadowed"}));
    EXPECT_GT(document["frames"][1]["readings"]["cached"]["cache_hits"], 0);
    EXPECT_EQ(keys_of(document["summary"]["readings"]), (Keys{"as-printed", "cached"}));
    ASSERT_EQ(document["steps"].size(), 2u);
    EXPECT_EQ(document["steps"][1]["step"], 0.25);
    EXPECT_EQ(document["steps"][0]["paper"]["wrong_mean"], document["summary"]["paper"]["wrong_mean"]);

    expect_failure(run({"bench", "culling", "builtin:cornell", "--start", "1"}), 2, "--step");
    expect_failure(run({"bench", "culling", "builtin:cornell", "--no-counts", "--reading", "cached"}), 2,
                   "--no-counts");
    expect_failure(run({"bench", "culling", "builtin:cornell", "--frames", "1-1", "--size", "16x16", "--step", "1",
                        "0.3", "--method", "paper"}),
                   2, "0.3");
    expect_failure(run({"render", "builtin:cornell", "--as-printed", "-o", "x.png"}), 2, "--shadow-culling paper");
}

TEST(Json, BenchLights)
{
    const Outcome outcome = run({"bench", "lights", "builtin:cornell", "--size", "48x32", "--frames", "1-2",
                                 "--samples", "4", "256", "--check", "8", "--side", "0.5", "--json", "--quiet"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    EXPECT_EQ(keys_of(document), (Keys{"bytes", "opponents", "rows", "soft_textures", "truth_rmse"}));
    ASSERT_EQ(document["rows"].size(), 1u);
    const json row = document["rows"][0];
    EXPECT_EQ(keys_of(row), (Keys{"dark", "light", "listed_triangles", "lit", "max_abs", "ms_cold", "ms_steady",
                                  "penumbra", "points", "rmse", "segments", "soft_rmse", "unproven", "wrong"}));
    EXPECT_GT(row["segments"], 1000);
    EXPECT_EQ(row["wrong"], 0);
    EXPECT_NEAR(row["lit"].get<double>() + row["dark"].get<double>() + row["penumbra"].get<double>() +
                    row["unproven"].get<double>(),
                1, 1e-9);
    EXPECT_GT(row["lit"], 0.1);
    EXPECT_GT(row["penumbra"], 0.05);
    EXPECT_LE(row["rmse"], 0.02);
    ASSERT_EQ(document["opponents"].size(), 2u);
    EXPECT_EQ(document["opponents"][1]["samples"], 256);
    EXPECT_GT(document["opponents"][0]["rmse"], document["opponents"][1]["rmse"]);
    expect_failure(run({"bench", "lights", "builtin:cornell", "--frames", "41-41"}), 2, "--frames");
}

TEST(Json, WrittenToAFileLeavesTextOnStandardOutput)
{
    const ScratchFolder folder;
    const Outcome outcome = run({"info", "builtin:cornell", "--json=" + (folder / "info.json").string()});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("triangles"), std::string::npos);
    EXPECT_EQ(json::parse(bytes_of(folder / "info.json"))["frames"], 40);
    EXPECT_EQ(names_in(folder.path()), Keys{"info.json"});
}

TEST(Json, IsNotWrittenOnFailure)
{
    const ScratchFolder folder;
    expect_failure(run({"info", (folder / "no.aff").string(), "--json=" + (folder / "info.json").string()}), 3,
                   "no.aff");
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(Config, SetsOptionsAndCommandLineTakesPrecedence)
{
    const ScratchFolder folder;
    std::ofstream(folder / "c.json") << R"({"size": "20x10", "samples": 2, "json": true, "frame": 3,
                                            "light": ["point 0 0 0 1 1 1", "point 0 0.5 0 1 1 1"], "resume": false})";
    const Outcome outcome =
        run({"render", "builtin:cornell", "--config", folder / "c.json", "-o", folder / "a.png", "--frame", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.json()["width"], 20);
    EXPECT_EQ(outcome.json()["frames"][0]["frame"], 2);
}

TEST(Config, ErrorsNameThePlaceInTheFile)
{
    const ScratchFolder folder;
    const std::string file = folder / "c.json";
    const std::vector<std::pair<std::string, std::string>> faults = {
        {"", "byte"},
        {"[1]", "object"},
        {"{\"size\": \"20x10\"", "byte"},
        {"{\"sise\": \"20x10\"}", "/sise: render has no such option; did you mean 'size'"},
        {"{\"size\": 20}", "/size: --size 20: expected WxH"},
        {"{\"samples\": \"many\"}", "/samples"},
        {"{\"resume\": 1}", "/resume: expected true or false"},
        {"{\"light\": [1]}", "/light"},
        {"{\"size\": null}", "/size"},
    };
    for (const auto& [text, about] : faults) {
        std::ofstream(file) << text;
        SCOPED_TRACE(text);
        expect_failure(run({"render", "builtin:cornell", "--config", file, "-o", folder / "a.png"}), 3, about);
    }
    expect_failure(run({"info", "builtin:cornell", "--config", folder / "none.json"}), 3, "none.json");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"c.json"});
}

// Values that were not measured are null, not 0.
TEST(Json, UnmeasuredFieldsAreNull)
{
    const Outcome culling = run({"bench", "culling", "builtin:cornell", "--frames", "1-1", "--size", "16x16",
                                 "--no-counts", "--method", "certified", "--json"});
    ASSERT_EQ(culling.code, 0) << culling.err;
    EXPECT_TRUE(culling.json()["summary"]["certified"]["worst_frame_ratio"].is_null());

    const Outcome indirect = run({"bench", "indirect", "builtin:cornell", "--frames", "1-1", "--size", "16x16", "--spp",
                                  "2", "--lights", "0", "--json"});
    ASSERT_EQ(indirect.code, 0) << indirect.err;
    EXPECT_TRUE(indirect.json()["reference_noise"].is_null());
}

}   // namespace
}   // namespace gnomon::test
