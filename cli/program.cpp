// SPDX-License-Identifier: Apache-2.0
#include "cli/program.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>

#include "cli/command_line.h"
#include "cli/output.h"
#include "cli/signals.h"
#include "cli/subcommands.h"
#include "gnomon/error.h"
#include "gnomon/version.h"

namespace gnomon::cli {

namespace {
// Throws if an output file is one of the input files, so that a typing error does not overwrite a scene.
void refuse_to_replace_inputs(const CommandLine& line)
{
    const auto value = [&](const char* name) {
        return options::find_option(line.subcommand->subcommand, name) ? line.values.text(name) : std::string();
    };
    std::vector<std::string> inputs = line.positionals;
    for (const char* name : {"environment", "config"}) inputs.push_back(value(name));
    for (const char* name : {"json", "out", "contact-sheet", "heatmap"}) {
        const std::string output = value(name);
        std::error_code none;   // a missing file is no error here
        for (const std::string& input : inputs)
            if (!output.empty() && !input.empty() && std::filesystem::equivalent(output, input, none))
                throw UsageError(fmt::format("--{} {} would overwrite the input {}, which is read; choose another name",
                                             name, output, input));
    }
}

int run_subcommand(const CommandLine& line)
{
    refuse_to_replace_inputs(line);
    Output output(line.values);
    switch (line.subcommand->subcommand) {
        case options::Subcommand::render:
            return run_render(line, output);
        case options::Subcommand::join:
            return run_join(line, output);
        case options::Subcommand::view:
            return run_view(line, output);
        case options::Subcommand::info:
            return run_info(line, output);
        case options::Subcommand::compare:
            return run_compare(line, output);
        case options::Subcommand::devices:
            return run_devices(line, output);
        case options::Subcommand::serve:
            return run_serve(line, output);
        case options::Subcommand::bench_trace:
            return run_bench_trace(line, output);
        case options::Subcommand::bench_culling:
            return run_bench_culling(line, output);
        case options::Subcommand::bench_all:
            return run_bench_all(line, output);
        case options::Subcommand::bench_shadow_textures:
            return run_bench_shadow_textures(line, output);
        case options::Subcommand::bench_indirect:
            return run_bench_indirect(line, output);
        case options::Subcommand::bench_lights:
            return run_bench_lights(line, output);
        default:
            throw UsageError(fmt::format("{}: not built yet", line.subcommand->name));
    }
}

int fail(int code, std::string message)
{
    // Keep the message on one line even if a file name contains line breaks.
    for (char& c : message)
        if (c == '\n' || c == '\r') c = ' ';
    std::fprintf(stderr, "gnomon: %s\n", message.c_str());
    return code;
}
}   // namespace

int run_program(const std::vector<std::string>& arguments)
{
    fill_standard_descriptors();
    install_signal_handlers();
    install_terminate_handler();
    try {
        const CommandLine line = parse_command_line(arguments);
        if (line.help || line.version) {
            write_standard_output(line.version ? fmt::format("gnomon {}\n", version()) : help_text(line.subcommand));
            return k_exit_done;
        }
        if (options::find_option(line.subcommand->subcommand, "time-limit") && line.values.given("time-limit"))
            start_time_limit(line.values.number("time-limit"));
        return run_subcommand(line);
    } catch (const UsageError& error) {
        return fail(k_exit_usage, error.what());
    } catch (const InputError& error) {
        return fail(k_exit_input, error.what());
    } catch (const MissingError& error) {
        return fail(k_exit_missing, error.what());
    } catch (const InterruptedError& error) {
        return fail(k_exit_interrupted,
                    out_of_time() ? fmt::format("{}: the time limit has passed", error.what()) : error.what());
    } catch (const std::bad_alloc&) {
        return fail(k_exit_missing, "out of memory");
    } catch (const std::exception& error) {
        return fail(k_exit_internal, fmt::format("internal error: {}", error.what()));
    } catch (...) {
        return fail(k_exit_internal, "internal error");
    }
}

}   // namespace gnomon::cli
