// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tests on a Vulkan device with validation: any message of the validation layer fails the test, including messages
// about objects that outlive the device.

#include <gtest/gtest.h>

#define GNOMON_SKIP_WITHOUT_VULKAN GTEST_SKIP() << "built without Vulkan: its packages are missing (see dev)"

#ifdef GNOMON_VULKAN
#include <cstdlib>
#include <memory>

#include "vk/commands.h"

namespace gnomon::test {

/// Holds a device with validation. The suites that use Vulkan derive from it.
class VulkanTest : public testing::Test {
 protected:
    VulkanTest()
    {
        ::setenv("GNOMON_VULKAN_VALIDATION", "1", 1);   // if the tests are started without ctest
        device_ = vk::Device::open();
        EXPECT_TRUE(device_->instance().validates());
    }
    ~VulkanTest() override
    {
        device_.reset();
        for (const std::string& message : vk::take_validation_messages()) ADD_FAILURE() << message;
    }
    std::shared_ptr<vk::Device> device_;
};

/// Replaces one of volk's entry points for its own lifetime.
template <class Function>
class Replaced {
 public:
    Replaced(Function& entry, Function by) : entry_(entry), before_(entry) { entry = by; }
    ~Replaced() { entry_ = before_; }
    Replaced(const Replaced&) = delete;
    Replaced& operator=(const Replaced&) = delete;

 private:
    Function& entry_;
    Function before_;
};

}   // namespace gnomon::test
#endif
