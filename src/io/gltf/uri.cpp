// SPDX-License-Identifier: Apache-2.0
// Parses URIs [RFC 3986] and data URIs [RFC 2397] as far as glTF uses them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "io/gltf/data.h"

namespace gnomon::io::gltf {

namespace {

int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

bool decode_percent(std::string_view in, std::string& out)
{
    out.clear();
    for (std::size_t i = 0; i < in.size(); ++i) {
        if (in[i] != '%') {
            out += in[i];
            continue;
        }
        if (i + 2 >= in.size() || hex_digit(in[i + 1]) < 0 || hex_digit(in[i + 2]) < 0) return false;
        out += static_cast<char>(hex_digit(in[i + 1]) * 16 + hex_digit(in[i + 2]));
        i += 2;
    }
    return true;
}

constexpr std::uint8_t k_no_digit = 64;

// Accepts the standard and the URL alphabet; padding may be missing.
bool decode_base64(std::string_view in, std::vector<std::uint8_t>& out)
{
    static const auto table = [] {
        std::array<std::uint8_t, 256> t{};
        t.fill(k_no_digit);
        const std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (std::size_t i = 0; i < alphabet.size(); ++i)
            t[static_cast<unsigned char>(alphabet[i])] = static_cast<std::uint8_t>(i);
        t['-'] = 62, t['_'] = 63;
        return t;
    }();
    for (int padding = 0; padding < 2 && !in.empty() && in.back() == '='; ++padding) in.remove_suffix(1);
    if (in.size() % 4 == 1) return false;
    out.clear();
    out.reserve(in.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int have = 0;
    for (const char c : in) {
        const std::uint32_t value = table[static_cast<unsigned char>(c)];
        if (value == k_no_digit) return false;
        bits = bits << 6 | value;
        have += 6;
        if (have >= 8) {
            have -= 8;
            out.push_back(static_cast<std::uint8_t>(bits >> have & 0xff));
        }
    }
    return true;
}

Resource parse_data_uri(std::string_view rest, const std::string& pointer, const Context& context)
{
    Resource resource;
    resource.kind = Resource::Kind::data;
    const auto comma = rest.find(',');
    if (comma == std::string_view::npos) context.fail(pointer, "the data URI has no ','");
    std::string_view head = rest.substr(0, comma);
    const std::string_view body = rest.substr(comma + 1);
    constexpr std::string_view marker = ";base64";
    const bool base64 = head.size() >= marker.size() && head.substr(head.size() - marker.size()) == marker;
    if (base64) head.remove_suffix(marker.size());
    resource.mime_type = std::string(head.substr(0, std::min(head.find(';'), std::size_t{64})));
    std::transform(resource.mime_type.begin(), resource.mime_type.end(), resource.mime_type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });

    std::string plain;
    if (base64) {
        // Copy only if there are escapes, which is rare.
        const bool escaped = body.find('%') != std::string_view::npos;
        if (escaped && !decode_percent(body, plain)) context.fail(pointer, "the data URI has a bad escape");
        if (!decode_base64(escaped ? std::string_view(plain) : body, resource.bytes))
            context.fail(pointer, "the data URI is not valid base64");
    } else {
        if (!decode_percent(body, plain)) context.fail(pointer, "the data URI has a bad escape");
        resource.bytes.assign(plain.begin(), plain.end());
    }
    return resource;
}

}   // namespace

Resource parse_uri(const std::string& uri, const std::string& pointer, Context& context)
{
    if (uri.empty()) context.fail(pointer, "the URI is empty");
    // The scheme is the text before the first ':' if no other delimiter precedes it.
    const auto delimiter = uri.find_first_of(":/?#");
    if (delimiter != std::string::npos && uri[delimiter] == ':') {
        std::string scheme = uri.substr(0, delimiter);
        const bool named = !scheme.empty() && std::isalpha(static_cast<unsigned char>(scheme[0])) &&
                           std::all_of(scheme.begin(), scheme.end(), [](unsigned char c) {
                               return std::isalnum(c) || c == '+' || c == '-' || c == '.';
                           });
        if (!named) context.fail(pointer, "the URI has no valid scheme before ':'");
        std::transform(scheme.begin(), scheme.end(), scheme.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        if (scheme == "data") return parse_data_uri(std::string_view(uri).substr(delimiter + 1), pointer, context);
        // No scheme has a single letter, but drives have.
        Resource elsewhere;
        elsewhere.kind = scheme == "file"     ? Resource::Kind::file_uri
                         : scheme.size() == 1 ? Resource::Kind::drive
                                              : Resource::Kind::remote;
        const std::string name = uri.substr(uri.find_last_of("/\\:") + 1);
        if (!decode_percent(name, elsewhere.path)) elsewhere.path = name;
        return elsewhere;
    }
    if (uri.rfind("//", 0) == 0) {
        Resource remote;
        remote.kind = Resource::Kind::remote;
        return remote;
    }
    Resource file;
    if (!decode_percent(uri, file.path)) {
        context.repair(Fault::uri_escape, pointer, [] { return "the URI has a bad escape"; });
        file.path = uri;   // a name with a percent sign
    }
    if (file.path.find('\0') != std::string::npos) context.fail(pointer, "the URI holds a zero byte");
    return file;
}

}   // namespace gnomon::io::gltf
