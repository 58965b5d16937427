// SPDX-License-Identifier: Apache-2.0
#include "io/obj/data.h"

#include <fmt/format.h>

#include <set>
#include <unordered_map>

#include "base/image.h"
#include "base/interruption.h"
#include "gnomon/error.h"

namespace gnomon::io {

namespace {

constexpr float k_no_color = -1;
constexpr std::size_t k_most_unknown_keywords = 10;      // named in warnings; a binary file may have thousands
constexpr std::uint32_t k_statements_a_step = 1 << 10;   // between two reports of progress

class Parser {
 public:
    Parser(ObjText& text, bool strict, std::vector<std::string>& warnings)
        : text_(text), strict_(strict), warnings_(warnings)
    {
        data_.materials.emplace_back();
        material_ids_.emplace("", 0);
    }

    ObjData run()
    {
        std::uint32_t statements = 0;
        for (std::string_view keyword = text_.next_statement(); !keyword.empty(); keyword = text_.next_statement()) {
            statement(keyword);
            if (++statements % k_statements_a_step == 0) report_progress("loading", 0.8 * text_.done());
        }
        finish();
        return std::move(data_);
    }

 private:
    void statement(std::string_view keyword)
    {
        if (keyword == "v") return position();
        if (keyword == "vt") return texcoord();
        if (keyword == "vn") {
            glm::vec3 n(0);
            const bool finite = number(n.x, "a number") & number(n.y, "a number") & number(n.z, "a number");
            not_finite_normals_ += !finite;
            data_.normals.push_back(finite ? n : glm::vec3(0));
            return known();
        }
        if (keyword == "f" || keyword == "fo") return face();
        if (keyword == "usemtl") {
            const auto [at, added] = material_ids_.try_emplace(text_.rest(), data_.materials.size());
            if (added) data_.materials.push_back(at->first);
            material_ = static_cast<std::uint32_t>(at->second);
            return known();
        }
        if (keyword == "mtllib") {
            data_.libraries.push_back(text_.rest());
            return known();
        }
        if (keyword == "o") return object_ = text_.rest(), group_.clear(), current_ = k_no_index, known();
        if (keyword == "g") return group_ = text_.rest(), current_ = k_no_index, known();
        if (keyword == "s") return smoothing();
        if (keyword == "l" || keyword == "p") {
            warn_once("lines and points are not drawn");
            return known();
        }
        unknown(keyword);
    }

    // Reads a number that may be repaired: one that is written as not finite is 0.
    // @return whether it is finite
    bool number(float& value, const char* what)
    {
        if (!strict_ && text_.skip_not_finite()) return value = 0, false;
        value = text_.number(what);
        return true;
    }

    void position()
    {
        float p[3];
        for (float& x : p) {
            x = text_.number("a coordinate");
            if (std::abs(x) > k_largest_coordinate) text_.fail("coordinate is out of range");
        }
        data_.positions.emplace_back(p[0], p[1], p[2]);
        // Accept a weight (for curves), a colour, or both.
        glm::vec4 last(1);
        int more = 0;
        while (!text_.at_end()) last = {last.y, last.z, last.w, text_.number("a number")}, ++more;
        if (more >= 3) color({last.y, last.z, last.w});
        known();
    }

    // Stores the colour of the last position, as it is in the file; those before it without one are white.
    void color(const glm::vec3& encoded)
    {
        const glm::vec3 c = glm::clamp(encoded, 0.0f, 255.0f);
        most_color_ = std::max({most_color_, c.x, c.y, c.z});
        data_.colors.resize(data_.positions.size() - 1, glm::vec4(k_no_color));
        data_.colors.emplace_back(c, 1);
    }

    // Converts sRGB values, of 0 to 1 or of 0 to 255, to linear ones.
    void finish_colors()
    {
        if (data_.colors.empty()) return;
        data_.colors.resize(data_.positions.size(), glm::vec4(k_no_color));
        const float scale = most_color_ > 1 ? 1 / 255.0f : 1;
        for (glm::vec4& c : data_.colors) {
            if (c.w == k_no_color) {
                c = glm::vec4(1);
                continue;
            }
            for (int i = 0; i < 3; ++i) c[i] = linear_from_srgb(scale * c[i]);
        }
    }

    void texcoord()
    {
        glm::vec2 t(0);
        float third = 0;
        bool finite = number(t.x, "a texture coordinate");
        if (!text_.at_end()) finite &= number(t.y, "a texture coordinate");
        if (!text_.at_end()) number(third, "a texture coordinate");
        not_finite_texcoords_ += !finite;
        data_.texcoords.push_back(t);
        known();
    }

    void smoothing()
    {
        const std::string_view word = text_.word();
        std::size_t at = 0;
        std::int64_t group = 0;
        if (word == "on")
            group = 1;
        else if (word != "off" && !word.empty() &&
                 (!ObjText::integer(word, at, group) || at != word.size() || group < 0 || group >= ObjFace::k_unset))
            text_.fail(fmt::format("expected a smoothing group, found '{}'", shown(word)));
        smoothing_ = static_cast<std::uint32_t>(group);
        known();
    }

    void face()
    {
        const std::size_t first = data_.corners.size();
        while (!text_.at_end()) data_.corners.push_back(corner(text_.word()));
        const std::size_t count = data_.corners.size() - first;
        known();
        if (count < 3) {
            data_.corners.resize(first);
            return warn_once("faces with fewer than three corners are left out");
        }
        if (data_.corners.size() >= k_no_index) text_.fail("too many corners");
        data_.faces.push_back(
            {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(count), object(), material_, smoothing_});
    }

