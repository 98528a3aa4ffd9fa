// Standard error through spdlog, with one sink that keeps the status line below the messages.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/console.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>

namespace kindling::app {

namespace {

// Writes all of `text` to a file descriptor; returns false and sets errno on failure.
bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    text.remove_prefix(static_cast<size_t>(count));
  }
  return true;
}

constexpr std::string_view kEraseLine = "\r\x1b[K";

class StandardErrorSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit StandardErrorSink(bool json) : json_(json) {}

  void set_status(std::string_view text) {
    const std::lock_guard lock(mutex_);
    if (text.empty() && status_.empty()) return;
    status_ = printable(text);
    write_all(STDERR_FILENO, std::string(kEraseLine) + status_);
  }

  // Writes a line without a label.
  void write_line(std::string_view text) {
    const std::lock_guard lock(mutex_);
    write_above_status(printable_lines(text));
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    const std::string_view label = message.level == spdlog::level::err    ? "error"
                                   : message.level == spdlog::level::warn ? "warning"
                                                                          : "";
    if (json_ && message.level != spdlog::level::err) {
      const nlohmann::ordered_json object = {{"event", label.empty() ? "note" : label}, {"message", text}};
      write_above_status(object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
      write_above_status(label.empty() ? fmt::format("kindling: {}", text)
                                       : fmt::format("kindling: {}: {}", label, text));
    }
  }
  void flush_() override {}

 private:
  void write_above_status(std::string_view text) {
    std::string bytes;
    if (!status_.empty()) bytes += kEraseLine;
    bytes += text;
    bytes += '\n';
    bytes += status_;
    write_all(STDERR_FILENO, bytes); // a failure here cannot be reported anywhere
  }

  bool json_;
  std::string status_;
};

} // namespace

struct Console::Impl {
  std::shared_ptr<StandardErrorSink> sink;
  spdlog::logger logger;
  std::atomic<uint64_t> warnings{0};

  explicit Impl(const ConsoleSettings& settings)
      : sink(std::make_shared<StandardErrorSink>(settings.json)), logger("kindling", sink) {
    logger.set_level(settings.quiet     ? spdlog::level::err
                     : settings.verbose ? spdlog::level::debug
                                        : spdlog::level::info);
  }
};

Console::Console(const ConsoleSettings& settings) : settings_(settings), impl_(std::make_unique<Impl>(settings)) {}
Console::~Console() { impl_->sink->set_status({}); }

void Console::error(std::string_view message) {
  impl_->sink->set_status({});
  impl_->logger.error("{}", message);
}
void Console::warning(std::string_view message) {
  ++impl_->warnings;
  impl_->logger.warn("{}", message);
}
void Console::note(std::string_view message) { impl_->logger.info("{}", message); }
void Console::detail(std::string_view message) { impl_->logger.debug("{}", message); }

void Console::line(std::string_view text) {
  if (!settings_.quiet) impl_->sink->write_line(text);
}

void Console::status(std::string_view text) {
  if (!settings_.quiet) impl_->sink->set_status(text);
}

uint64_t Console::warning_count() const { return impl_->warnings; }

Result<void> print(std::string_view text) {
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  const std::string shown = terminal ? printable_lines(text) : std::string();
  if (write_all(STDOUT_FILENO, terminal ? std::string_view(shown) : text) || errno == EPIPE) return {};
  return Error{ErrorKind::input_output, fmt::format("standard output: {}", std::strerror(errno))};
}

} // namespace kindling::app
