// SPDX-License-Identifier: Apache-2.0
#include "viewer/outline.h"

namespace gnomon::viewer {

std::vector<OutlineEdge> outline_of(const Layer& ids, std::uint32_t object)
{
    std::vector<OutlineEdge> edges;
    if (object == 0) return edges;
    const int width = ids.size.width, height = ids.size.height;
    const auto shows = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < width && y < height && ids.id(x, y) == object;
    };
    // Walk along each line between two rows, and then between two columns, and join what continues.
    const auto walk = [&](int lines, int length, auto&& parts, auto&& corner) {
        for (int line = 0; line <= lines; ++line)
            for (int begin = 0; begin < length;) {
                int end = begin;
                while (end < length && parts(line, end)) ++end;
                if (end > begin) edges.push_back({corner(line, begin), corner(line, end)});
                begin = end + 1;
            }
    };
    walk(
        height, width, [&](int y, int x) { return shows(x, y - 1) != shows(x, y); },
        [](int y, int x) { return glm::ivec2(x, y); });
    walk(
        width, height, [&](int x, int y) { return shows(x - 1, y) != shows(x, y); },
        [](int x, int y) { return glm::ivec2(x, y); });
    return edges;
}

}   // namespace gnomon::viewer
