// SPDX-License-Identifier: Apache-2.0
// Part of every program that is built with the sanitizer of addresses or of threads: no library is ever unloaded.
//
// Leaks are looked for at the very end. What a library keeps in its own variables would then count as lost, had it been
// unloaded, and without a name of the library that could be suppressed. Vulkan's loader unloads drivers and layers.
//
// ThreadSanitizer ends a program that unloads a library that its suppressions name.

extern "C" int dlclose(void* library);

int dlclose(void* library)
{
    return library == nullptr;
}
