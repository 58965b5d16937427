// SPDX-License-Identifier: Apache-2.0
#include "io/file/output_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>

#include "gnomon/video.h"
#include "io/file/atomic_file.h"

namespace gnomon {

namespace io {

namespace fs = std::filesystem;

namespace {
constexpr int k_widest = 9;   // digits of a frame number

// {frame} or {frame:0N}, or %d or %0Nd, in a file name.
struct Pattern {
    std::size_t begin = 0, end = 0;
    int digits = 1;
};

// The first %d or %0Nd from `from` on. Other percent signs are parts of the name.
std::optional<Pattern> find_percent(const std::string& name, std::size_t from)
{
    for (std::size_t at = name.find('%', from); at != std::string::npos; at = name.find('%', at + 1)) {
        if (name.compare(at, 2, "%d") == 0) return Pattern{at, at + 2, 1};
        const bool padded = name.size() >= at + 4 && name[at + 1] == '0' && name[at + 2] >= '1' &&
                            name[at + 2] <= '0' + k_widest && name[at + 3] == 'd';
        if (padded) return Pattern{at, at + 4, name[at + 2] - '0'};
    }
    return std::nullopt;
}

std::optional<Pattern> find_pattern(const fs::path& file)
{
    const std::string name = file.filename().string();
    const std::size_t begin = name.find("{frame");
    const std::optional<Pattern> percent = find_percent(name, 0);
    if (percent && (begin != std::string::npos || find_percent(name, percent->end)))
        throw UsageError(fmt::format("{}: expected one frame number in the name", file.string()));
    if (begin == std::string::npos) return percent;
    const auto refuse = [&] {
        throw UsageError(fmt::format("{}: expected one {{frame}} or {{frame:04}} in the name", file.string()));
    };
    Pattern pattern{begin, name.find('}', begin), 1};
    if (pattern.end == std::string::npos) refuse();
    const std::string format = name.substr(begin + 6, pattern.end - begin - 6);
    ++pattern.end;
    if (!format.empty()) {
        const bool sound = format.size() == 3 && format[0] == ':' && format[1] == '0' && format[2] >= '1' &&
                           format[2] <= '0' + k_widest;
        if (!sound) refuse();
        pattern.digits = format[2] - '0';
    }
    if (name.find("{frame", pattern.end) != std::string::npos) refuse();
    return pattern;
}

std::string extension_of(const fs::path& file)
{
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}
}   // namespace

OutputKind output_kind(const fs::path& out)
{
    const std::string extension = extension_of(out);
    const bool numbered = find_pattern(out).has_value();
    if (extension == ".png" || extension == ".exr" || is_jpeg_name(out))
        return numbered ? OutputKind::numbered : OutputKind::image;
    constexpr std::string_view k_videos[] = {".mp4", ".mov", ".mkv", ".webm", ".gif"};
    if (std::find(std::begin(k_videos), std::end(k_videos), extension) == std::end(k_videos))
        throw UsageError(fmt::format("{}: cannot write '{}'; write .png, .jpg, .exr, .mp4, .mov, .mkv, .webm or .gif",
                                     out.string(), extension));
    if (numbered) throw UsageError(fmt::format("{}: a video is one file; leave out the frame's number", out.string()));
    return OutputKind::video;
}

bool is_exr_name(const fs::path& out)
{
    return extension_of(out) == ".exr";
}

bool is_jpeg_name(const fs::path& out)
{
    const std::string extension = extension_of(out);
    return extension == ".jpg" || extension == ".jpeg";
}

fs::path numbered_name(const fs::path& pattern, int frame)
{
    const std::optional<Pattern> place = find_pattern(pattern);
    if (!place) return pattern;
    const std::string name = pattern.filename().string();
    return pattern.parent_path() /
           (name.substr(0, place->begin) + fmt::format("{:0{}}", frame, place->digits) + name.substr(place->end));
}

void make_folder(const fs::path& out)
{
    if (!out.has_parent_path()) return;
    std::error_code error;
    fs::create_directories(out.parent_path(), error);
    if (error)
        throw MissingError(fmt::format("cannot make the folder {}: {}", out.parent_path().string(), error.message()));
}

void check_writable(const fs::path& out)
{
    io::AtomicFile probe(out);
    static_cast<void>(probe);   // removed at the end of the scope
}

}   // namespace io

FrameRange chunk_of(FrameRange range, int chunk, int chunks)
{
    if (chunks < 1 || chunk < 1 || chunk > chunks)
        throw UsageError(fmt::format("chunk {}/{}: expected I/N with 1 <= I <= N", chunk, chunks));
    const auto count = static_cast<std::int64_t>(range.count());
    const auto begin_of = [&](int i) { return range.first + static_cast<int>(count * i / chunks); };
    return {begin_of(chunk - 1), begin_of(chunk) - 1};
}

}   // namespace gnomon
