// SPDX-License-Identifier: Apache-2.0
// A Vulkan loader that fails. It is loaded instead of the real one (LD_LIBRARY_PATH) and forwards all calls, except
// those that GNOMON_TEST_VULKAN_FAULT names, counted over the whole process:
//   lost:N     the N-th submission, and all after it, lose the device
//   waiting:N  the N-th wait for a fence, and all after it, lose the device
//   memory:N   the N-th allocation of device memory, and all after it, fail
//   feature    no device supports multiDrawIndirect
//   extension  no device has an extension
// So the program as a whole is tested: exit code, message, files.
#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <string_view>

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

namespace {

template <class Function>
Function real(const char* name)
{
    // By its full path, because the plain name would find this library.
    static void* const loader = ::dlopen(GNOMON_VULKAN_LOADER, RTLD_NOW | RTLD_LOCAL);
    return loader ? reinterpret_cast<Function>(::dlsym(loader, name)) : nullptr;
}

/// Whether this call of `what` has to fail: it is the N-th or a later one.
bool fails(std::string_view what)
{
    const char* const said = std::getenv("GNOMON_TEST_VULKAN_FAULT");
    const std::string_view fault = said ? said : "";
    if (!fault.starts_with(what)) return false;
    const std::string_view from = fault.substr(what.size());
    static std::atomic<int> times{0};
    return ++times >= (from.starts_with(':') ? std::atoi(from.data() + 1) : 1);
}

PFN_vkQueueSubmit2 submit = nullptr;
PFN_vkWaitForFences wait_for = nullptr;
PFN_vkAllocateMemory allocate = nullptr;
PFN_vkGetPhysicalDeviceFeatures2 features = nullptr;
PFN_vkEnumerateDeviceExtensionProperties extensions = nullptr;
PFN_vkGetDeviceProcAddr of_device = nullptr;

VkResult VKAPI_CALL submit_or_lose(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* infos, VkFence fence)
{
    return fails("lost") ? VK_ERROR_DEVICE_LOST : submit(queue, count, infos, fence);
}

VkResult VKAPI_CALL wait_or_lose(VkDevice device, std::uint32_t count, const VkFence* fences, VkBool32 all,
                                 std::uint64_t time)
{
    const VkResult result = wait_for(device, count, fences, all, time);
    return fails("waiting") ? VK_ERROR_DEVICE_LOST : result;
}

VkResult VKAPI_CALL allocate_or_refuse(VkDevice device, const VkMemoryAllocateInfo* info,
                                       const VkAllocationCallbacks* by, VkDeviceMemory* memory)
{
    return fails("memory") ? VK_ERROR_OUT_OF_DEVICE_MEMORY : allocate(device, info, by, memory);
}

void VKAPI_CALL fewer_features(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* found)
{
    features(device, found);
    if (fails("feature")) found->features.multiDrawIndirect = VK_FALSE;
}

VkResult VKAPI_CALL fewer_extensions(VkPhysicalDevice device, const char* layer, std::uint32_t* count,
                                     VkExtensionProperties* found)
{
    if (!fails("extension")) return extensions(device, layer, count, found);
    *count = 0;
    return VK_SUCCESS;
}

PFN_vkVoidFunction VKAPI_CALL look_up_in_device(VkDevice device, const char* name);

/// The replacement of a function that can fail; otherwise the function itself.
PFN_vkVoidFunction stand_in(std::string_view name, PFN_vkVoidFunction found)
{
    if (!found) return nullptr;
    const auto replace = [found](auto& kept, auto* by) {
        kept = reinterpret_cast<decltype(by)>(found);
        return reinterpret_cast<PFN_vkVoidFunction>(by);
    };
    if (name == "vkQueueSubmit2") return replace(submit, &submit_or_lose);
    if (name == "vkWaitForFences") return replace(wait_for, &wait_or_lose);
    if (name == "vkAllocateMemory") return replace(allocate, &allocate_or_refuse);
    if (name == "vkGetPhysicalDeviceFeatures2") return replace(features, &fewer_features);
    if (name == "vkEnumerateDeviceExtensionProperties") return replace(extensions, &fewer_extensions);
    if (name == "vkGetDeviceProcAddr") return replace(of_device, &look_up_in_device);
    return found;
}

PFN_vkVoidFunction VKAPI_CALL look_up_in_device(VkDevice device, const char* name)
{
    return stand_in(name, of_device(device, name));
}

}   // namespace

extern "C" __attribute__((visibility("default"))) PFN_vkVoidFunction VKAPI_CALL
vkGetInstanceProcAddr(VkInstance instance, const char* name)
{
    if (std::string_view(name) == "vkGetInstanceProcAddr")
        return reinterpret_cast<PFN_vkVoidFunction>(&vkGetInstanceProcAddr);
    const auto look_up = real<PFN_vkGetInstanceProcAddr>("vkGetInstanceProcAddr");
    return look_up ? stand_in(name, look_up(instance, name)) : nullptr;
}
