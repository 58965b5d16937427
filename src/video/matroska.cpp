// SPDX-License-Identifier: Apache-2.0
#include "video/matroska.h"

#include <bit>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr std::uint64_t k_header = 0x1A45DFA3, k_segment = 0x18538067, k_cues = 0x1C53BB6B, k_tags = 0x1254C367,
                        k_tag = 0x7373, k_simple_tag = 0x67C8, k_tag_name = 0x45A3, k_tag_string = 0x4487;
constexpr std::uint64_t k_longest_text = 4096;   // bytes

struct Element {
    std::uint64_t id = 0;
    std::uint64_t content = 0, end = 0;   // positions in the file
};

class Elements {
 public:
    explicit Elements(const fs::path& file) : in_(file, std::ios::binary)
    {
        std::error_code error;
        size_ = fs::is_regular_file(file, error) ? fs::file_size(file, error) : 0;
        if (error || !in_) size_ = 0;
    }

    std::uint64_t size() const { return size_; }

    /// The element at a position. Returns nothing if it does not end before `limit`, or has no size.
    std::optional<Element> at(std::uint64_t position, std::uint64_t limit)
    {
        const auto id = number(position, limit, 4, true);
        const auto length = id ? number(position, limit, 8, false) : std::nullopt;
        if (!length || *length > limit - position) return std::nullopt;
        return Element{*id, position, position + *length};
    }

    /// Calls a function with each element of a range, until it returns true. Returns whether it did.
    bool find(std::uint64_t begin, std::uint64_t end, const std::function<bool(const Element&)>& is_it)
    {
        for (auto element = at(begin, end); element; element = at(element->end, end))
            if (is_it(*element)) return true;
        return false;
    }

    std::optional<Element> first(const Element& within, std::uint64_t id)
    {
        std::optional<Element> found;
        find(within.content, within.end, [&](const Element& e) {
            if (e.id == id) found = e;
            return e.id == id;
        });
        return found;
    }

    /// The segment, which follows the header.
    std::optional<Element> segment()
    {
        const auto header = at(0, size_);
        if (!header || header->id != k_header) return std::nullopt;
        const auto segment = at(header->end, size_);
        return segment && segment->id == k_segment ? segment : std::nullopt;
    }

    std::string text(const Element& element)
    {
        const std::uint64_t length = element.end - element.content;
        if (length > k_longest_text) return {};
        std::string text(static_cast<std::size_t>(length), '\0');
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(element.content));
        in_.read(text.data(), static_cast<std::streamsize>(text.size()));
        return in_ ? text : std::string();
    }

 private:
    // Reads a number whose first byte tells its length by leading zeros, and moves the position behind it. An id keeps
    // the bit that marks its length; a size whose bits are all set is unknown.
    std::optional<std::uint64_t> number(std::uint64_t& position, std::uint64_t limit, int longest, bool is_id)
    {
        if (position >= limit) return std::nullopt;
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(position));
        const int first = in_.get();
        const int length = 1 + std::countl_zero(static_cast<std::uint8_t>(first));
        if (!in_ || length > longest || static_cast<std::uint64_t>(length) > limit - position) return std::nullopt;
        std::uint64_t value = static_cast<std::uint64_t>(first) & (is_id ? 0xffu : 0xffu >> length);
        bool all_set = (static_cast<unsigned>(first) | (0xff00u >> length)) % 256 == 0xff;
        for (int i = 1; i < length; ++i) {
            const int byte = in_.get();
            value = value << 8 | static_cast<std::uint64_t>(byte & 0xff);
            all_set &= byte == 0xff;
        }
        if (!in_ || (!is_id && all_set)) return std::nullopt;
        position += static_cast<std::uint64_t>(length);
        return value;
    }

    std::ifstream in_;
    std::uint64_t size_ = 0;
};
}   // namespace

bool is_whole_matroska(const fs::path& file)
{
    Elements elements(file);
    const auto segment = elements.segment();
    return segment && segment->end == elements.size() && elements.first(*segment, k_cues);
}

std::string comment_of_matroska(const fs::path& file)
{
    Elements elements(file);
    const auto segment = elements.segment();
    const auto tags = segment ? elements.first(*segment, k_tags) : std::nullopt;
    if (!tags) return {};
    std::string comment;
    elements.find(tags->content, tags->end, [&](const Element& tag) {
        return tag.id == k_tag && elements.find(tag.content, tag.end, [&](const Element& simple) {
            if (simple.id != k_simple_tag) return false;
            const auto name = elements.first(simple, k_tag_name), value = elements.first(simple, k_tag_string);
            if (!name || !value || elements.text(*name) != "COMMENT") return false;
            comment = elements.text(*value);
            return true;
        });
    });
    return comment;
}

}   // namespace gnomon::video
