// SPDX-License-Identifier: Apache-2.0
#include "vk/instance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <utility>

#include "gnomon/error.h"
#include "vk/features.h"

namespace gnomon::vk {

namespace {

constexpr VkQueueFlags k_queue_needs = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
constexpr const char* k_validation_layer = "VK_LAYER_KHRONOS_validation";

std::mutex message_mutex;
std::vector<std::string> messages;

VKAPI_ATTR VkBool32 VKAPI_CALL note_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data, void*)
{
    const std::lock_guard lock(message_mutex);
    messages.emplace_back(data->pMessage);
    return VK_FALSE;
}

bool validation_wanted()
{
    const char* value = std::getenv("GNOMON_VULKAN_VALIDATION");
    return value && std::strcmp(value, "1") == 0;
}

void load_entry_points()
{
    static std::once_flag once;
    static VkResult result = VK_SUCCESS;
    std::call_once(once, [] { result = volkInitialize(); });
    if (result != VK_SUCCESS) throw MissingError("Vulkan: no loader is installed (libvulkan.so.1)");
    if (!vkEnumerateInstanceVersion) throw MissingError("Vulkan: the loader is older than Vulkan 1.3");
    std::uint32_t version = 0;
    check(vkEnumerateInstanceVersion(&version), "querying the loader version");
    if (version < VK_API_VERSION_1_3) throw MissingError("Vulkan: the loader is older than Vulkan 1.3");
}

bool has_layer(const char* name)
{
    std::uint32_t count = 0;
    check(vkEnumerateInstanceLayerProperties(&count, nullptr), "listing layers");
    std::vector<VkLayerProperties> layers(count);
    check(vkEnumerateInstanceLayerProperties(&count, layers.data()), "listing layers");
    return std::any_of(layers.begin(), layers.end(),
                       [&](const auto& l) { return std::strcmp(l.layerName, name) == 0; });
}

bool has_extension(const char* name)
{
    std::uint32_t count = 0;
    check(vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr), "listing extensions");
    std::vector<VkExtensionProperties> all(count);
    check(vkEnumerateInstanceExtensionProperties(nullptr, &count, all.data()), "listing extensions");
    return std::any_of(all.begin(), all.end(), [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

std::string kind_of(VkPhysicalDeviceType type)
{
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return "discrete";
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return "integrated";
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return "virtual";
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return "software";
        default:
            return "other";
    }
}

int rank_of(const std::string& kind)
{
    const char* const order[] = {"discrete", "integrated", "virtual", "other", "software"};
    return static_cast<int>(std::find(std::begin(order), std::end(order), kind) - std::begin(order));
}

DeviceInfo describe(VkPhysicalDevice device)
{
    DeviceInfo info;
    info.handle = device;
    VkPhysicalDeviceDriverProperties driver{};
    driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &driver;
    vkGetPhysicalDeviceProperties2(device, &properties);
    info.name = properties.properties.deviceName;
    info.kind = kind_of(properties.properties.deviceType);
    info.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
    info.api_version = properties.properties.apiVersion;
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(device, &memory);
    for (std::uint32_t h = 0; h < memory.memoryHeapCount; ++h)
        if (memory.memoryHeaps[h].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) info.memory += memory.memoryHeaps[h].size;

    // Find a queue with graphics and compute.
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    const auto family = std::find_if(families.begin(), families.end(),
                                     [](const auto& f) { return (f.queueFlags & k_queue_needs) == k_queue_needs; });
    info.queue_family = static_cast<std::uint32_t>(family - families.begin());

    if (info.api_version < VK_API_VERSION_1_3)
        info.reasons.push_back(fmt::format("it supports Vulkan {}.{}; 1.3 is required",
                                           VK_API_VERSION_MAJOR(info.api_version),
                                           VK_API_VERSION_MINOR(info.api_version)));
    else
        for (const std::string& feature : missing_features(device)) info.reasons.push_back("it lacks " + feature);
    if (info.api_version >= VK_API_VERSION_1_3)
        info.no_rays = missing_ray_tracing(device);
    else
        info.no_rays.emplace_back("Vulkan 1.3");
    if (family == families.end()) info.reasons.emplace_back("it has no queue with graphics and compute");
    info.suitable = info.reasons.empty();
    return info;
}

}   // namespace

std::vector<std::string> take_validation_messages()
{
    const std::lock_guard lock(message_mutex);
    return std::exchange(messages, {});
}

void check_validation()
{
    const std::vector<std::string> said = take_validation_messages();
    if (said.empty()) return;
    std::string text = said.front();
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw InternalError(fmt::format("Vulkan validation: {}", text));
}

std::shared_ptr<Instance> Instance::get()
{
    static std::mutex mutex;
    static std::weak_ptr<Instance> present;
    const std::lock_guard lock(mutex);
    std::shared_ptr<Instance> instance = present.lock();
    if (!instance) present = instance = std::shared_ptr<Instance>(new Instance);
    return instance;
}

Instance::Instance()
{
    load_entry_points();
    const bool validate = validation_wanted();
    if (validate && !has_layer(k_validation_layer))
        throw MissingError("Vulkan: GNOMON_VULKAN_VALIDATION is set, but no validation layer is installed");
    debug_utils_ = has_extension(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "gnomon";
    application.apiVersion = VK_API_VERSION_1_3;

    // Prepare the debug messenger, and synchronisation validation.
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = note_message;

    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.pNext = &messenger;
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronisation;

    // Create the instance.
    std::vector<const char*> extensions;
    if (debug_utils_) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    VkInstanceCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    create.pApplicationInfo = &application;
    create.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    create.ppEnabledExtensionNames = extensions.data();
    if (validate) {
        create.pNext = &features;
        create.enabledLayerCount = 1;
        create.ppEnabledLayerNames = &k_validation_layer;
    }
    check(vkCreateInstance(&create, nullptr, &handle_), "creating an instance");
    volkLoadInstance(handle_);
    if (validate && debug_utils_) {
        const VkResult result = vkCreateDebugUtilsMessengerEXT(handle_, &messenger, nullptr, &messenger_);
        if (result != VK_SUCCESS) {
            vkDestroyInstance(handle_, nullptr);
            fail(result, "creating the debug messenger");
        }
    }
}

Instance::~Instance()
{
    if (messenger_) vkDestroyDebugUtilsMessengerEXT(handle_, messenger_, nullptr);
    vkDestroyInstance(handle_, nullptr);
}

std::vector<DeviceInfo> Instance::devices() const
{
    std::uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(handle_, &count, nullptr), "listing devices");
    std::vector<VkPhysicalDevice> handles(count);
    check(vkEnumeratePhysicalDevices(handle_, &count, handles.data()), "listing devices");
    std::vector<DeviceInfo> infos;
    for (const VkPhysicalDevice handle : handles) infos.push_back(describe(handle));

    // Sort the best first; devices of one kind keep the loader's order.
    std::stable_sort(infos.begin(), infos.end(), [](const DeviceInfo& a, const DeviceInfo& b) {
        if (a.suitable != b.suitable) return a.suitable;
        return rank_of(a.kind) < rank_of(b.kind);
    });
    for (std::size_t i = 0; i < infos.size() && infos[i].suitable; ++i) {
        infos[i].chosen = i == 0;
        infos[i].reasons.push_back(i == 0 ? fmt::format("the first suitable one, {}", infos[i].kind)
                                          : fmt::format("'{}' comes first", infos[0].name));
    }
    return infos;
}

}   // namespace gnomon::vk
