// Runs the kindling program as a person's shell would: arguments in, exit code and both streams out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace kindling::test {

struct ProgramResult {
  int exit_code = -1; // minus the number of the signal that killed it
  std::string out;
  std::string err;

  [[nodiscard]] std::vector<std::string> err_lines() const;
};

// Where standard output goes.
enum class Output { pipe, closed_pipe, full_device };

class Program {
 public:
  // Starts it in `folder`. `shell_prefix`: a command that a shell runs before it, as in "ulimit -v 100000".
  Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder, Output output = Output::pipe,
          const std::string& shell_prefix = {});
  ~Program(); // kills what still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Until `text` is on standard error; false if it ends or the time passes before.
  [[nodiscard]] bool wait_for_error_text(const std::string& text, std::chrono::seconds timeout);
  void signal(int number) const;
  // Until it ends, which it must within the time: else it is killed and the exit code is -9.
  [[nodiscard]] ProgramResult finish(std::chrono::seconds timeout = std::chrono::seconds(120));

 private:
  // Reads what is there, waiting at most this long; false at the end of both streams.
  bool read_some(int timeout_ms);

  pid_t process_ = -1;
  int out_ = -1;
  int err_ = -1;
  ProgramResult result_;
};

[[nodiscard]] ProgramResult run_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                                        Output output = Output::pipe);

} // namespace kindling::test
