// Messages on standard error and results on standard output; no other code prints.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace kindling::app {

struct ConsoleSettings {
  bool quiet = false;   // errors only
  bool verbose = false; // details too
  bool json = false;    // warnings and notes as JSON lines; errors stay plain text
};

// Prints one line for each message, safe from any thread. Control characters are replaced.
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
  void detail(std::string_view message); // printed with -v only

  // Prints a line without a label, unless quiet: plain progress, JSON, the summary.
  void line(std::string_view text);
  // Sets the status line of a terminal, which is rewritten in place below the messages. An empty
  // text removes it.
  void status(std::string_view text);

  [[nodiscard]] uint64_t warning_count() const;
  [[nodiscard]] const ConsoleSettings& settings() const { return settings_; }

 private:
  struct Impl;
  ConsoleSettings settings_;
  std::unique_ptr<Impl> impl_;
};

// Writes results to standard output, unbuffered: unchanged into files and pipes, which programs
// read; with control characters replaced on a terminal (names of files may have them). A reader
// that closed its end is no error; fails (input_output) with the system's reason if the text cannot
// be written otherwise.
[[nodiscard]] Result<void> print(std::string_view text);

} // namespace kindling::app
