// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small AFF files for tests, in a scratch folder with the layout that the format requires.

#include <fstream>
#include <string>

#include "gnomon/error.h"
#include "io/load.h"
#include "support.h"

namespace gnomon::test {

class AffFolder {
 public:
    AffFolder()
    {
        std::filesystem::create_directory(aff());
        std::filesystem::create_directory(textures());
    }
    std::filesystem::path aff() const { return scratch_ / "aff"; }
    std::filesystem::path textures() const { return scratch_ / "TextureFiles"; }
    std::filesystem::path main() const { return aff() / "main.aff"; }

    void write(const std::filesystem::path& file, const std::string& bytes) const
    {
        std::ofstream out(file, std::ios::binary);
        out << bytes;
        ASSERT_TRUE(out.good());
    }
    /// Beside the main file.
    void include(const std::string& name, const std::string& text) const { write(aff() / name, text); }
    /// Two texels side by side: red, blue.
    void texture(const std::string& name) const
    {
        write(textures() / name, std::string("P6\n2 1\n255\n\xff\x00\x00\x00\x00\xff", 17));
    }

    scene::Scene load(const std::string& text) const
    {
        write(main(), text);
        return io::load_aff(main());
    }

 private:
    ScratchFolder scratch_;
};

inline const std::string k_mesh = "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 2\n";
inline const std::string k_material = "fm .1 .1 .1  .5 .5 .5  .2 .2 .2  10 0 1\n";

}   // namespace gnomon::test
