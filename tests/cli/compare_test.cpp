// SPDX-License-Identifier: Apache-2.0
// gnomon compare, .exr output and --environment, from the user's side.
#include "hdr_bytes.h"
#include "io/image/image_file.h"
#include "run_program.h"

namespace gnomon::test {
namespace {

// A grey PNG.
std::string gray(const ScratchFolder& folder, const std::string& name, std::uint8_t value, int width = 24)
{
    Image8 image(width, 20, 3);
    std::fill(image.data.begin(), image.data.end(), value);
    io::write_png(folder / name, image);
    return folder / name;
}

std::string sky(const ScratchFolder& folder)
{
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < 16; ++y) {
        const std::uint8_t up[4] = {60, 120, 240, 129}, down[4] = {60, 50, 40, 128};
        const auto row = y < 8 ? even_row(32, up) : even_row(32, down);
        pixels.insert(pixels.end(), row.begin(), row.end());
    }
    const auto bytes = hdr_file("-Y 16 +X 32", pixels);
    std::ofstream(folder / "sky.hdr", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return folder / "sky.hdr";
}

TEST(CompareSubcommand, JsonContainsAllMetrics)
{
    const ScratchFolder folder;
    const std::string a = gray(folder, "a.png", 100), b = gray(folder, "b.png", 151);
    const Outcome different = run({"compare", a, b, "--json"});
    ASSERT_EQ(different.code, 0) << different.err;
    const auto json = different.json();
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    EXPECT_EQ(keys,
              (std::vector<std::string>{"flip", "max_abs", "pixels_different", "psnr", "relmse", "rmse", "ssim"}));
    EXPECT_NEAR(json["rmse"].get<double>(), 0.2, 1e-6);
    EXPECT_NEAR(json["psnr"].get<double>(), 13.9794, 1e-3);
    EXPECT_EQ(json["pixels_different"], 1);

    const auto equal = run({"compare", a, a, "--json"}).json();
    EXPECT_TRUE(equal["psnr"].is_null());
    EXPECT_EQ(equal["flip"], 0);
    EXPECT_EQ(equal["ssim"], 1);
}

TEST(CompareSubcommand, ThresholdsDecideTheExitCode)
{
    const ScratchFolder folder;
    const std::string a = gray(folder, "a.png", 100), b = gray(folder, "b.png", 151);
    EXPECT_EQ(run({"compare", a, b, "--fail-above", "rmse=0.21", "--fail-above", "psnr=13.9"}).code, 0);
    const Outcome above = run({"compare", a, b, "--fail-above", "rmse=0.19", "--quiet"});
    expect_failure(above, 1, "rmse is 0.2, above 0.19");
    expect_failure(run({"compare", a, b, "--fail-above", "psnr=14", "--quiet"}), 1, "below 14");
    expect_failure(run({"compare", a, b, "--fail-above", "ssim=0.999", "--quiet"}), 1, "ssim");
    EXPECT_EQ(run({"compare", a, a, "--fail-above", "psnr=1000", "--fail-above", "flip=0"}).code, 0);   // equal
    // The document is complete even in this case.
    const Outcome json = run({"compare", a, b, "--metric", "flip", "--fail-above", "flip=0.01", "--json"});
    EXPECT_EQ(json.code, 1);
    EXPECT_EQ(json.json().size(), 1u);
}

TEST(CompareSubcommand, RefusesImagesThatCannotBeCompared)
{
    const ScratchFolder folder;
    const std::string a = gray(folder, "a.png", 100), wide = gray(folder, "wide.png", 100, 25);
    expect_failure(run({"compare", a, wide}), 2, "sizes differ");
    expect_failure(run({"compare", a, folder / "none.png"}), 3, "none.png");
    expect_failure(run({"compare", a, a, "--layer", "depth"}), 2, "layers");
    std::ofstream(folder / "bad.exr", std::ios::binary) << std::string("\x76\x2f\x31\x01\x02\0\0\0nonsense", 16);
    expect_failure(run({"compare", a, folder / "bad.exr"}), 3, "bad.exr");
    expect_failure(run({"compare", a, a, "--heatmap", folder / "no" / "folder.png"}), 4, "folder.png");
}

TEST(CompareSubcommand, WritesHeatMapAsPng)
{
    const ScratchFolder folder;
    const std::string a = gray(folder, "a.png", 0), b = gray(folder, "b.png", 255);
    ASSERT_EQ(run({"compare", a, b, "--metric", "rmse", "--heatmap", folder / "heat.png"}).code, 0);
    const Image8 heat = io::read_image(folder / "heat.png");
    EXPECT_GT(heat.pixel(5, 5)[0], 250);   // pale yellow: black against white
    EXPECT_GT(heat.pixel(5, 5)[1], 230);
}

TEST(ExrOutput, HasAllLayersAndSameBytesForAnyThreadCount)
{
    const ScratchFolder folder;
    const std::vector<std::string> common{"render", "builtin:cornell", "--size", "64x48", "--quiet"};
    const auto render = [&](const std::string& name, const std::string& threads) {
        std::vector<std::string> arguments = common;
        arguments.insert(arguments.end(), {"-o", folder / name, "--threads", threads});
        EXPECT_EQ(run(arguments).code, 0);
        return bytes_of(folder / name);
    };
    const std::string one = render("one.exr", "1");
    EXPECT_FALSE(one.empty());
    EXPECT_TRUE(one == render("three.exr", "3"));
    for (const char* layer : {"depth", "normal", "albedo", "direct", "shadow.L0"})
        EXPECT_EQ(run({"compare", folder / "one.exr", folder / "three.exr", "--layer", layer}).code, 0) << layer;
    // Layers differ from each other: an albedo does not exceed 1, and depth is not constant.
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"one.exr", "three.exr"}));
}

