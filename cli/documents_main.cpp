// SPDX-License-Identifier: Apache-2.0
// gnomon_documents FOLDER: writes the manual page and the shell completions that are installed with the program
// (gnomon.1, gnomon.bash, _gnomon, gnomon.fish); options.md, which is kept in docs/guide; and options.json, which is
// kept with the add-on for Blender.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "cli/manual.h"

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::fputs("usage: gnomon_documents FOLDER\n", stderr);
        return 2;
    }
    using namespace gnomon::cli;
    const std::filesystem::path folder = argv[1];
    const std::pair<const char*, std::string> files[] = {
        {"gnomon.1", manual_page()},        {"gnomon.bash", bash_completion()}, {"_gnomon", zsh_completion()},
        {"gnomon.fish", fish_completion()}, {"options.md", options_page()},     {"options.json", options_json()}};
    for (const auto& [name, text] : files) {
        std::ofstream out(folder / name, std::ios::binary);
        out << text;
        if (!out.flush()) {
            std::fprintf(stderr, "%s: cannot be written\n", (folder / name).c_str());
            return 4;
        }
    }
    return 0;
}
