// SPDX-License-Identifier: Apache-2.0
#include "gnomon/devices.h"

#include "ray/ray_scene.h"
#ifdef GNOMON_VULKAN
#include <fmt/format.h>

#include "gnomon/error.h"
#include "vk/instance.h"
#endif

namespace gnomon {

Devices devices()
{
    Devices result;
    result.packet_width = ray::RayScene::packet_width();
#ifdef GNOMON_VULKAN
    result.vulkan_built = true;
    try {
        for (const vk::DeviceInfo& d : vk::Instance::get()->devices())
            result.vulkan.push_back(
                {d.name, d.kind, d.driver,
                 fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(d.api_version), VK_API_VERSION_MINOR(d.api_version),
                             VK_API_VERSION_PATCH(d.api_version)),
                 d.memory, d.suitable, d.chosen, d.reasons, d.no_rays});
    } catch (const MissingError& error) {
        result.vulkan_missing = error.what();
    }
#endif
    return result;
}

}   // namespace gnomon
