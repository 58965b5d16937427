// SPDX-License-Identifier: Apache-2.0
#include "io/ply/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "gnomon/error.h"
#include "io/obj/text.h"

namespace gnomon::io {

namespace {

template <class T>
double number_at(const std::uint8_t* from, bool big_endian)
{
    std::uint8_t bytes[sizeof(T)];
    std::copy_n(from, sizeof(T), bytes);
    if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}

bool is_blank(std::uint8_t c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

}   // namespace

PlyBody::PlyBody(std::span<const std::uint8_t> bytes, const PlyHeader& header, std::string file)
    : bytes_(bytes),
      file_(std::move(file)),
      format_(header.format),
      at_(header.body),
      value_at_(header.body),
      line_(header.lines + 1)
{
}

void PlyBody::fail(const std::string& problem) const
{
    throw InputError(file_,
                     format_ == PlyFormat::ascii ? fmt::format("line {}", line_) : fmt::format("byte {}", value_at_),
                     problem);
}

std::size_t PlyBody::least_bytes(PlyType type) const
{
    return format_ == PlyFormat::ascii ? 2 : ply_size(type);   // a digit and a blank
}

void PlyBody::require_room(const PlyElement& element) const
{
    std::uint64_t each = 0;
    for (const PlyProperty& p : element.properties) each += least_bytes(p.is_list ? p.count_type : p.type);
    // The last value of a text needs no blank.
    const std::uint64_t left = bytes_.size() - at_ + (format_ == PlyFormat::ascii ? 1 : 0);
    if (element.count > 0 && (each == 0 || element.count > left / each))
        throw InputError(file_,
                         format_ == PlyFormat::ascii ? fmt::format("line {}", line_) : fmt::format("byte {}", at_),
                         fmt::format("declares {} elements '{}', which do not fit the rest of the file", element.count,
                                     shown(element.name)));
}

std::string_view PlyBody::word()
{
    for (; at_ < bytes_.size() && is_blank(bytes_[at_]); ++at_)
        if (bytes_[at_] == '\n') ++line_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_blank(bytes_[at_])) ++at_;
    return {reinterpret_cast<const char*>(bytes_.data()) + begin, at_ - begin};
}

double PlyBody::value(PlyType type)
{
    value_at_ = at_;
    if (format_ == PlyFormat::ascii) {
        std::string_view text = word();
        if (text.empty()) fail("the file ends before all elements were read");
        if (text.size() > 1 && text[0] == '+') text.remove_prefix(1);
        double value = 0;
        const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || stop != text.data() + text.size())
            fail(fmt::format("expected a number, found '{}'", shown(text)));
        return value;
    }
    const std::size_t size = ply_size(type);
    if (size > bytes_.size() - at_) fail("the file ends before all elements were read");
    const std::uint8_t* const from = bytes_.data() + at_;
    at_ += size;
    const bool big = format_ == PlyFormat::big_endian;
    switch (type) {
        case PlyType::i8:
            return number_at<std::int8_t>(from, big);
        case PlyType::u8:
            return number_at<std::uint8_t>(from, big);
        case PlyType::i16:
            return number_at<std::int16_t>(from, big);
        case PlyType::u16:
            return number_at<std::uint16_t>(from, big);
        case PlyType::i32:
            return number_at<std::int32_t>(from, big);
        case PlyType::u32:
            return number_at<std::uint32_t>(from, big);
        case PlyType::f32:
            return number_at<float>(from, big);
        default:
            return number_at<double>(from, big);
    }
}

std::uint64_t PlyBody::length(const PlyProperty& list)
{
    const double number = value(list.count_type);
    const double most =
        static_cast<double>((bytes_.size() - at_) / (format_ == PlyFormat::ascii ? 1 : ply_size(list.type)));
    if (!(number >= 0) || number != std::floor(number)) fail(fmt::format("{} is not the length of a list", number));
    if (number > most) fail(fmt::format("a list of {} numbers does not fit the rest of the file", number));
    return static_cast<std::uint64_t>(number);
}

void PlyBody::skip(const PlyProperty& property)
{
    std::uint64_t count = property.is_list ? length(property) : 1;
    for (; count > 0; --count) value(property.type);
}

}   // namespace gnomon::io
