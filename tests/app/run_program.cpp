// Runs the kindling program and collects its output.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sstream>
#include <stdexcept>

extern char** environ;

namespace kindling::test {

namespace {

using Clock = std::chrono::steady_clock;

void require(bool done, const char* what) {
  if (!done) throw std::runtime_error(what);
}

} // namespace

std::vector<std::string> ProgramResult::err_lines() const {
  std::vector<std::string> lines;
  std::istringstream stream(err);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

Program::Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder, Output output,
                 const std::string& shell_prefix) {
  int out_pipe[2];
  int err_pipe[2];
  require(pipe2(out_pipe, O_CLOEXEC) == 0 && pipe2(err_pipe, O_CLOEXEC) == 0, "pipe2");

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (output == Output::full_device)
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/full", O_WRONLY, 0);
  else
    posix_spawn_file_actions_adddup2(&actions, out_pipe[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err_pipe[1], STDERR_FILENO);

  // Default signal handling, whatever the test runner has set.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t all;
  sigset_t none;
  sigfillset(&all);
  sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);

  std::vector<std::string> words{KINDLING_PROGRAM};
  if (!shell_prefix.empty()) words = {"/bin/sh", "-c", shell_prefix + R"(; exec "$0" "$@")", KINDLING_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int error = posix_spawn(&process_, words.front().c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  close(out_pipe[1]);
  close(err_pipe[1]);
  out_ = out_pipe[0];
  err_ = err_pipe[0];
  if (output == Output::closed_pipe) {
    close(out_);
    out_ = -1;
  }
  require(error == 0, "posix_spawn");
}

Program::~Program() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  if (out_ >= 0) close(out_);
  if (err_ >= 0) close(err_);
}

bool Program::read_some(int timeout_ms) {
  pollfd streams[2] = {{out_, POLLIN, 0}, {err_, POLLIN, 0}}; // poll() ignores negative descriptors
  if (out_ < 0 && err_ < 0) return false;
  if (poll(streams, 2, timeout_ms) <= 0) return true;
  const auto take = [](const pollfd& stream, int& descriptor, std::string& text) {
    if (descriptor < 0 || stream.revents == 0) return;
    char buffer[65536];
    const ssize_t count = read(descriptor, buffer, sizeof buffer);
    if (count > 0) {
      text.append(buffer, static_cast<size_t>(count));
    } else {
      close(descriptor);
      descriptor = -1;
    }
  };
  take(streams[0], out_, result_.out);
  take(streams[1], err_, result_.err);
  return true;
}

bool Program::wait_for_error_text(const std::string& text, std::chrono::seconds timeout) {
  const Clock::time_point end = Clock::now() + timeout;
  while (result_.err.find(text) == std::string::npos) {
    if (Clock::now() >= end || !read_some(50)) return false;
  }
  return true;
}

void Program::signal(int number) const { kill(process_, number); }

ProgramResult Program::finish(std::chrono::seconds timeout) {
  const Clock::time_point end = Clock::now() + timeout;
  while (Clock::now() < end && read_some(50)) {
  }
  int status = 0;
  while (waitpid(process_, &status, WNOHANG) == 0) {
    if (Clock::now() >= end) kill(process_, SIGKILL);
    usleep(2000);
  }
  process_ = -1;
  result_.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return result_;
}

ProgramResult run_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                          Output output) {
  return Program(arguments, folder, output).finish();
}

} // namespace kindling::test
