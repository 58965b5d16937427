// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shared by all tests: the scene folder, scratch folders, environment variables.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "places.h"

namespace gnomon::test {

/// The folder of real scenes: GNOMON_SCENES from the environment, else the default of the build.
inline std::filesystem::path scenes()
{
    const char* env = std::getenv("GNOMON_SCENES");
    return env && *env ? env : places::scenes;
}

/// A new folder that is removed with the object.
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

/// Sets an environment variable for the lifetime of the object.
class ScopedVariable {
 public:
    ScopedVariable(std::string name, const std::string& value) : name_(std::move(name))
    {
        if (const char* before = std::getenv(name_.c_str())) before_ = before;
        ::setenv(name_.c_str(), value.c_str(), 1);
    }
    ~ScopedVariable()
    {
        if (before_)
            ::setenv(name_.c_str(), before_->c_str(), 1);
        else
            ::unsetenv(name_.c_str());
    }
    ScopedVariable(const ScopedVariable&) = delete;
    ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
    std::string name_;
    std::optional<std::string> before_;
};

}   // namespace gnomon::test

/// Skips a test with a message if the real scenes are missing.
#define GNOMON_NEED_SCENE(variable, relative)                                     \
    const std::filesystem::path variable = ::gnomon::test::scenes() / (relative); \
    if (!std::filesystem::exists(variable))                                       \
    GTEST_SKIP() << "no " << (variable) << ": set GNOMON_SCENES to the folder of test scenes"