TEST(ExrOutput, NumberedSetsResume)
{
    const ScratchFolder folder;
    const std::vector<std::string> arguments{"render", "builtin:cornell",       "--size",   "16x12", "--frames", "1-3",
                                             "-o",     folder / "f{frame}.exr", "--resume", "--json"};
    ASSERT_EQ(run(arguments).code, 0);
    const std::string second = bytes_of(folder / "f2.exr");
    std::filesystem::resize_file(folder / "f2.exr", second.size() / 2);   // a truncated frame
    const auto json = run(arguments).json();
    EXPECT_EQ(json["frames"][0]["ms"], 0);   // kept
    EXPECT_GT(json["frames"][1]["ms"], 0);   // rendered again
    EXPECT_TRUE(bytes_of(folder / "f2.exr") == second);
}

TEST(ExrOutput, RefusesMoreLightsThanTheReaderAccepts)
{
    const ScratchFolder folder;
    std::string scene =
        "v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 4 3\nf .8 .8 .8 1 0 0 0 0\n"
        "s 0 0 0 1\n";
    for (int i = 0; i < 17'000; ++i) scene += "l 1 2 5 .1 .1 .1\n";
    std::ofstream(folder / "many.aff") << scene;
    const auto render = [&](const std::string& name, const std::string& lights) {
        return run({"render", folder / "many.aff", "-o", folder / name, "--lights", lights, "--indirect", "off",
                    "--resume", "--json"});
    };
    ASSERT_EQ(render("many.exr", "16359").code, 0);
    EXPECT_EQ(run({"compare", folder / "many.exr", folder / "many.exr", "--layer", "shadow.L16358"}).code, 0);
    EXPECT_EQ(render("many.exr", "16359").json()["frames"][0]["ms"], 0) << "a complete image was rendered again";

    const Outcome more = render("more.exr", "16360");
    expect_failure(more, 2, "more.exr: 16360 lights; an .exr of 4 x 3 pixels has room for the shadows of 16359");
    EXPECT_FALSE(std::filesystem::exists(folder / "more.exr"));
    EXPECT_EQ(render("more.png", "16360").code, 0);
}

TEST(EnvironmentOption, LightsTheScene)
{
    const ScratchFolder folder;
    const std::string with = folder / "with.exr", without = folder / "without.exr";
    const std::vector<std::string> common{"render", "builtin:cornell", "--size", "32x24", "--samples",
                                          "1",      "--quiet",         "-o"};
    auto arguments = common;
    arguments.push_back(without);
    ASSERT_EQ(run(arguments).code, 0);
    arguments = common;
    arguments.insert(arguments.end(), {with, "--environment", sky(folder)});
    ASSERT_EQ(run(arguments).code, 0);
    EXPECT_GT(run({"compare", with, without, "--json"}).json()["rmse"].get<double>(), 0.01);
    EXPECT_EQ(run({"compare", with, without, "--layer", "depth", "--fail-above", "rmse=0"}).code, 0);
    EXPECT_EQ(run({"compare", with, without, "--layer", "shadow.L0", "--fail-above", "rmse=0"}).code,
              0);                                                               // the file's
    EXPECT_EQ(run({"compare", with, with, "--layer", "shadow.L16"}).code, 0);   // the last of sixteen additional ones

    arguments.back() = folder / "none.hdr";
    expect_failure(run(arguments), 3, "none.hdr");
}

}   // namespace
}   // namespace gnomon::test
