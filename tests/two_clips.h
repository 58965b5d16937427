// SPDX-License-Identifier: Apache-2.0
#pragma once
// A glTF file with two clips that move the same node: a triangle that walks along x in one second, or jumps along y in
// two.
#include <fstream>
#include <string>
#include <vector>

namespace gnomon::test {

/// Writes PATH and PATH.bin. @param path  ends in the name of the file
inline void write_two_clips(const std::string& path)
{
    const std::vector<float> values{-1, -1, 0, 1, -1, 0, 0, 1, 0,   // positions
                                    0,  1,                          // times of both
                                    0,  2,  0, 0, 0,  1, 0, 0,      // along x
                                    0,  0,  0, 0, 1,  0};           // along y
    std::ofstream(path + ".bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    const std::string name = path.substr(path.find_last_of('/') + 1);
    std::ofstream(path) << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0},{"camera":0,"translation":[0,0,6]}],
"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"animations":[
{"name":"walk","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"samplers":[{"input":1,"output":3}]},
{"name":"jump","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"samplers":[{"input":2,"output":4}]}],
"accessors":[
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]},
{"bufferView":0,"byteOffset":36,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},
{"bufferView":0,"byteOffset":44,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]},
{"bufferView":0,"byteOffset":52,"componentType":5126,"count":2,"type":"VEC3"},
{"bufferView":0,"byteOffset":76,"componentType":5126,"count":2,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":100}],"buffers":[{"byteLength":100,"uri":")" +
                               name + R"(.bin"}]})";
}

}   // namespace gnomon::test
