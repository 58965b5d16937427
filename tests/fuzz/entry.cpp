// SPDX-License-Identifier: Apache-2.0
// Entry points of libFuzzer. The environment names the target (GNOMON_FUZZ_TARGET) and, to write its seeds and exit,
// the folder for them (GNOMON_FUZZ_SEEDS).
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>

#include "fuzz/targets.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

const gnomon::fuzz::Target* g_target = nullptr;

// One change in eight is not repaired, so that wrong lengths and checksums are tested too.
constexpr unsigned k_unrepaired = 8;

void write_seeds(const std::string& folder)
{
    int number = 0;
    for (const gnomon::fuzz::Bytes& seed : g_target->seeds()) {
        std::ofstream out(folder + "/seed" + std::to_string(number++), std::ios::binary);
        out.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    }
}

}   // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    const char* name = std::getenv("GNOMON_FUZZ_TARGET");
    g_target = gnomon::fuzz::find_target(name ? name : "");
    if (!g_target) {
        std::fputs("GNOMON_FUZZ_TARGET must be one of:", stderr);
        for (const auto& target : gnomon::fuzz::targets())
            std::fprintf(stderr, " %.*s", static_cast<int>(target.name.size()), target.name.data());
        std::fputs("\n", stderr);
        std::exit(2);
    }
    if (const char* folder = std::getenv("GNOMON_FUZZ_SEEDS")) {
        write_seeds(folder);
        std::exit(0);
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    try {
        g_target->run({data, size});
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "fault: %s\n", fault.what());
        std::abort();
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed)
{
    size = LLVMFuzzerMutate(data, size, most);
    if (!g_target->repair || seed % k_unrepaired == 0) return size;
    gnomon::fuzz::Bytes bytes(data, data + size);
    g_target->repair(bytes);
    std::memcpy(data, bytes.data(), bytes.size());
    return bytes.size();
}