    // position[/[texcoord][/normal]]
    ObjCorner corner(std::string_view word)
    {
        ObjCorner result;
        std::size_t at = 0;
        result.position = index(word, at, data_.positions.size(), ahead_[0], "vertex");
        if (at < word.size() && word[at] == '/') {
            ++at;
            if (at < word.size() && word[at] != '/')
                result.texcoord = index(word, at, data_.texcoords.size(), ahead_[1], "texture coordinate");
            if (at < word.size() && word[at] == '/') {
                ++at;
                if (at < word.size()) result.normal = index(word, at, data_.normals.size(), ahead_[2], "normal");
            }
        }
        if (at != word.size()) text_.fail(fmt::format("expected a face corner, found '{}'", shown(word)));
        return result;
    }

    // A largest index that points ahead in the file. It is valid if the file has that many elements in the end.
    struct Ahead {
        std::int64_t largest = -1;
        std::string place;
    };

    std::uint32_t index(std::string_view word, std::size_t& at, std::size_t have, Ahead& ahead, const char* what)
    {
        std::int64_t value = 0;
        if (!ObjText::integer(word, at, value))
            text_.fail(fmt::format("expected a face corner, found '{}'", shown(word)));
        const auto count = static_cast<std::int64_t>(have);
        // Negative indices count backwards from the last element.
        if (value < 0 ? value < -count : value == 0 || value >= k_no_index)
            text_.fail(fmt::format("{} {} is out of range: there are {}", what, value, count));
        if (value < 0) return static_cast<std::uint32_t>(count + value);
        if (value > count && value - 1 > ahead.largest) ahead = {value - 1, text_.place()};
        return static_cast<std::uint32_t>(value - 1);
    }

    std::uint32_t object()
    {
        if (current_ != k_no_index) return current_;
        // All faces with the same name belong to one object, wherever they are in the file.
        std::string name = object_;
        if (!group_.empty()) name += (name.empty() ? "" : "/") + group_;
        const auto [at, added] = object_ids_.try_emplace(name, data_.objects.size());
        if (added) data_.objects.push_back(name);
        return current_ = static_cast<std::uint32_t>(at->second);
    }

    void finish()
    {
        if (!any_known_) throw InputError(text_.file(), "", "contains no OBJ statement");
        finish_colors();
        const std::size_t have[3] = {data_.positions.size(), data_.texcoords.size(), data_.normals.size()};
        const char* const what[3] = {"vertex", "texture coordinate", "normal"};
        // Accept files that omit all normals but not their indices, because normals can be computed.
        if (data_.normals.empty() && ahead_[2].largest >= 0) {
            warnings_.emplace_back("faces refer to normals, but there are none: normals are computed");
            for (ObjCorner& corner : data_.corners) corner.normal = k_no_index;
            ahead_[2].largest = -1;
        }
        if (not_finite_normals_ > 0)
            warnings_.push_back(fmt::format("{} {} not finite: computed from faces", not_finite_normals_,
                                            not_finite_normals_ == 1 ? "normal is" : "normals are"));
        if (not_finite_texcoords_ > 0)
            warnings_.push_back(
                fmt::format("{} {} not finite: set to 0", not_finite_texcoords_,
                            not_finite_texcoords_ == 1 ? "texture coordinate is" : "texture coordinates are"));
        for (int i = 0; i < 3; ++i) {
            if (ahead_[i].largest >= static_cast<std::int64_t>(have[i]))
                throw InputError(
                    text_.file(), ahead_[i].place,
                    fmt::format("{} {} is out of range: there are {}", what[i], ahead_[i].largest + 1, have[i]));
        }
        if (std::string commas = text_.comma_warning(); !commas.empty()) warnings_.push_back(std::move(commas));
        if (unknown_.size() > k_most_unknown_keywords)
            warnings_.emplace_back("further unknown keywords are ignored, too");
    }

    void known() { any_known_ = true; }
    void unknown(std::string_view keyword)
    {
        if (unknown_.size() > k_most_unknown_keywords) return;
        if (!unknown_.emplace(keyword).second || unknown_.size() > k_most_unknown_keywords) return;
        warnings_.push_back(
            fmt::format("line {}: keyword '{}' is not supported and ignored", text_.line(), shown(keyword)));
    }
    void warn_once(const char* what)
    {
        if (warned_.insert(what).second) warnings_.push_back(fmt::format("line {}: {}", text_.line(), what));
    }

    ObjText& text_;
    bool strict_;
    std::vector<std::string>& warnings_;
    std::size_t not_finite_normals_ = 0, not_finite_texcoords_ = 0;
    ObjData data_;
    std::unordered_map<std::string, std::size_t> material_ids_, object_ids_;
    std::string object_, group_;
    std::uint32_t current_ = k_no_index;   // the object of the next face, if it exists already
    std::uint32_t material_ = 0;
    std::uint32_t smoothing_ = ObjFace::k_unset;
    Ahead ahead_[3];
    float most_color_ = 0;
    std::set<std::string, std::less<>> unknown_;
    std::set<std::string_view> warned_;
    bool any_known_ = false;
};

}   // namespace

ObjData parse_obj(ObjText& text, bool strict, std::vector<std::string>& warnings)
{
    return Parser(text, strict, warnings).run();
}

}   // namespace gnomon::io
