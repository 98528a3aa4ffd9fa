// Options to a session and a server; the link; the end by a signal.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/view/command_view.h"

#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/text/text_format.h"
#include "renderer/view/view_server.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include <unistd.h>

namespace kindling::app {

namespace {

std::string join_words(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_quote(word);
  return line;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

ViewSession::Settings session_settings(const LiveOptions& options, Console& console) {
  const RenderOptions& image = options.image;
  ViewSession::Settings settings;
  settings.scene_file = image.scene_file;
  settings.options = {.world = image,
                      .image = image,
                      .display_view = image.view,
                      .exposure_stops = *image.exposure_stops,
                      .ocio_config = image.ocio_config,
                      .threads = image.threads};
  settings.passed_on = options.passed_on;
  settings.join = join_words;
  settings.on_warning = [&console](std::string_view message) { console.warning(message); };
  return settings;
}

// Without --port, another free port if the default one is taken.
Result<int> bind(HttpServer& server, const LiveOptions& options) {
  Result<int> bound = server.bind(options.listen, options.port.value_or(kDefaultViewPort));
  return bound.ok() || options.port ? std::move(bound) : server.bind(options.listen, 0);
}

std::string link_of(const std::string& listen, int port, const std::string& token) {
  const bool any = listen == "0.0.0.0" || listen == "::";
  const std::string host = any ? host_name() : listen.find(':') != std::string::npos ? "[" + listen + "]" : listen;
  return fmt::format("http://{}:{}/{}/", host, port, token);
}

// Serves on a thread of its own until the token is set.
void serve_until(const CancelToken& end, HttpServer& server, const Gate& gate, const ViewRequests& requests) {
  std::atomic<bool> ended{false};
  const std::jthread serving([&] {
    server.serve([&](const HttpRequest& request) { return gate.check(request); },
                 [&](const HttpRequest& request) { return requests.answer(request); });
    ended = true;
  });
  constexpr std::chrono::milliseconds kStep(50); // a signal handler cannot notify
  while (!end.cancelled() && !ended) std::this_thread::sleep_for(kStep);
  while (!ended) {
    server.stop();
    std::this_thread::sleep_for(kStep);
  }
}

} // namespace

Result<int> run_view(const LiveOptions& options, Console& console) {
  CancelToken end;
  const SignalGuard signals(
      end, {.deadlines = {}, .storing = {}, .end = [](int signal) { _exit(exit_code_of_signal(signal)); }});
  Result<std::unique_ptr<HttpServer>> server = make_http_server();
  if (!server.ok()) return server.error();
  const Result<int> port = bind(*server.value(), options);
  if (!port.ok()) return port.error();

  ProgressDisplay display(console, ProgressMode::automatic, {.spp_wanted = {}, .signals = &signals});
  display.start_phase(Phase::load);
  Result<std::unique_ptr<ViewSession>> session = ViewSession::open(session_settings(options, console), display);
  display.end_phase();
  if (!session.ok()) return session.error();

  const Gate gate(make_token(), options.listen, host_name());
  const ViewRequests requests(*session.value(), gate);
  session.value()->start();
  const Result<void> printed = print(link_of(options.listen, port.value(), gate.token()) + "\n");
  if (!printed.ok()) return printed.error();
  console.note("open the link in a browser; Ctrl-C ends");
  serve_until(end, *server.value(), gate, requests);
  session.value()->stop();
  return exit_code_of_signal(signals.received());
}

} // namespace kindling::app
