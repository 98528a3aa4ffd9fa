// Runs the kindling program and returns its exit code and both output streams.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace kindling::test {

struct ProgramResult {
  int exit_code = -1; // negative: the number of the signal that killed the process
  std::string out;
  std::string err;

  [[nodiscard]] std::vector<std::string> err_lines() const;
};

// The target of standard output.
enum class Output { pipe, closed_pipe, full_device };

class Program {
 public:
  // Starts the program in `folder`, after the shell command `shell_prefix`, as "ulimit -v 100000".
  Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder, Output output = Output::pipe,
          const std::string& shell_prefix = {});
  ~Program(); // kills the process if it still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Waits for `text` on standard error; false if the process ends or the time is over before.
  [[nodiscard]] bool wait_for_error_text(const std::string& text, std::chrono::seconds timeout);
  void signal(int number) const;
  // Waits for the end of the process. After the timeout it is killed, and the exit code is -9.
  [[nodiscard]] ProgramResult finish(std::chrono::seconds timeout = std::chrono::seconds(120));

 private:
  // Reads the available output, waiting at most this long; false at the end of both streams.
  bool read_some(int timeout_ms);

  pid_t process_ = -1;
  int out_ = -1;
  int err_ = -1;
  ProgramResult result_;
};

[[nodiscard]] ProgramResult run_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                                        Output output = Output::pipe);

} // namespace kindling::test
