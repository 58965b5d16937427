// SPDX-License-Identifier: Apache-2.0
// Command lines, --config files, and what simulators upload.
#include <string>

#include "fuzz/seeds.h"

namespace gnomon::fuzz {

namespace {

Bytes bytes_of(const std::string& text)
{
    return {text.begin(), text.end()};
}

}   // namespace

// The first byte selects the subcommand, in the order of the table.
std::vector<Bytes> config_seeds()
{
    return {bytes_of(std::string("\0", 1) + R"({"out":"a.png","size":"64x48","frames":"1-3","threads":2,"json":true})"),
            bytes_of(std::string("\0", 1) + R"({"light":["point 0 1 2 3 3 3"],"exposure":"auto","resume":false})"),
            bytes_of("\x08"
                     R"({"method":["paper","certified"],"no-counts":true,"lights":4,"json":"a.json"})"),
            bytes_of("\x01{}")};
}

std::vector<Bytes> option_seeds()
{
    return {bytes_of("render\na.aff\n-o\nb.png\n--size\n64x48\n--frame\n3\n--json=a.json"),
            bytes_of("render\na.aff\n--out=b.mp4\n--frames\n1-9\n--chunk\n1/3\n--exposure\nauto\n--resume"),
            bytes_of("render\na.aff\n-o\nb.png\n--light\nspot 0 1 2 0 0 -1 30 1 1 1\n--threads\n2"),
            bytes_of("bench\nculling\na.aff\n--method\npaper\ncertified\n--frames\n1-22"),
            bytes_of("bench\nshadow-textures\n--objects\n25\n50\n--dynamic\n0\n10.5"),
            bytes_of("compare\na.png\nb.png\n--json"),
            bytes_of("info\na.aff\n--json"),
            bytes_of("render\n--help"),
            bytes_of("--version"),
            bytes_of("devices"),
            bytes_of("serve\n--address\n127.0.0.1:0\n--max-size\n64x48")};
}

std::vector<Bytes> upload_seeds()
{
    const std::string text = R"({"cameras":[{}],"nodes":[{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]},)"
                             R"({"children":[2],"translation":[1,2,3],"rotation":[0,0,0,1],"scale":[1,2,3]},)"
                             R"({"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]}],)"
                             R"("extensions":{"KHR_lights_punctual":{"lights":[]}}})";
    std::string binary("glTF\2\0\0\0\0\0\0\0", 12);
    for (int i = 0; i < 4; ++i) binary.push_back(static_cast<char>(text.size() >> (8 * i)));
    return {bytes_of(text), bytes_of(binary + "JSON" + text + "binary data")};
}

}   // namespace gnomon::fuzz
