// SPDX-License-Identifier: Apache-2.0
// gnomon serve: answers rendering requests of simulators by HTTP, as Drake's glTF Render Client-Server API describes
// them.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/subcommands.h"
#include "gnomon/error.h"

#ifdef GNOMON_SERVE
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "base/one_line.h"
#include "cli/serve/service.h"
#include "cli/signals.h"
#include "gnomon/version.h"
#include "options/option_values.h"
#endif

namespace gnomon::cli {

#ifdef GNOMON_SERVE
namespace {

using Clock = std::chrono::steady_clock;

constexpr int k_threads = 4;         // connections that are read at once; frames are rendered one after the other
constexpr int k_read_seconds = 30;   // that a client may be silent while it sends

struct Address {
    std::string host;
    int port = 0;
};

Address parse_address(const std::string& text)
{
    const std::size_t colon = text.rfind(':');
    int port = 0;
    if (colon != std::string::npos && colon > 0 && colon + 1 < text.size() && text.size() - colon <= 6 &&
        text.find_first_not_of("0123456789", colon + 1) == std::string::npos)
        port = std::stoi(text.substr(colon + 1));
    else
        throw UsageError(fmt::format("--address {}: expected HOST:PORT, such as 127.0.0.1:8000", text));
    if (port > 65535) throw UsageError(fmt::format("--address {}: ports end at 65535", text));
    return {text.substr(0, colon), port};
}

// A port that was in use a moment ago may be used again, but not by two servers at once.
void exclusive(socket_t socket)
{
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

// One line of plain text, which clients show.
void fail(httplib::Response& response, int status, const std::string& message)
{
    response.status = status;
    response.set_content(one_line(message) + "\n", "text/plain");
}

// Bodies of unknown or unlimited size are refused before they are read.
httplib::Server::HandlerResponse check_header(const httplib::Request& request, httplib::Response& response)
{
    if (request.method != "POST") return httplib::Server::HandlerResponse::Unhandled;
    if (request.has_header("Content-Encoding"))
        fail(response, 415, "compressed requests are not supported");
    else if (!request.has_header("Content-Length") || request.has_header("Transfer-Encoding"))
        fail(response, 411, "a request needs a Content-Length");
    else
        return httplib::Server::HandlerResponse::Unhandled;
    response.set_header("Connection", "close");
    return httplib::Server::HandlerResponse::Handled;
}

RenderOptions color_options(const options::OptionValues& values)
{
    RenderOptions options;
    options.samples = values.text("samples") == "auto" ? k_adaptive_samples : values.integer("samples");
    if (values.text("exposure") != "auto") options.exposure = values.number("exposure");
    options.tonemap = values.choice<ToneMap>("tonemap");
    options.indirect = values.choice<Indirect>("indirect");
    options.memory = values.integer("memory");
    options.threads = values.integer("threads");
    return options;
}

// Answers requests, and says a line about each.
class Endpoint {
 public:
    Endpoint(const options::OptionValues& values, Output& output)
        : output_(output),
          largest_(*options::parse_size(values.text("max-size"))),
          longest_(values.number("request-time")),
          service_(color_options(values), values.text("environment"))
    {
    }

    void render(const httplib::Request& request, httplib::Response& response)
    {
        ++requests_;
        try {
            const RenderForm form = read_form(
                [&](const char* name) -> std::optional<std::string> {
                    if (!request.has_file(name)) return std::nullopt;
                    return request.get_file_value(name).content;
                },
                largest_);
            if (!request.has_file("scene")) throw UsageError("the field scene is missing");
            const auto begin = Clock::now();
            const auto end = begin + std::chrono::duration<double>(longest_);
            const Answer answer =
                service_.answer(form, request.get_file_value("scene").content,
                                [&](const ProgressStep&) { return !interrupted() && Clock::now() < end; });
            const std::chrono::duration<double, std::milli> took = Clock::now() - begin;
            say(fmt::format("{} x {}, {}: {:.0f} ms, of these {:.0f} for the frame{}", form.size.width,
                            form.size.height, request.get_file_value("image_type").content, took.count(),
                            answer.milliseconds, answer.reused ? ", of a known scene" : ""));
            response.set_content(answer.body, answer.type);
            return;
        } catch (const UsageError& error) {
            fail(response, 400, error.what());
        } catch (const InputError& error) {
            fail(response, 400,
                 fmt::format("{}{}{}", error.place(), error.place().empty() ? "" : ": ", error.problem()));
        } catch (const InterruptedError&) {
            fail(response, 503, interrupted() ? "the server stops" : "the request took longer than the server allows");
        } catch (const MissingError& error) {
            fail(response, 503, error.what());
        } catch (const std::bad_alloc&) {
            fail(response, 503, "out of memory");
        } catch (const std::exception& error) {
            fail(response, 500, fmt::format("internal error: {}", error.what()));
        }
        ++failures_;
        say("refused: " + response.body.substr(0, response.body.size() - 1));
    }

    int requests() const { return requests_; }
    int failures() const { return failures_; }

 private:
    void say(const std::string& line)
    {
        const std::lock_guard lock(mutex_);
        output_.say(line);
    }

    Output& output_;
    std::mutex mutex_;
    Size largest_;
    double longest_;   // seconds
    std::atomic<int> requests_{0}, failures_{0};
    RenderService service_;
};

}   // namespace

int run_serve(const CommandLine& line, Output& output)
{
    const Address address = parse_address(line.values.text("address"));
    Endpoint endpoint(line.values, output);
    httplib::Server server;
    server.new_task_queue = [] { return new httplib::ThreadPool(k_threads); };
    server.set_socket_options(exclusive);
    server.set_payload_max_length(static_cast<std::size_t>(line.values.integer("max-upload")) << 20);
    server.set_read_timeout(k_read_seconds, 0);
    server.set_write_timeout(k_read_seconds, 0);
    server.set_pre_routing_handler(check_header);
    server.set_error_handler([](const httplib::Request&, httplib::Response& response) {
        if (response.body.empty())
            fail(response, response.status,
                 response.status == 413   ? "the request is too large"
                 : response.status == 404 ? "there is POST /render alone"
                                          : "bad request");
    });
    server.Post("/render", [&](const httplib::Request& q, httplib::Response& a) { endpoint.render(q, a); });

    int port = address.port;
    const bool bound =
        port ? server.bind_to_port(address.host, port) : (port = server.bind_to_any_port(address.host)) > 0;
    if (!bound)
        throw MissingError(
            fmt::format("cannot listen at {}: it is in use, or not of this machine", line.values.text("address")));
    output.say(fmt::format("answering POST /render at http://{}:{}; Ctrl-C stops", address.host, port));
    std::atomic<bool> ended{false};
    std::thread watch([&] {
        while (!interrupted() && !ended) std::this_thread::sleep_for(std::chrono::milliseconds(50));
        server.stop();
    });
    server.listen_after_bind();
    ended = true;
    watch.join();
    output.finish({{"version", std::string(version())},
                   {"requests", endpoint.requests()},
                   {"failures", endpoint.failures()},
                   {"peak_memory_bytes", peak_memory_bytes()}});
    return 0;
}

#else

int run_serve(const CommandLine&, Output&)
{
    throw MissingError("this program was built without cpp-httplib; install libcpp-httplib-dev and build it again");
}

#endif

}   // namespace gnomon::cli
