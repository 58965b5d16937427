// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the tested build lies. In a file of its own, so that no other one depends on the build's folder: compilers'
// caches then serve several checkouts.

#include <string>

namespace gnomon::test::places {

extern const std::string scenes;           // real scenes, unless GNOMON_SCENES is set
extern const std::string source_folder;    // the checkout
extern const std::string program;          // empty: it was not built
extern const std::string failing_vulkan;   // the folder of failing_vulkan.cpp; empty: it was not built
extern const std::string losing_power;     // the library of losing_power.cpp; empty: it was not built

}   // namespace gnomon::test::places
