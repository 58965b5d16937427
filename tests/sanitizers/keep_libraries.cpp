// SPDX-License-Identifier: Apache-2.0
// Linked into every program built with AddressSanitizer or ThreadSanitizer: libraries are never unloaded.
//
// Leaks are searched at the very end. Memory that an unloaded library keeps in its own variables would count as lost,
// and could not be suppressed by the library's name. Vulkan's loader unloads drivers and layers.
//
// ThreadSanitizer ends a program that unloads a library named in its suppressions.

extern "C" int dlclose(void* library);

int dlclose(void* library)
{
    return library == nullptr;
}
