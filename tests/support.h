// SPDX-License-Identifier: Apache-2.0
#pragma once
// What tests share: where the scenes are, running the program, scratch folders.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace gnomon::test {

/// Folder of real scenes: GNOMON_SCENES from the environment, else the default of the build.
inline std::filesystem::path scenes()
{
    const char* env = std::getenv("GNOMON_SCENES");
    return env && *env ? env : GNOMON_SCENES_DEFAULT;
}

/// A fresh folder that goes with the object.
class ScratchFolder {
 public:
    ScratchFolder()
    {
        std::string pattern = (std::filesystem::temp_directory_path() / "gnomon-test-XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("mkdtemp failed");
        path_ = pattern;
    }
    ~ScratchFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
    std::filesystem::path path_;
};

}   // namespace gnomon::test

/// Skips a test, aloud, where the real scenes are not at hand.
#define GNOMON_NEED_SCENE(variable, relative)                                     \
    const std::filesystem::path variable = ::gnomon::test::scenes() / (relative); \
    if (!std::filesystem::exists(variable))                                       \
    GTEST_SKIP() << "no " << (variable) << ": set GNOMON_SCENES to the folder of test scenes"
