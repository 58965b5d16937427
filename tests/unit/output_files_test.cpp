// SPDX-License-Identifier: Apache-2.0
// Names of output files, chunks of a range, and files that are complete or absent.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <fstream>
#include <iterator>
#include <thread>

#include "base/random.h"
#include "gnomon/error.h"
#include "gnomon/video.h"
#include "image/bitmap_font.h"
#include "io/file/atomic_file.h"
#include "io/file/output_name.h"
#include "io/image/image_file.h"
#include "support.h"
#include "video/encoder.h"
#include "video/frame_list.h"
#include "video/frames_folder.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;
using io::OutputKind;

std::string bytes_of(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t files_in(const fs::path& folder)
{
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

Image8 noise(int width, int height, int channels)
{
    Image8 image(width, height, channels);
    Random random(image.data.size());
    for (std::uint8_t& byte : image.data) byte = static_cast<std::uint8_t>(random.below(256));
    return image;
}

TEST(OutputKind, FollowsExtensionAndPattern)
{
    EXPECT_EQ(io::output_kind("a/b.png"), OutputKind::image);
    EXPECT_EQ(io::output_kind("b.PNG"), OutputKind::image);
    EXPECT_EQ(io::output_kind("a{frame}.png"), OutputKind::numbered);
    EXPECT_EQ(io::output_kind("{frame:04}.png"), OutputKind::numbered);
    EXPECT_EQ(io::output_kind("a%d.png"), OutputKind::numbered);
    EXPECT_EQ(io::output_kind("a-%04d.exr"), OutputKind::numbered);
    EXPECT_EQ(io::output_kind("100%.png"), OutputKind::image);   // no pattern
    EXPECT_EQ(io::output_kind("a%20b.png"), OutputKind::image);
    EXPECT_EQ(io::output_kind("{frame}/still.png"), OutputKind::image);   // folders are not patterns
    for (const char* video : {"b.mp4", "b.mov", "b.MKV", "b.webm", "b.gif"})
        EXPECT_EQ(io::output_kind(video), OutputKind::video) << video;
    EXPECT_EQ(io::output_kind("b.jpg"), OutputKind::image);
    EXPECT_EQ(io::output_kind("b-{frame}.JPEG"), OutputKind::numbered);
    EXPECT_EQ(io::output_kind("b.Exr"), OutputKind::image);
    EXPECT_EQ(io::output_kind("{frame}.exr"), OutputKind::numbered);
    EXPECT_TRUE(io::is_exr_name("b.EXR"));
    EXPECT_FALSE(io::is_exr_name("exr.png"));
    for (const char* wrong :
         {"b", "b.bmp", "b{frame}.mp4", "b{frame.png", "b{frame:4}.png", "b{frame:0}.png", "b{frame:0x}.png",
          "b{frame:004}.png", "{frame}{frame}.png", "{framework}.png", "%d%d.png", "%04d-{frame}.png", "b%d.mp4", ""})
        EXPECT_THROW(io::output_kind(wrong), UsageError) << wrong;
}

TEST(NumberedName, PadsWithZeros)
{
    EXPECT_EQ(io::numbered_name("x/name-{frame:04}.png", 7), fs::path("x/name-0007.png"));
    EXPECT_EQ(io::numbered_name("name-{frame:02}.png", 1234), fs::path("name-1234.png"));
    EXPECT_EQ(io::numbered_name("x/name-%04d.png", 7), fs::path("x/name-0007.png"));
    EXPECT_EQ(io::numbered_name("50%-%d.png", 12), fs::path("50%-12.png"));
    EXPECT_EQ(io::numbered_name("{frame}", 7), fs::path("7"));
    EXPECT_EQ(io::numbered_name("plain.png", 7), fs::path("plain.png"));
}

TEST(RateText, KeepsTheRatesOfTelevisionExact)
{
    EXPECT_EQ(video::rate_text(24000.0 / 1001), "24000/1001");
    EXPECT_EQ(video::rate_text(30000.0 / 1001), "30000/1001");
    EXPECT_EQ(video::rate_text(60000.0 / 1001), "60000/1001");
    EXPECT_EQ(video::rate_text(24), "24");
    EXPECT_EQ(video::rate_text(12.5), "12.5");
    EXPECT_EQ(video::rate_text(23.976), "23.976");
}

TEST(OutputFolder, IsMadeWithThoseAboveIt)
{
    const test::ScratchFolder folder;
    const fs::path out = folder / "a/b/name-{frame:04}.png";
    io::make_folder(out);
    EXPECT_TRUE(fs::is_directory(out.parent_path()));
    io::make_folder(out);
    io::make_folder("name.png");
    // A file is in the way.
    std::ofstream(folder / "file") << "x";
    EXPECT_THROW(io::make_folder(folder / "file/c/name.png"), MissingError);
}

TEST(FramesFolder, IsRemovedIfItsManifestCannotBeWritten)
{
    const test::ScratchFolder folder;
    video::FramesFolder frames(folder / "a.mp4");
    ::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    for (const bool shared : {false, true}) {
        const rlimit none{0, before.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
        bool refused = false;
        try {
            frames.open({"scene", {8, 8}, 1, "1.0"}, false, shared);
        } catch (const MissingError&) {
            refused = true;
        }
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
        EXPECT_TRUE(refused);
        // Shared files are kept for the other chunks.
        EXPECT_EQ(fs::exists(frames.path()), shared);
    }
    EXPECT_EQ(files_in(frames.path()), 0u);
}

// Two runs at the same time would take each other's frames for their own, or delete them.
TEST(FramesFolder, BelongsToOneVideo)
{
    const test::ScratchFolder folder;
    const video::VideoIdentity video{"scene", {8, 8}, 1, "1.0"}, other{"scene", {8, 8}, 2, "1.0"};
    {
        video::FramesFolder one(folder / "a.mp4");
        one.open(video, false, false);
        std::ofstream(one.file(1)) << "a frame";
        for (const bool keep : {false, true}) {
            video::FramesFolder two(folder / "a.mp4");
            EXPECT_THROW(two.open(keep ? video : other, keep, false), MissingError);
        }
        EXPECT_EQ(bytes_of(one.file(1)), "a frame");
        one.remove();
        EXPECT_FALSE(fs::exists(one.path()));
        video::FramesFolder next(folder / "a.mp4");
        next.open(other, false, false);   // of another folder with that name
    }

    // Chunks of one video work in parallel, also before the first frame exists.
    video::FramesFolder first(folder / "b.mp4"), second(folder / "b.mp4"), third(folder / "b.mp4");
    first.open(video, false, true);
    second.open(video, false, true);
    EXPECT_THROW(third.open(other, false, true), UsageError);
    EXPECT_THROW(third.open(video, true, false), MissingError) << "a video deletes its frames when it is complete";
}

// A folder that happens to have the name, with files of somebody else, is left as it is.
TEST(FramesFolder, RefusesAFolderWithOtherFiles)
{
    const test::ScratchFolder folder;
    const fs::path taken = folder / "a.mp4.frames";
    fs::create_directory(taken);
    std::ofstream(taken / "notes.txt") << "mine";
    for (const bool keep : {false, true}) {
        video::FramesFolder frames(folder / "a.mp4");
        EXPECT_THROW(frames.open({"scene", {8, 8}, 1, "1.0"}, keep, false), UsageError);
    }
    EXPECT_EQ(bytes_of(taken / "notes.txt"), "mine");
    EXPECT_EQ(files_in(taken), 1u);
}

TEST(FramesFolder, AcceptsChunksThatStartTogether)
{
    const test::ScratchFolder folder;
    std::vector<std::thread> chunks;
    for (int i = 0; i < 8; ++i)
        chunks.emplace_back([&] {
            video::FramesFolder frames(folder / "a.mp4");
            EXPECT_NO_THROW(frames.open({"scene", {8, 8}, 1, "1.0"}, false, true));
        });
    for (std::thread& chunk : chunks) chunk.join();
}

// A frame is found with the reason why it is not of this video; the version is named first.
TEST(FramesFolder, FindsWhatRenderedAFrame)
{
    const test::ScratchFolder folder;
    video::FramesFolder frames(folder / "a.mp4");
    const video::VideoIdentity ours{"scene", {8, 8}, 1, "1.0", 7, "avx2"};
    frames.open(ours, false, false);
    EXPECT_FALSE(frames.find(1, ours)) << "it is not there";
    const auto found = [&](video::VideoIdentity theirs) {
        io::write_png(frames.file(1), Image8(8, 8, 3), video::stamp_of(theirs));
        const auto frame = frames.find(1, ours);
        EXPECT_TRUE(frame);
        return frame ? frame->difference : video::Difference::none;
    };
    EXPECT_EQ(found({"another name", {8, 8}, 1, "1.0", 7, "avx2"}), video::Difference::none);
    EXPECT_EQ(found({"scene", {8, 8}, 2, "1.1", 8, "sse4.2"}), video::Difference::version);
    EXPECT_EQ(found({"scene", {8, 8}, 2, "1.0", 8, "sse4.2"}), video::Difference::scene);
    EXPECT_EQ(found({"scene", {8, 8}, 2, "1.0", 7, "sse4.2"}), video::Difference::options);
    EXPECT_EQ(found({"scene", {8, 8}, 1, "1.0", 7, "sse4.2"}), video::Difference::instruction_set);
    io::write_png(frames.file(1), Image8(8, 8, 3));
    EXPECT_EQ(frames.find(1, ours)->difference, video::Difference::unknown);
    io::write_png(frames.file(1), Image8(8, 9, 3), video::stamp_of(ours));
    EXPECT_FALSE(frames.find(1, ours)) << "of another size";
    EXPECT_EQ(video::stamp_in(video::comment_of(ours)), video::stamp_of(ours));
    EXPECT_EQ(video::stamp_in("shot on location, at dawn"), "");
}

TEST(ListFrames, JoinsConsecutiveFrames)
{
    EXPECT_EQ(video::list_frames({3}), "frame 3");
    EXPECT_EQ(video::list_frames({3, 4, 5}), "frames 3-5");
    EXPECT_EQ(video::list_frames({1, 3, 4, 9}), "frames 1, 3-4 and 9");
    std::vector<int> odd;
    for (int i = 1; i < 100; i += 2) odd.push_back(i);
    EXPECT_EQ(video::list_frames(odd), "frames 1, 3, 5, 7, 9, 11, 13, 15 and 42 more");
    EXPECT_EQ(video::first_range({9, 4, 3}), "3-4");
    EXPECT_EQ(video::first_range({9}), "9-9");
}

TEST(ChunkOf, ChunksPartitionTheRangeEvenly)
{
    for (const FrameRange range : {FrameRange{1, 10}, FrameRange{5, 5}, FrameRange{100, 899}, FrameRange{2, 8}}) {
        for (int chunks = 1; chunks <= 13; ++chunks) {
            int next = range.first, least = range.count(), most = 0;
            for (int chunk = 1; chunk <= chunks; ++chunk) {
                const FrameRange part = chunk_of(range, chunk, chunks);
                EXPECT_EQ(part.first, next);
                next += part.count();
                least = std::min(least, part.count());
                most = std::max(most, part.count());
            }
            EXPECT_EQ(next, range.last + 1);
            EXPECT_LE(most - least, 1);
        }
    }
    EXPECT_EQ(chunk_of({1, 10}, 1, 1), (FrameRange{1, 10}));
    EXPECT_THROW(chunk_of({1, 10}, 0, 3), UsageError);
    EXPECT_THROW(chunk_of({1, 10}, 4, 3), UsageError);
    EXPECT_THROW(chunk_of({1, 10}, 1, 0), UsageError);
}

TEST(AtomicFile, AppearsCompleteOrNotAtAll)
{
    test::ScratchFolder folder;
    {
        io::AtomicFile file(folder / "a");
        file.write("half");
        EXPECT_FALSE(fs::exists(folder / "a"));
    }
    EXPECT_EQ(files_in(folder.path()), 0u);
    {
        io::AtomicFile file(folder / "a");
        file.write("whole");
        file.commit();
    }
    EXPECT_EQ(bytes_of(folder / "a"), "whole");
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, ReplacesTheTargetOfALink)
{
    test::ScratchFolder folder;
    std::ofstream(folder / "real") << "old";
    fs::create_symlink("real", folder / "link");
    io::AtomicFile file(folder / "link");
    file.write("new");
    file.commit();
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(bytes_of(folder / "real"), "new");
}

TEST(AtomicFile, FollowsLinksToFilesThatDoNotExist)
{
    test::ScratchFolder folder;
    fs::create_directory(folder / "below");
    fs::create_symlink("below/next", folder / "link");
    fs::create_symlink("../real", folder / "below/next");
    io::AtomicFile file(folder / "link");
    file.write("new");
    file.commit();
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_TRUE(fs::is_symlink(folder / "below/next"));
    EXPECT_EQ(bytes_of(folder / "real"), "new");

    fs::create_symlink("b", folder / "a");
    fs::create_symlink("a", folder / "b");
    EXPECT_THROW(io::AtomicFile{folder / "a"}, MissingError);
    fs::create_symlink("none/file", folder / "nowhere");
    EXPECT_THROW(io::AtomicFile{folder / "nowhere"}, MissingError);
    EXPECT_EQ(files_in(folder.path()), 6u);
}

TEST(AtomicFile, RefusesUnwritablePaths)
{
    test::ScratchFolder folder;
    std::ofstream(folder / "file") << "x";
    for (const fs::path& target : {folder / "missing/a", folder / "file/a", folder.path(), fs::path("/dev/null"),
                                   fs::path("/proc/a.png"), folder / "", fs::path()})
        EXPECT_THROW(io::AtomicFile{target}, MissingError) << target;
    EXPECT_EQ(files_in(folder.path()), 1u);
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(WritePng, ReportsTheReasonOfAFailure)
{
    try {
        io::write_png("/proc/no/a.png", noise(2, 2, 3));
        FAIL() << "no exception";
    } catch (const MissingError& error) {
        EXPECT_NE(std::string(error.what()).find("/proc/no/a.png: No such file"), std::string::npos) << error.what();
    }
}

TEST(WritePng, BytesDependOnPixelsOnly)
{
    test::ScratchFolder folder;
    io::write_png(folder / "a.png", noise(33, 7, 3));
    io::write_png(folder / "b.png", noise(33, 7, 3));
    EXPECT_EQ(bytes_of(folder / "a.png"), bytes_of(folder / "b.png"));
}

TEST(WritePng, RoundTripKeepsThePixels)
{
    test::ScratchFolder folder;
    for (int channels = 1; channels <= 4; ++channels) {
        const Image8 image = noise(17, 13, channels);
        io::write_png(folder / "a.png", image);
        const Image8 back = io::read_image(folder / "a.png");
        EXPECT_EQ(back.width, 17);
        EXPECT_EQ(back.height, 13);
        EXPECT_EQ(back.channels, channels);
        EXPECT_EQ(back.data, image.data);
    }
}

// Two images of the same grey: scaling them down must preserve the brightness.
TEST(ContactSheet, DownscalesInLinearLight)
{
    test::ScratchFolder folder;
    Image8 stripes(2000, 40, 3);   // black and white columns: half the radiance, not half the code value
    for (int y = 0; y < stripes.height; ++y)
        for (int x = 0; x < stripes.width; ++x)
            for (int c = 0; c < 3; ++c) stripes.pixel(x, y)[c] = x % 2 ? 255 : 0;
    io::write_png(folder / "a.png", stripes);
    write_contact_sheet({folder / "a.png", folder / "a.png"}, {"one", "two"}, 2, folder / "sheet.png");
    const Image8 sheet = io::read_image(folder / "sheet.png");
    EXPECT_LE(sheet.width, 1920);
    const int x = sheet.width / 4;
    double sum = 0;
    for (int i = 0; i < 64; ++i) sum += linear_from_srgb8()[sheet.pixel(x + i, 12)[0]];
    EXPECT_NEAR(sum / 64, 0.5, 0.02);
    EXPECT_THROW(write_contact_sheet({}, {}, 1, folder / "b.png"), UsageError);
    EXPECT_THROW(write_contact_sheet({folder / "a.png"}, {}, 1, folder / "b.png"), UsageError);
    io::write_png(folder / "c.png", noise(8, 8, 3));
    EXPECT_THROW(write_contact_sheet({folder / "a.png", folder / "c.png"}, {"", ""}, 1, folder / "b.png"), UsageError);
    EXPECT_FALSE(fs::exists(folder / "b.png"));
}

TEST(WholePng, DetectsEveryMissingOrWrongByte)
{
    test::ScratchFolder folder;
    const fs::path file = folder / "a.png";
    io::write_png(file, noise(9, 5, 3));
    EXPECT_TRUE(io::is_whole_png(file, 9, 5));
    EXPECT_FALSE(io::is_whole_png(file, 9, 6));
    EXPECT_FALSE(io::is_whole_png(file, 5, 9));
    EXPECT_FALSE(io::is_whole_png(folder / "none.png", 9, 5));
    EXPECT_FALSE(io::is_whole_png(folder.path(), 9, 5));

    const std::string whole = bytes_of(file);
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::ofstream(file, std::ios::binary) << whole.substr(0, i);
        EXPECT_FALSE(io::is_whole_png(file, 9, 5)) << "cut to " << i << " bytes";
        std::string wrong = whole;
        wrong[i] = static_cast<char>(wrong[i] ^ 0x10);
        std::ofstream(file, std::ios::binary) << wrong;
        EXPECT_FALSE(io::is_whole_png(file, 9, 5)) << "byte " << i << " changed";
    }
    std::ofstream(file, std::ios::binary) << whole << "x";
    EXPECT_FALSE(io::is_whole_png(file, 9, 5));
}

TEST(BitmapFont, GlyphsDiffer)
{
    const std::string characters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ .,:-_/+=()%";
    for (const char a : characters)
        for (const char b : characters) EXPECT_EQ(a == b, image::glyph(a) == image::glyph(b)) << a << b;
    EXPECT_EQ(image::glyph('q'), image::glyph('Q'));
    EXPECT_EQ(image::glyph('\n'), image::glyph('~'));
}

}   // namespace
}   // namespace gnomon
