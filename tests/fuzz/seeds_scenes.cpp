// SPDX-License-Identifier: Apache-2.0
// AFF, OBJ and MTL with every statement. They refer to t.ppm, t.png, part.aff and m.mtl, which targets.cpp puts into
// the same folder.
#include <string>

#include "fuzz/seeds.h"

namespace gnomon::fuzz {

namespace {

Bytes bytes_of(const std::string& text)
{
    return {text.begin(), text.end()};
}

const char* const k_aff_scene = R"(# all statements
v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 0.1 resolution 64 48
a 0 3 10
b .1 .2 .3
am .1 .1 .1
l 1 2 3 1 1 1
l 1 2 3
la lite 3 2 1 1 1 1
d 1
f .5 .5 .5 .8 .2 10 0 1
p 3 0 0 0 1 0 0 0 1 0
fm .1 .1 .1 .5 .5 .5 .2 .2 .2 10 .5 1.5
s 0 0 0 1
s 0 1 0 -.5
c 0 0 0 1 0 0 1 .5
pp 4 0 0 0 0 0 1 1 0 0 0 0 1 1 1 0 0 0 1 0 1 0 0 0 1
tt t.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1
ttp t.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1 0 0 0 1 0 0 0 1 0
tpa 2 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1
m vertices 4 0 0 0 1 0 0 0 1 0 1 1 0 normals 1 0 0 1 texturecoords 2 t.ppm 0 0 1 1
  triangles 2 0 1 2 0 0 0 0 1 0 1 2 3 0 0 0 0 0 1
i 0 part.aff
i 9 part.aff
xs 1 2 3 0 1 0 90 1 0 0 { m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 2 }
)";

const char* const k_aff_moving = R"(a 0 3 4
f 1 1 1 1 0 1 0 1
x thing { s 0 0 0 1 x inner { p 3 0 0 0 1 0 0 0 1 0 } }
la lite 3 2 1
k thing {
  transl 4 0 0 0 0 0 0 0  1 1 0 0 0 0 0  2 2 0 0 .5 .5 .5  3 3 0 0 0 0 0
  scale 4 0 1 1 1 0 0 0  1 1 2 1 0 0 0  2 1 1 2 0 0 0  3 1 1 1 0 0 0
  rot 4 0 0 0 1 0 0 0 0  1 0 1 0 90 0 0 0  2 1 0 0 180 -1 0 1  3 0 0 1 400 0 0 0
  visibility 2 0 1 2 0
}
k inner { visibility 1 0 1 }
k lite { transl 4 0 0 0 0 0 0 0  1 1 0 0 0 0 0  2 2 0 0 0 0 0  3 3 0 0 0 0 0 }
)";

const char* const k_obj_scene =
    "# all of it\r\nmtllib m.mtl\no first one\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 .5 .5 .5\nv 0 1e0 0\nv .5 .25 -1\n"
    "vt 0 0\nvt 1 0 0\nvt 1 1\nvn 0 0 1\nvn 0 0 -1\ng group\ns 1\nusemtl red\nf 1/1/1 2/2/1 3/3/1\n"
    "f -1//-1 -2//-1 -3//-1\ns off\nusemtl blue \r\nf 1 2 \\\n 3 4 5\nf 1/1 2/2 3/3 4/1\nl 1 2\np 1\nvp 0.1\n";
// A concave polygon with smoothing, and one that intersects itself.
const char* const k_obj_polygons =
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nv 1 1 1\ns 2\nf 1 2 3 4 5\nf 1 3 2 5\nf 1 2 6\nf 6 6 6\nusemtl "
    "none\n"
    "curv 0 1 1 2\ncstype bezier\nlod 1\nshadow_obj x\nf 1 2 3\n";

const char* const k_mtl_all = R"(newmtl red
Ka 1 1 1
Kd .5 0 0
Ks 1 1 1
Ns 10
d 0.5
Tr 0.5
Ni 1.5
illum 7
Tf 1 1 1
map_Kd -s 1 2 3 -o 0 1 -clamp on t.png
map_d -imfchan r t.png

newmtl blue
Ke 1 1 1
Pr .5
Pm .5
bump -bm 2 t.png
norm t.png
map_Pr -mm 0 1 t.png
map_Pm t.png
map_Ke t.png
unknown 1
)";
const char* const k_mtl_odd = R"(newmtl red
d -halo 0.5
Kd spectral x.rfl 1
Ks xyz 1 1 1
Tf .5
illum 4
map_Kd -blendu off -t 0 0 0 -texres 4 t.png
disp t.png
decal t.png
refl -type sphere t.png
newmtl red
map_Bump t.png
map_Kd no.png
Pc 1
)";

}   // namespace

std::vector<Bytes> aff_seeds()
{
    return {bytes_of(k_aff_scene), bytes_of(k_aff_moving)};
}

std::vector<Bytes> obj_seeds()
{
    return {bytes_of(k_obj_scene), bytes_of(k_obj_polygons)};
}

std::vector<Bytes> mtl_seeds()
{
    return {bytes_of(k_mtl_all), bytes_of(k_mtl_odd)};
}

std::vector<Bytes> ply_seeds()
{
    const std::string properties =
        "comment made\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
        "property float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty "
        "float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n";
    const std::string text = "ply\nformat ascii 1.0\n" + properties +
                             "0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 255 0 1 0\n1 1 0 0 0 1 0 0 255 1 1\n"
                             "0 1 0 0 0 1 9 9 9 0 1\n4 0 1 2 3\n7 0 1 2 3 -1 0 1\n";
    const auto binary = [&](bool big) {
        std::string s = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + properties;
        const auto put = [&](const void* from, std::size_t size) {
            const char* const bytes = static_cast<const char*>(from);
            for (std::size_t i = 0; i < size; ++i) s += bytes[big ? size - 1 - i : i];
        };
        for (int v = 0; v < 4; ++v) {
            const float before[] = {v % 2 ? 1.0f : 0.0f, v / 2 ? 1.0f : 0.0f, 0, 0, 0, 1}, after[] = {.5f, .25f};
            for (const float x : before) put(&x, 4);
            s += "\x10\x80\xf0";
            for (const float x : after) put(&x, 4);
        }
        const std::int32_t face[] = {0, 1, 3, 2}, strip[] = {7, 0, 1, 2, 3, -1, 0, 1};
        s += '\4';
        for (const std::int32_t i : face) put(&i, 4);
        for (const std::int32_t i : strip) put(&i, 4);
        return bytes_of(s);
    };
    return {bytes_of(text), binary(false), binary(true)};
}

std::vector<Bytes> stl_seeds()
{
    std::string binary(80, ' ');
    const auto put = [&](const void* from) { binary.append(static_cast<const char*>(from), 4); };
    const std::uint32_t facets = 2;
    put(&facets);
    for (std::uint32_t f = 0; f < facets; ++f) {
        for (int i = 0; i < 12; ++i) {
            const float x = static_cast<float>((i * 7 + static_cast<int>(f)) % 5);
            put(&x);
        }
        binary.append(2, '\0');
    }
    return {
        bytes_of(binary),
        bytes_of("solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e0 0 0\nvertex 0 1 -.5\nendloop\n"
                 "endfacet\nendsolid a b\nsolid\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\n"
                 "VERTEX 0 1 0\nENDLOOP\nENDFACET\nENDSOLID\n")};
}

}   // namespace gnomon::fuzz
