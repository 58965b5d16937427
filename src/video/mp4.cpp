// SPDX-License-Identifier: Apache-2.0
#include "video/mp4.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <optional>

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr std::uintmax_t k_longest_comment = 4096;   // bytes

constexpr std::uint32_t type_of(const char (&name)[5])
{
    std::uint32_t type = 0;
    for (int i = 0; i < 4; ++i) type = type << 8 | static_cast<unsigned char>(name[i]);
    return type;
}

struct Box {
    std::uint32_t type = 0;
    std::uintmax_t content = 0, end = 0;   // positions in the file
};

// Reads the header of the box at `at`: its size in four bytes, or 1 and the size in the eight bytes after its type; its
// type in four. Returns nothing if the box does not end before `limit`.
std::optional<Box> box_at(std::istream& in, std::uintmax_t at, std::uintmax_t limit)
{
    std::array<unsigned char, 16> head{};
    in.seekg(static_cast<std::streamoff>(at));
    in.read(reinterpret_cast<char*>(head.data()), head.size());
    in.clear();
    const auto number = [&](std::size_t from, std::size_t to) {
        std::uintmax_t value = 0;
        for (std::size_t i = from; i < to; ++i) value = value << 8 | head[i];
        return value;
    };
    const bool large = number(0, 4) == 1;
    const std::uintmax_t header = large ? 16 : 8;
    const std::uintmax_t size = large ? number(8, 16) : number(0, 4);
    if (at >= limit || size < header || size > limit - at) return std::nullopt;
    return Box{static_cast<std::uint32_t>(number(4, 8)), at + header, at + size};
}

// The first box of a type within a range of the file.
std::optional<Box> find_box(std::istream& in, std::uintmax_t begin, std::uintmax_t end, std::uint32_t type)
{
    for (std::optional<Box> box = box_at(in, begin, end); box; box = box_at(in, box->end, end))
        if (box->type == type) return box;
    return std::nullopt;
}

constexpr std::uint32_t k_comment = type_of(
    "\xa9"
    "cmt");

// A box to descend into, and the bytes of its content to skip.
struct Step {
    std::uint32_t type;
    std::uintmax_t skipped;
};

// Descends through boxes, each within the one before. Returns the rest of the last one.
std::optional<Box> descend(std::istream& in, std::uintmax_t size, std::initializer_list<Step> steps)
{
    Box found{0, 0, size};
    for (const Step& step : steps) {
        const std::optional<Box> box = find_box(in, found.content, found.end, step.type);
        if (!box || box->end - box->content < step.skipped) return std::nullopt;
        found = {box->type, box->content + step.skipped, box->end};
    }
    return found;
}

std::string text_of(std::istream& in, const Box& box)
{
    if (box.end - box.content > k_longest_comment) return {};
    std::string text(static_cast<std::size_t>(box.end - box.content), '\0');
    in.seekg(static_cast<std::streamoff>(box.content));
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    return in ? text : std::string();
}
}   // namespace

bool is_whole_mp4(const fs::path& file)
{
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !in) return false;
    bool index = false, images = false;
    std::uintmax_t at = 0;
    while (at < size) {
        const std::optional<Box> box = box_at(in, at, size);
        if (!box) return false;
        index |= box->type == type_of("moov");
        images |= box->type == type_of("mdat");
        at = box->end;
    }
    return index && images;
}

std::string comment_of_mp4(const fs::path& file)
{
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !in) return {};

    // Descend to the value. In an MP4, a "meta" box has four bytes before its first box, and a value has eight before
    // its text. In a QuickTime file, the text follows its length and its language.
    const auto comment = descend(in, size,
                                 {{type_of("moov"), 0},
                                  {type_of("udta"), 0},
                                  {type_of("meta"), 4},
                                  {type_of("ilst"), 0},
                                  {k_comment, 0},
                                  {type_of("data"), 8}});
    if (comment) return text_of(in, *comment);
    const auto quicktime = descend(in, size, {{type_of("moov"), 0}, {type_of("udta"), 0}, {k_comment, 4}});
    return quicktime ? text_of(in, *quicktime) : std::string();
}

}   // namespace gnomon::video
