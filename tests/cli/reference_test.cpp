// SPDX-License-Identifier: Apache-2.0
// render --reference and bench indirect, from the command line.
#include <fstream>

#include "run_program.h"

namespace gnomon::test {
namespace {

using nlohmann::json;

std::vector<std::string> reference(const std::string& out, std::vector<std::string> more)
{
    std::vector<std::string> arguments{"render", "builtin:cornell", "-o",     out,          "--frame", "3",
                                       "--size", "32x24",           "--json", "--exposure", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

TEST(ReferenceImage, ReportsMethodAndNoise)
{
    const ScratchFolder folder;
    double noise[2];
    for (int i = 0; i < 2; ++i) {
        const Outcome outcome = run(reference(folder / "p.exr", {"--reference", "--spp", i == 0 ? "16" : "256"}));
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const json document = outcome.json();
        EXPECT_EQ(document["reference"], (json{{"spp", i == 0 ? 16 : 256}, {"bounces", "all"}, {"seed", 0}}));
        noise[i] = document["frames"][0]["indirect"]["noise"].get<double>();
        EXPECT_GT(document["frames"][0]["indirect"]["rays"].get<int>(), 32 * 24);
    }
    EXPECT_GT(noise[1], 0);
    EXPECT_LT(noise[1], noise[0] / 2);
}

TEST(ReferenceImage, SameSeedGivesSameBytes)
{
    const ScratchFolder folder;
    const auto bytes = [&](std::vector<std::string> more) {
        const std::string out = folder / "p.exr";
        more.insert(more.end(), {"--reference", "--spp", "16"});
        const Outcome outcome = run(reference(out, more));
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return bytes_of(out);
    };
    const auto first = bytes({"--seed", "7", "--threads", "1"});
    EXPECT_EQ(first, bytes({"--seed", "7", "--threads", "3"}));
    EXPECT_NE(first, bytes({"--seed", "8"}));
}

TEST(ReferenceImage, ZeroBouncesGiveDirectLight)
{
    const ScratchFolder folder;
    const auto image = [&](const std::string& name, std::vector<std::string> more) {
        std::string out = folder / name;
        const Outcome outcome = run(reference(out, std::move(more)));
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return out;
    };
    const std::string none = image("none.exr", {"--reference", "--spp", "4", "--bounces", "0"});
    const std::string one = image("one.exr", {"--reference", "--spp", "64", "--bounces", "1"});
    const std::string off = image("off.exr", {"--indirect", "off", "--samples", "1"});
    EXPECT_EQ(bytes_of(image("visible.exr", {"--bounces", "0", "--samples", "1"})), bytes_of(off));
    const auto difference = [&](const std::string& a, const std::string& b) {
        return run({"compare", a, b, "--layer", "direct", "--json"}).json()["max_abs"].get<double>();
    };
    EXPECT_EQ(difference(none, off), 0);
    EXPECT_EQ(difference(one, off), 0);
    EXPECT_GT(run({"compare", one, none, "--json"}).json()["rmse"].get<double>(), 1e-3);
}

TEST(ReferenceImage, RefusesContradictingOptions)
{
    const ScratchFolder folder;
    expect_failure(run(reference(folder / "p.png", {"--reference", "--indirect", "visible"})), 2, "--indirect");
    for (const char* option : {"--spp", "--seed"})
        expect_failure(run(reference(folder / "p.png", {option, "3"})), 2, "needs --reference");
    expect_failure(run(reference(folder / "p.png", {"--reference", "--spp", "0"})), 2, "spp");
    expect_failure(run(reference(folder / "p.png", {"--indirect", "quadtree", "--bounces", "2"})), 2,
                   "--bounces needs");
    expect_failure(run(reference(folder / "p.png", {"--bounces", "many"})), 2, "all or a whole number");
}

TEST(BenchIndirect, KeysOfDocument)
{
    const ScratchFolder folder;
    const std::filesystem::path kept = folder.path() / "kept";
    const auto bench = [&] {
        return run({"bench", "indirect", "builtin:cornell", "--frames", "1-4", "--size", "96x96", "--spp", "64",
                    "--judged", "2", "--keep-references", kept.string(), "--threads", "2", "--json"});
    };
    const Outcome outcome = bench();
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json document = outcome.json();
    for (const char* key : {"device", "reference_noise", "rows"}) EXPECT_TRUE(document.contains(key)) << key;
    EXPECT_EQ(document["judged_frames"], (json{1, 3}));
    EXPECT_GT(document["reference_noise"].get<double>(), 0);
    ASSERT_EQ(document["rows"].size(), 1u);
    const json& row = document["rows"][0];
    for (const char* key :
         {"method", "clusters", "ms_cold", "ms_static", "ms_moving", "ms_repair", "ms_rebuild", "dirty_pixels",
          "dirty_nodes", "nrmse", "nrmse_brute", "energy_ratio", "flicker", "rays", "bytes"})
        EXPECT_TRUE(row.contains(key)) << key;
    EXPECT_EQ(row["method"], "visible");
    // The reference's own noise aside, which is most of the error with 64 paths.
    const double noise = document["reference_noise"].get<double>(), nrmse = row["nrmse"].get<double>();
    EXPECT_LT(nrmse * nrmse - noise * noise, 0.22 * 0.22);
    EXPECT_NEAR(row["energy_ratio"].get<double>(), 1, 0.05);
    EXPECT_GT(row["rays"].get<int>(), 0);

    // With stored references the figures are the same; an incomplete file counts as none.
    const auto same_as_before = [&](const Outcome& again) {
        const json rows = again.json()["rows"];
        for (const char* key : {"nrmse", "energy_ratio", "flicker", "flicker_floor", "rays"})
            EXPECT_EQ(rows[0][key], row[key]) << key;
    };
    EXPECT_GT(names_in(kept).size(), 2u);
    same_as_before(bench());
    for (const std::string& name : names_in(kept)) std::filesystem::resize_file(kept / name, 40);
    same_as_before(bench());
}

// An open box in the studio: the reference bounces the image's own light, as the method does, and leaves its direct
// light out. Held against the lights that approximate the image, the energy was 1.16.
TEST(BenchIndirect, AnImagesLightIsHeldAgainstTheImage)
{
    const ScratchFolder folder;
    const std::string box = folder / "box.obj";
    std::ofstream(box) << "v -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\nv -1 0 1\nv 1 0 1\nv 1 2 1\nv -1 2 1\n"
                          "f 1 2 3 4\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 6 2\nf 4 3 7 8\n";
    const Outcome outcome = run({"bench", "indirect", box, "--frames", "1-1", "--judged", "1", "--size", "96x96",
                                 "--spp", "256", "--bounces", "1", "--threads", "2", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json row = outcome.json()["rows"][0];
    EXPECT_NEAR(row["energy_ratio"].get<double>(), 1, 0.05);
}

TEST(BenchIndirect, ComparesPointsAsFarApartAsAsked)
{
    const auto points = [](const char* every) {
        const Outcome outcome = run({"bench", "indirect", "builtin:cornell", "--frames", "1-1", "--size", "64x64",
                                     "--spp", "4", "--judged", "1", "--judged-every", every, "--json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json()["points"].get<int>();
    };
    EXPECT_EQ(points("8"), 64);
    EXPECT_EQ(points("2"), 1024);
    expect_failure(run({"bench", "indirect", "builtin:cornell", "--judged-every", "3"}), 2, "--judged-every");
}

TEST(BenchIndirect, RefusesUnknownMethods)
{
    for (const char* method : {"guess", "visible:3", "quadtree", "rsm"})
        expect_failure(run({"bench", "indirect", "builtin:cornell", "--method", method}), 2, "no method");
    for (const char* method : {"quadtree:0", "quadtree:8", "rsm:0", "rsm:many", "rsm:64x"})
        expect_failure(run({"bench", "indirect", "builtin:cornell", "--method", method}), 2, "the number must be");
    expect_failure(run({"bench", "indirect", "builtin:cornell", "--method", "quadtree:5:2"}), 2, "the margin must be");
    for (const char* method : {"rsm:64:", "rsm:64:0", "rsm:64:nan", "rsm:64:9"})
        expect_failure(run({"bench", "indirect", "builtin:cornell", "--method", method}), 2, "the radius must be");
    // In a list as well, after which the scene is still recognised.
    expect_failure(run({"bench", "indirect", "--method", "visible", "rsm", "builtin:cornell"}), 2, "no method 'rsm'");
    expect_failure(run({"bench", "indirect", "--method", "rsm:64", "rsm:0", "builtin:cornell"}), 2,
                   "the number must be");
    expect_failure(run({"bench", "indirect", "--method", "visible", "more", "builtin:cornell"}), 2, "takes 1 argument");
}

// More clusters and more samples approach the sum that both approximate; neither reaches the reference.
TEST(BenchIndirect, ComparesMethodsWithoutVisibilityWithTheFullSum)
{
    const Outcome outcome =
        run({"bench",    "indirect", "builtin:cornell", "--frames",    "1-3",      "--size",     "96x96",
             "--spp",    "64",       "--judged",        "1",           "--method", "quadtree:6", "quadtree:4",
             "--method", "rsm:64:1", "rsm:1024:1",      "--receivers", "full",     "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json rows = outcome.json()["rows"];
    ASSERT_EQ(rows.size(), 4u);
    for (std::size_t coarse = 0; coarse < 4; coarse += 2) {
        const json &a = rows[coarse], &b = rows[coarse + 1];
        EXPECT_LT(b["nrmse_brute"].get<double>(), a["nrmse_brute"].get<double>()) << a["method"];
        EXPECT_LT(a["clusters"].get<int>(), b["clusters"].get<int>());
    }
    for (const json& row : rows) {
        EXPECT_GT(row["nrmse"].get<double>(), 0.15) << row["method"];
        EXPECT_GT(row["dirty_pixels"].get<int>(), 0);
        EXPECT_GT(row["dirty_nodes"].get<int>(), 0);
        EXPECT_GT(row["bytes"].get<std::uint64_t>(), 1u << 20);
    }
}

TEST(BenchIndirect, ReportContainsTablesAndImages)
{
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "indirect", "builtin:cornell", "--frames", "1-2", "--size", "64x64", "--spp",
                                 "16", "--judged", "1", "--report", folder / "page", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string page = bytes_of(folder / "page/index.html");
    for (const char* text : {"Table 1 of the paper", "Table 2 of the paper", "Table 3 of the paper", "Figure 9",
                             "204.20 / 107.58", "quadtree:5 (0.45, 0.3)", "gallery", "indirect.json"})
        EXPECT_NE(page.find(text), std::string::npos) << text;
    EXPECT_EQ(outcome.json()["rows"].size(), 25u);
}

}   // namespace
}   // namespace gnomon::test
