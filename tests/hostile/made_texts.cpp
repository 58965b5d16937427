// SPDX-License-Identifier: Apache-2.0
// OBJ with MTL, and AFF: in text formats every number of a valid scene is replaced by every kind of bad number in turn.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "hostile/made_scenes.h"

namespace gnomon::test {

namespace {
using Files = std::map<std::string, std::string>;

const char* const k_obj = R"(mtllib m.mtl
v -4 -1 -4
v 4 -1 -4
v 4 -1 4
v -4 -1 4
v -1 0 0
v 1 0 0
v 0 1.5 -.5
vt 0 0
vt 1 0
vt 1 1
vn 0 1 0
vn 0 0 1
usemtl floor
f 1/1/1 2/2/1 3/3/1 4/1/1
usemtl glass
s 1
f 5/1/2 6/2/2 7/3/2
f -1//-1 -2//-1 -3//-1
)";
const char* const k_mtl = R"(newmtl floor
Ka .1 .1 .1
Kd .7 .6 .5
Ks .1 .1 .1
Ns 10
map_Kd -s 2 2 1 -o .1 0 0 t.png
bump -bm .5 t.png
newmtl glass
Kd .1 .1 .1
Ke .2 0 0
d .5
Ni 1.5
Tf .9 .9 .9
illum 7
Pr .3
Pm .1
)";
const char* const k_aff = R"(v from 0 1 6 at 0 0 0 up 0 1 0 angle 40 hither .1 resolution 64 48
b .1 .2 .3
am .1 .1 .1
a 0 3 4
l 3 4 2 .7 .7 .7
la lite 0 3 0 .3 .3 .3
f .8 .7 .6 .8 .1 10 0 1
p 4 -4 -1 -4 -4 -1 4 4 -1 4 4 -1 -4
fm .1 .1 .1 .5 .5 .5 .2 .2 .2 10 .3 1.3
s -1 0 0 .6
c 1 -1 0 .5 1 .5 0 .2
pp 3 0 0 -1 0 0 1 1 0 -1 0 0 1 0 1 -1 0 0 1
tt t.ppm -2 0 -1 0 0 -2 1 -1 1 0 -2 0 -1 0 1
x thing {
xs 1 1.2 1 0 1 0 30 0 .2 0 {
m vertices 4 0 0 0 1 0 0 0 1 0 1 1 .2 normals 1 0 0 1 texturecoords 2 t.ppm 0 0 1 1
triangles 2 0 1 2 0 0 0 0 1 0 1 3 2 0 0 0 0 0 1
}
}
k thing {
transl 4 0 0 0 0 0 0 0 1 1 0 0 0 0 0 2 1 1 0 .1 .2 .3 3 0 0 0 0 0 0
rot 4 0 0 1 0 0 0 0 0 1 0 1 0 90 0 0 0 2 0 1 0 180 0 0 0 3 1 0 0 270 0 0 0
scale 4 0 1 1 1 0 0 0 1 1 2 1 0 0 0 2 1 1 1 0 0 0 3 1 1 1 0 0 0
visibility 2 0 1 2 1
}
)";

Files obj_files(const std::string& obj, const std::string& mtl)
{
    return {{"scene.obj", obj}, {"m.mtl", mtl}, {"t.png", made_png(8, 8, true)}};
}

Files aff_files(const std::string& text)
{
    return {{"aff/scene.aff", text}, {"TextureFiles/t.ppm", made_ppm(8, 8, true)}};
}

struct Token {
    std::size_t begin, size;
};

// Words that are, contain, or begin with a number.
std::vector<Token> numbers_of(const std::string& text)
{
    std::vector<Token> found;
    for (std::size_t i = 0; i < text.size();) {
        while (i < text.size() && std::isspace(static_cast<unsigned char>(text[i]))) ++i;
        const std::size_t begin = i;
        while (i < text.size() && !std::isspace(static_cast<unsigned char>(text[i]))) ++i;
        if (i > begin &&
            (std::isdigit(static_cast<unsigned char>(text[begin])) || text[begin] == '-' || text[begin] == '.') &&
            text.substr(begin, i - begin).find_first_of("0123456789") != std::string::npos)
            found.push_back({begin, i - begin});
    }
    return found;
}

// Two bad values for every number, different ones each time.
template <class FilesOf>
void add_numbers(std::vector<MadeScene>& scenes, const std::string& format, const std::string& text,
                 const FilesOf& files_of)
{
    const char* const k_values[] = {"nan",  "-inf",       "1e39",       "1e300", "-1", "0",     "1e-300", "1e30",
                                    "1e-6", "2147483648", "4294967297", "1e6",   "x",  "-1e12", "0x10"};
    std::size_t turn = 0;
    for (const Token& token : numbers_of(text))
        for (int k = 0; k < 2; ++k) {
            const std::string value = k_values[turn++ % std::size(k_values)];
            const auto line =
                1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(token.begin), '\n');
            std::string changed = text;
            changed.replace(token.begin, token.size, value);
            scenes.push_back(
                {fmt::format("{} line {}, {} -> {}", format, line, text.substr(token.begin, token.size), value),
                 Expected::either, "", [=] { return files_of(changed); }});
        }
}
}   // namespace

