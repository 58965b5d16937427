// SPDX-License-Identifier: Apache-2.0
#include "video/gif.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr std::string_view k_signature = "GIF89a";
constexpr char k_trailer = ';';
constexpr std::string_view k_comment_start{"\x21\xfe", 2};   // an extension block with a comment
constexpr std::size_t k_longest = 255;                       // bytes of a sub-block

// The last bytes of a file, at most `count`.
std::string tail_of(const fs::path& file, std::size_t count)
{
    std::ifstream in(file, std::ios::binary | std::ios::ate);
    if (!in) return {};
    const auto size = static_cast<std::size_t>(std::max<std::streamoff>(0, in.tellg()));
    std::string tail(std::min(size, count), '\0');
    in.seekg(-static_cast<std::streamoff>(tail.size()), std::ios::end);
    in.read(tail.data(), static_cast<std::streamsize>(tail.size()));
    return in ? tail : std::string();
}
}   // namespace

bool is_whole_gif(const fs::path& file)
{
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return false;
    std::ifstream in(file, std::ios::binary);
    std::string head(k_signature.size(), '\0');
    if (!in.read(head.data(), static_cast<std::streamsize>(head.size())) || head != k_signature) return false;
    const std::string tail = tail_of(file, 1);
    return !tail.empty() && tail.back() == k_trailer;
}

std::string comment_of_gif(const fs::path& file)
{
    if (!is_whole_gif(file)) return {};
    // The block is: its start, the length, the text, a sub-block of length 0; then the trailer.
    const std::string tail = tail_of(file, k_longest + k_comment_start.size() + 3);
    for (std::size_t length = 1; length + k_comment_start.size() + 3 <= tail.size(); ++length) {
        const std::size_t text = tail.size() - 2 - length;
        const bool ends = tail[tail.size() - 2] == '\0' && static_cast<unsigned char>(tail[text - 1]) == length;
        if (ends && tail.compare(text - 1 - k_comment_start.size(), k_comment_start.size(), k_comment_start) == 0)
            return tail.substr(text, length);
    }
    return {};
}

void add_gif_comment(const fs::path& file, const std::string& comment)
{
    if (comment.empty()) return;
    GNOMON_CHECK(comment.size() <= k_longest);
    std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(-1, std::ios::end);
    out << k_comment_start << static_cast<char>(comment.size()) << comment << '\0' << k_trailer;
    out.flush();
    if (!out) throw MissingError(fmt::format("cannot write {}", file.string()));
}

}   // namespace gnomon::video
