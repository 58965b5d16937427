// SPDX-License-Identifier: Apache-2.0
// The test files of the Khronos glTF validator, each with the validator's report: invalid files must be refused with a
// place, valid files must load.

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "gltf_child.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Outcome;

// Families of codes for which at least 95 % of the files must be refused.
bool counts(const std::string& code)
{
    for (const char* family : {"ACCESSOR_", "BUFFER_", "GLB_", "MESH_PRIMITIVE_", "NODE_"})
        if (code.rfind(family, 0) == 0) return true;
    return code == "INVALID_JSON" || code == "UNRESOLVED_REFERENCE";
}

// A JSON pointer, or, where there is none, the line and column of broken JSON, or a byte of a GLB.
bool is_place(const std::string& place)
{
    static const std::regex form("/.*|\\d+:\\d+|byte \\d+");
    return std::regex_match(place, form);
}

struct Row {
    int files = 0, refused = 0;
};

TEST(GltfValidatorFiles, InvalidAreRefusedAndValidLoad)
{
    GNOMON_NEED_SCENE(folder, "hostile/gltf-validator");
    std::map<std::string, Row> table;
    Row counted;
    int clean = 0, total = 0, spotless = 0, warned = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".gltf" && extension != ".glb") continue;
        ++total;
        std::ifstream stream(entry.path().string() + ".report.json");
        const auto report = nlohmann::json::parse(stream);
        std::set<std::string> codes;
        std::string expected;
        for (const auto& message : report["issues"]["messages"]) {
            if (message["severity"] != 0) continue;
            codes.insert(message["code"].get<std::string>());
            expected += message["code"].get<std::string>() + " " + message.value("pointer", "") + "; ";
        }

        const Outcome outcome = test::load_in_child(entry.path(), true);
        const std::string name = std::filesystem::relative(entry.path(), folder).string();
        EXPECT_NE(outcome.kind, Outcome::Kind::died) << name << " signal " << outcome.signal;
        EXPECT_NE(outcome.kind, Outcome::Kind::other_error) << name << ": " << outcome.what;
        const bool refused = outcome.kind == Outcome::Kind::refused;
        const Outcome tolerant = test::load_in_child(entry.path());
        EXPECT_NE(tolerant.kind, Outcome::Kind::died) << name << " signal " << tolerant.signal;
        EXPECT_NE(tolerant.kind, Outcome::Kind::other_error) << name << ": " << tolerant.what;
        if (codes.empty()) {
            ++clean;
            EXPECT_EQ(tolerant.kind, Outcome::Kind::loaded) << name << " is clean, but: " << tolerant.what;
            EXPECT_EQ(tolerant.warnings, outcome.warnings) << name << " is clean, but was repaired";
            EXPECT_EQ(outcome.kind, Outcome::Kind::loaded) << name << " is clean, but: " << outcome.what;
            if (report["issues"]["numWarnings"] == 0) {
                ++spotless;
                warned += tolerant.warnings > 0;
                if (tolerant.warnings > 0) std::printf("%s: %zu warnings\n", name.c_str(), tolerant.warnings);
            }
            continue;
        }
        if (refused) {
            EXPECT_EQ(outcome.file, entry.path().string());
            EXPECT_TRUE(is_place(outcome.place)) << name << ": " << outcome.what;
        } else {
            std::printf("accepted: %s (%s)\n", name.c_str(), expected.c_str());
        }
        const bool well = refused && is_place(outcome.place);
        bool in_family = false;
        for (const std::string& code : codes) {
            ++table[code].files;
            table[code].refused += well;
            in_family |= counts(code);
        }
        if (in_family) ++counted.files, counted.refused += well;
    }
    ASSERT_GT(total, 100);
    // Two have accessors without data, and one asks for an extension that nobody knows.
    EXPECT_GT(spotless, 20);
    EXPECT_LE(warned, 3);

    std::printf("%-64s %5s %7s\n", "code", "files", "refused");
    for (const auto& [code, row] : table)
        std::printf("%-64s %5d %7d%s\n", code.c_str(), row.files, row.refused, counts(code) ? "  *" : "");
    std::printf("%d files, %d of them clean; of %d with codes marked * %d refused\n", total, clean, counted.files,
                counted.refused);
    EXPECT_GE(counted.refused * 100, counted.files * 95);

    // The codes on which the importer relies are listed in a file with their meaning, so that none is skipped because
    // the name of a family changed.
    std::ifstream list(test::places::source_folder + "/tests/hostile/gltf_codes.txt");
    std::set<std::string> listed;
    for (std::string line; std::getline(list, line);)
        if (!line.empty() && line[0] != '#') listed.insert(line.substr(0, line.find(' ')));
    ASSERT_GT(listed.size(), 50u);
    for (const auto& [code, row] : table)
        if (!listed.contains(code)) std::printf("not in gltf_codes.txt: %s\n", code.c_str());
}

}   // namespace
}   // namespace gnomon