std::vector<MadeScene> made_obj_scenes()
{
    std::vector<MadeScene> scenes;
    const auto add = [&](const std::string& name, Expected expected, const std::function<std::string()>& obj) {
        scenes.push_back({"obj/" + name, expected, "", [obj] { return obj_files(obj(), k_mtl); }});
    };
    const Expected refused = Expected::refused, image = Expected::image, either = Expected::either;
    add("sound", image, [] { return k_obj; });
    add_numbers(scenes, "obj", k_obj, [](const std::string& text) { return obj_files(text, k_mtl); });
    add_numbers(scenes, "mtl", k_mtl, [](const std::string& text) { return obj_files(k_obj, text); });
    add("empty", refused, [] { return ""; });
    add("vertices alone", image, [] { return "v 0 0 0\nv 1 1 1\n"; });
    add("a million vertices and no face", either, [] {
        std::string text;
        for (int i = 0; i < 1'000'000; ++i) text += "v 0 0 0\n";
        return text;
    });
    add("all faces are points", image, [] {
        std::string text = "v 1 1 1\n";
        for (int i = 0; i < 20'000; ++i) text += "f 1 1 1\n";
        return text;
    });
    add("all faces are lines", image, [] {
        std::string text = "v 0 0 0\nv 1 1 1\nv 2 2 2\n";
        for (int i = 0; i < 20'000; ++i) text += "f 1 2 3\n";
        return text;
    });
    // A ray hits them all; ten times as many would take ten times as long.
    add("5000 triangles in one place", image, [] {
        std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (int i = 0; i < 5'000; ++i) text += "f 1 2 3\n";
        return text;
    });
    add("a polygon of 30000 corners that crosses itself", either, [] {
        std::string text, face = "f";
        for (int i = 0; i < 30'000; ++i) {
            text += fmt::format("v {} {} 0\n", i % 1000 * 7919 % 1000, i % 997 * 104729 % 1000);
            face += fmt::format(" {}", i + 1);
        }
        return text + face + "\n";
    });
    add("one line of 20 MB", either, [] { return "# " + std::string(20 << 20, 'x') + "\n" + k_obj; });
    add("a face of 10 MB", either, [] {
        std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
        while (text.size() < 10 << 20) text += " 1 2 3";
        return text;
    });
    for (const char* size : {"1e-38", "1e-20", "1e-4", "1e6", "1e15", "1e19", "1e38"})
        add(fmt::format("a world of {}", size), either, [size] {
            return fmt::format("v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n", size);
        });
    for (const char* far : {"1e4", "1e7", "1e20", "3e38"})
        add(fmt::format("a square at {}", far), either,
            [far] { return fmt::format("v {0} 0 0\nv {0} 1 0\nv {0} 1 1\nv {0} 0 1\nf 1 2 3 4\nf 4 3 2 1\n", far); });
    for (const char* index :
         {"0", "8", "-8", "99999999999", "1/9/1", "1/1/9", "/1/1", "1/1/1/1", "1.5", "-9999999999999999999"})
        add(fmt::format("a face with the corner {}", index), refused,
            [index] { return std::string(k_obj) + "f 1 2 " + index + "\n"; });
    for (const char* name :
         {"../m.mtl", "/etc/passwd", "no.mtl", ".", "/dev/zero", "a\x01z.mtl", "http://127.0.0.1:9/m.mtl"})
        add(fmt::format("materials from {}", name), either,
            [name] { return fmt::format("mtllib {}\n{}", name, k_obj); });
    for (const char* name : {"../t.png", "/etc/passwd", "no.png", ".", "/dev/zero", "m.mtl", "scene.obj", ""})
        scenes.push_back({fmt::format("mtl an image named '{}'", name), either, "", [name] {
                              return obj_files(k_obj,
                                               std::string("newmtl floor\nmap_Kd ") + name + "\nmap_d " + name + "\n");
                          }});
    scenes.push_back({"mtl 100000 materials", either, "", [] {
                          std::string mtl;
                          for (int i = 0; i < 100'000; ++i) mtl += fmt::format("newmtl m{}\nKd 1 1 1\n", i);
                          return obj_files(k_obj, mtl);
                      }});
    for (MadeScene& scene : scenes) scene.main = "scene.obj";
    return scenes;
}

std::vector<MadeScene> made_aff_scenes()
{
    std::vector<MadeScene> scenes;
    const auto add = [&](const std::string& name, Expected expected, const std::function<std::string()>& text) {
        scenes.push_back({"aff/" + name, expected, "", [text] { return aff_files(text()); }});
    };
    const Expected refused = Expected::refused, image = Expected::image, either = Expected::either;
    const std::string sound = k_aff;
    add("sound", image, [] { return k_aff; });
    add_numbers(scenes, "aff", k_aff, [](const std::string& text) { return aff_files(text); });
    add("empty", image, [] { return ""; });
    add("a file that includes itself", refused, [] { return "i 0 scene.aff\n"; });
    for (const char* name :
         {"../TextureFiles/t.ppm", "/etc/passwd", "no.aff", ".", "/dev/zero", "http://127.0.0.1:9/a"})
        add(fmt::format("includes {}", name), refused, [=] { return fmt::format("{}i 0 {}\n", k_aff, name); });
    for (const int depth : {100, 1'000, 100'000})
        add(fmt::format("{} transforms in one another", depth), either, [depth] {
            std::string text = k_aff;
            for (int i = 0; i < depth; ++i) text += "xs 1.01 1 1 0 1 0 1 0 0 0 { ";
            return text + "s 0 0 0 1 " + std::string(static_cast<std::size_t>(depth), '}') + "\n";
        });
    for (const int count : {1'000, 30'000, 1'000'000})
        add(fmt::format("{} lights", count), either, [count] {
            std::string text = k_aff;
            for (int i = 0; i < count; ++i) text += "l 1 2 3\n";
            return text;
        });
    for (const int count : {2'000, 50'000})
        add(fmt::format("{} spheres in one place", count), either, [count] {
            std::string text = k_aff;
            for (int i = 0; i < count; ++i) text += "s 0 0 0 1\n";
            return text;
        });
    // Mirroring glass as well: each ray splits into two at each hit, a thousand per pixel, and each of them hits all.
    for (const int count : {200, 50'000})
        add(fmt::format("{} mirrors in one another", count), either, [count] {
            std::string text = std::string(k_aff) + "f 1 1 1 0 1 10 1 1.5\n";
            for (int i = 0; i < count; ++i) text += fmt::format("s 0 0 0 {}\n", 1 + 1e-4 * i);
            return text;
        });
    for (const char* size : {"1e-30", "1e-6", "1e-4", "1e4", "1e6", "1e12", "1e30"})
        add(fmt::format("everything scaled by {}", size), either, [size] {
            return fmt::format(
                "v from 0 {0} {0} at 0 0 0 up 0 1 0 angle 40 hither 0.1 resolution 64 48\nl {0} {0} {0}\n"
                "f 1 1 1 .8 .1 10 .2 1\nxs {0} {0} {0} 0 1 0 0 0 0 0 {{ s 0 0 0 .5\n"
                "p 4 -4 -1 -4 -4 -1 4 4 -1 4 4 -1 -4 }}\n",
                size);
        });
    add("a camera in a sphere", image, [=] { return sound + "s 0 1 6 .5\n"; });
    add("a camera on a sphere", image, [=] { return sound + "s 0 1 5 1\n"; });
    add("a light in a sphere", image, [=] { return sound + "s 3 4 2 .5\n"; });
    add("a light on a floor", image, [=] { return sound + "l 0 -1 0 1 1 1\n"; });
    add("a sphere around it all, of glass", image, [=] { return sound + "f 1 1 1 0 .5 10 1 1.5\ns 0 0 0 50\n"; });
    add("looking along up", either, [] { return "v from 0 9 0 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 8\n"; });
    add("looking nowhere", either, [] { return "v from 0 0 0 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 8\n"; });
    add("two tracks for one thing", either, [=] { return sound + "k thing { visibility 1 0 1 }\n"; });
    add("a track for nothing", either, [=] { return sound + "k nothing { visibility 1 0 1 }\n"; });
    const std::string part = "tt t.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\n";
    for (const auto& [name, bytes] :
         std::map<std::string, std::string>{{"of 60000 x 60000", made_ppm(60000, 60000, false)},
                                            {"of 0 x 0", made_ppm(0, 0, false)},
                                            {"that is cut off", made_ppm(20, 20, false)},
                                            {"that is empty", ""},
                                            {"that is a text", "hello"}})
        scenes.push_back({"aff/a texture " + name, refused, "", [=, bytes = bytes] {
                              Files files = aff_files(sound + part);
                              files["TextureFiles/t.ppm"] = bytes;
                              return files;
                          }});
    for (MadeScene& scene : scenes) scene.main = "aff/scene.aff";
    return scenes;
}

}   // namespace gnomon::test
