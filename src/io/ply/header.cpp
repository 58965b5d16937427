// SPDX-License-Identifier: Apache-2.0
#include "io/ply/header.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string_view>

#include "gnomon/error.h"
#include "io/obj/text.h"

namespace gnomon::io {

namespace {

constexpr std::size_t k_longest_header = 1 << 20;   // bytes
constexpr std::size_t k_most_elements = 64, k_most_properties = 1024;
constexpr std::uint64_t k_most_of_each = 0xfffffffe;

std::optional<PlyType> type_of(std::string_view word)
{
    struct Name {
        std::string_view old_name, new_name;
    };
    constexpr Name names[] = {{"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
                              {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    for (std::size_t i = 0; i < std::size(names); ++i)
        if (word == names[i].old_name || word == names[i].new_name) return static_cast<PlyType>(i);
    return std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line)
{
    std::vector<std::string_view> words;
    for (std::size_t at = 0; (at = line.find_first_not_of(" \t\r", at)) != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
        words.push_back(line.substr(at, end - at));
        at = end;
    }
    return words;
}

class Reader {
 public:
    Reader(std::span<const std::uint8_t> bytes, const std::string& file)
        : text_(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), k_longest_header)), file_(file)
    {
    }

    PlyHeader read()
    {
        if (line() != std::vector<std::string_view>{"ply"}) fail("not a PLY file: it does not begin with 'ply'");
        format(line());
        for (;;) {
            const std::vector<std::string_view> words = line();
            if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
            if (words[0] == "end_header") break;
            if (words[0] == "element")
                element(words);
            else if (words[0] == "property")
                property(words);
            else
                fail(fmt::format("'{}' is not a statement of a header", shown(words[0])));
        }
        header_.body = at_;
        header_.lines = line_;
        return std::move(header_);
    }

 private:
    [[noreturn]] void fail(const std::string& problem) const
    {
        throw InputError(file_, fmt::format("line {}", line_), problem);
    }

    std::vector<std::string_view> line()
    {
        ++line_;
        // The first line tells how lines end: files of old programs have CR alone.
        if (line_ == 1) line_end_ = text_.substr(0, 4) == "ply\r" && text_.substr(4, 1) != "\n" ? '\r' : '\n';
        const std::size_t end = text_.find(line_end_, at_);
        if (end == std::string_view::npos) fail("the header does not end");
        const std::string_view found = text_.substr(at_, end - at_);
        at_ = end + 1;
        return words_of(found);
    }

    void format(const std::vector<std::string_view>& words)
    {
        if (words.size() != 3 || words[0] != "format") fail("expected the format");
        if (words[1] == "ascii")
            header_.format = PlyFormat::ascii;
        else if (words[1] == "binary_little_endian")
            header_.format = PlyFormat::little_endian;
        else if (words[1] == "binary_big_endian")
            header_.format = PlyFormat::big_endian;
        else
            fail(fmt::format("unknown format '{}'", shown(words[1])));
    }

    void element(const std::vector<std::string_view>& words)
    {
        if (words.size() != 3) fail("expected a name and a number");
        if (header_.elements.size() == k_most_elements) fail("too many kinds of elements");
        PlyElement& e = header_.elements.emplace_back();
        e.name = std::string(words[1]);
        const char* const end = words[2].data() + words[2].size();
        const auto [stop, error] = std::from_chars(words[2].data(), end, e.count);
        if (error != std::errc() || stop != end || e.count > k_most_of_each)
            fail(fmt::format("'{}' is not a number of elements", shown(words[2])));
    }

    void property(const std::vector<std::string_view>& words)
    {
        if (header_.elements.empty()) fail("a property before the first element");
        PlyElement& e = header_.elements.back();
        if (e.properties.size() == k_most_properties) fail("too many properties");
        PlyProperty& p = e.properties.emplace_back();
        p.is_list = words.size() > 1 && words[1] == "list";
        if (words.size() != (p.is_list ? 5 : 3)) fail("expected a type and a name");
        const std::size_t at = p.is_list ? 3 : 1;
        const auto type = type_of(words[at]);
        const auto count = p.is_list ? type_of(words[2]) : PlyType::u8;
        if (!type || !count) fail(fmt::format("unknown type '{}'", shown(type ? words[2] : words[at])));
        if (!ply_is_integer(*count)) fail("the length of a list must be an integer");
        p.type = *type;
        p.count_type = *count;
        p.name = std::string(words[at + 1]);
    }

    std::string_view text_;
    std::string file_;
    std::size_t at_ = 0;
    std::uint32_t line_ = 0;
    char line_end_ = '\n';
    PlyHeader header_;
};

}   // namespace

std::size_t ply_size(PlyType type)
{
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

bool ply_is_integer(PlyType type)
{
    return type < PlyType::f32;
}

int PlyElement::find(const std::string& property, bool list) const
{
    for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == property && properties[i].is_list == list) return static_cast<int>(i);
    return -1;
}

PlyHeader read_ply_header(std::span<const std::uint8_t> bytes, const std::string& file)
{
    return Reader(bytes, file).read();
}

}   // namespace gnomon::io
