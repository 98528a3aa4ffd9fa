// Everything that this program says on standard error, and its results on standard output. Nothing else prints.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace kindling::app {

struct ConsoleSettings {
  bool quiet = false;   // errors alone
  bool verbose = false; // details too
  bool json = false;    // warnings and notes as JSON lines; an error stays a line of text
};

// One line for each message, safe from any thread. Control characters of names in files are made harmless.
//   kindling: error: forest.gltf: ...
//   kindling: warning: forest.gltf: ...
//   kindling: no camera in the file: ...
class Console {
 public:
  explicit Console(const ConsoleSettings& settings = {});
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void error(std::string_view message);
  void warning(std::string_view message);
  void note(std::string_view message);
  void detail(std::string_view message); // with -v only

  // A line as it is, unless quiet: plain progress, JSON, the summary.
  void line(std::string_view text);
  // The line of a terminal that is rewritten in place; messages push it down. Empty: remove it.
  void status(std::string_view text);

  [[nodiscard]] uint64_t warning_count() const;
  [[nodiscard]] const ConsoleSettings& settings() const { return settings_; }

 private:
  struct Impl;
  ConsoleSettings settings_;
  std::unique_ptr<Impl> impl_;
};

// Results, at once. A reader that went away is no error (it has seen enough); anything else that keeps the text from
// arriving is: then false, with the system's reason in `reason`.
[[nodiscard]] bool write_standard_output(std::string_view text, std::string& reason);

} // namespace kindling::app
