// Spawns processes with posix_spawn, reads their output with poll, and waits for their end.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/run_process.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace kindling {

namespace {

struct Pipe {
  int read = -1;
  int write = -1;
  Pipe() {
    std::array<int, 2> ends{-1, -1};
    if (pipe2(ends.data(), O_CLOEXEC) == 0) {
      read = ends[0];
      write = ends[1];
    }
  }
  ~Pipe() {
    close_read();
    close_write();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read() {
    if (read >= 0) close(read);
    read = -1;
  }
  void close_write() {
    if (write >= 0) close(write);
    write = -1;
  }
};

// Starts a program with `blocked` as its signal mask.
Result<pid_t> spawn(const std::vector<std::string>& command, const std::filesystem::path& folder, int out, int err,
                    const sigset_t& blocked) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t pipes;
  sigemptyset(&pipes);
  sigaddset(&pipes, SIGPIPE); // ignored in this process, but not to be ignored in others
  posix_spawnattr_setsigdefault(&attributes, &pipes);
  posix_spawnattr_setsigmask(&attributes, &blocked);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  pid_t process = -1;
  const int error = posix_spawnp(&process, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    return Error{ErrorKind::input_output, fmt::format("{}: cannot be run: {}", command[0], std::strerror(error))};
  return process;
}

ProcessEnd wait_for(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {0, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

sigset_t inbox_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaddset(&signals, signal);
  struct sigaction action {};
  // A blocked signal would be collected even where nohup ignores it.
  if (sigaction(SIGHUP, nullptr, &action) == 0 && action.sa_handler != SIG_IGN) sigaddset(&signals, SIGHUP);
  return signals;
}

// Appends available bytes to `text`. False at the end of the stream.
bool read_some(int descriptor, std::string& text) {
  std::array<char, 4096> buffer;
  const ssize_t count = read(descriptor, buffer.data(), buffer.size());
  if (count < 0) return errno == EINTR || errno == EAGAIN;
  text.append(buffer.data(), static_cast<size_t>(count));
  return count > 0;
}

} // namespace

Result<ProcessOutput> capture_process(const std::vector<std::string>& command) {
  Pipe out;
  Pipe err;
  if (out.write < 0 || err.write < 0)
    return Error{ErrorKind::input_output, fmt::format("{}: no pipe: {}", command[0], std::strerror(errno))};
  sigset_t none;
  sigemptyset(&none);
  Result<pid_t> process = spawn(command, {}, out.write, err.write, none);
  if (!process.ok()) return process.error();
  out.close_write();
  err.close_write();
  ProcessOutput output;
  while (out.read >= 0 || err.read >= 0) {
    std::array<pollfd, 2> waiting{{{out.read, POLLIN, 0}, {err.read, POLLIN, 0}}};
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) break;
    if (waiting[0].revents != 0 && !read_some(out.read, output.out)) out.close_read();
    if (waiting[1].revents != 0 && !read_some(err.read, output.err)) err.close_read();
  }
  const ProcessEnd end = wait_for(process.value());
  output.exit_code = end.signal != 0 ? 128 + end.signal : end.exit_code;
  return output;
}

SignalInbox::SignalInbox() {
  const sigset_t wanted = inbox_signals();
  pthread_sigmask(SIG_BLOCK, &wanted, nullptr);
  descriptor_ = signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK);
}

SignalInbox::~SignalInbox() {
  received(); // takes pending signals, which would end the process once unblocked
  close(descriptor_);
  const sigset_t wanted = inbox_signals();
  pthread_sigmask(SIG_UNBLOCK, &wanted, nullptr);
}

int SignalInbox::received() {
  signalfd_siginfo info;
  while (read(descriptor_, &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
    if (first_ == 0) first_ = static_cast<int>(info.ssi_signo);
    came_ |= uint64_t{1} << info.ssi_signo;
  }
  return first_;
}

bool SignalInbox::came(int signal) {
  received();
  return (came_ >> signal & 1) != 0;
}

Result<ProcessEnd> run_watched(const std::vector<std::string>& command, const std::filesystem::path& folder,
                               SignalInbox& signals, const std::function<void(std::string_view)>& on_line) {
  Pipe output;
  if (output.write < 0)
    return Error{ErrorKind::input_output, fmt::format("{}: no pipe: {}", command[0], std::strerror(errno))};
  sigset_t blocked = inbox_signals();
  sigdelset(&blocked, SIGINT);
  Result<pid_t> process = spawn(command, folder, output.write, output.write, blocked);
  if (!process.ok()) return process.error();
  output.close_write();

  std::string text;
  bool asked = false; // the program was asked to end
  for (bool open = true; open;) {
    std::array<pollfd, 2> waiting{{{output.read, POLLIN, 0}, {signals.descriptor(), POLLIN, 0}}};
    if (poll(waiting.data(), asked ? 1 : 2, -1) < 0 && errno != EINTR) break;
    if (!asked && signals.received() != 0) {
      if (signals.received() != SIGINT) kill(process.value(), SIGINT);
      asked = true;
    }
    if (waiting[0].revents != 0) open = read_some(output.read, text);
    for (size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
      on_line(std::string_view(text).substr(0, end));
      text.erase(0, end + 1);
    }
  }
  if (!text.empty()) on_line(text);
  return wait_for(process.value());
}

} // namespace kindling
