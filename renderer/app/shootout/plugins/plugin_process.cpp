// Spawns the host of a plugin and watches it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/plugin_process.h"

#include "renderer/base/text.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>

extern char** environ;

namespace kindling::app {

namespace {

using Clock = std::chrono::steady_clock;

Error cannot_start(const PluginSpec& plugin, int error) {
  return {ErrorKind::render_failed,
          fmt::format("{}: no process can be started for it: {}", plugin.name(), std::strerror(error))};
}

// The process has signals, group and standard input of its own; what it prints goes to standard
// error, because standard output has the tables.
int spawn_host(const PluginSpec& plugin, int messages, int race, int answers, pid_t& process) {
  const std::string file = std::filesystem::absolute(plugin.file).string();
  std::array<std::string, 4> words{"kindling", kPluginHostCommand, file, plugin.options};
  std::array<char*, 5> arguments{words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages, kMessageDescriptor);
  posix_spawn_file_actions_adddup2(&actions, race, kRaceDescriptor);
  posix_spawn_file_actions_adddup2(&actions, answers, kAnswerDescriptor);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, handled;
  sigemptyset(&none);
  sigemptyset(&handled);
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP}) sigaddset(&handled, signal);
  posix_spawnattr_setsigdefault(&attributes, &handled);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawn(&process, "/proc/self/exe", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

std::string describe_end(int status) {
  if (!WIFSIGNALED(status)) return fmt::format("ended its process with exit code {}", WEXITSTATUS(status));
  const char* name = sigabbrev_np(WTERMSIG(status));
  const std::string signal = name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", WTERMSIG(status));
  return fmt::format("crashed ({}{})", signal, WTERMSIG(status) == SIGKILL ? ", as when memory runs out" : "");
}

} // namespace

Result<std::unique_ptr<PluginProcess>> PluginProcess::start(const PluginSpec& plugin, const SharedMemory& race,
                                                            const SharedMemory& answers, const PluginLimits& limits) {
  std::array<int, 2> ends{-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return cannot_start(plugin, errno);
  const int theirs = fcntl(ends[1], F_DUPFD_CLOEXEC, kLowestDescriptor);
  close(ends[1]);
  pid_t process = -1;
  const int error = theirs < 0 ? errno : spawn_host(plugin, theirs, race.descriptor(), answers.descriptor(), process);
  if (theirs >= 0) close(theirs);
  if (error != 0) {
    close(ends[0]);
    return cannot_start(plugin, error);
  }
  return std::unique_ptr<PluginProcess>(new PluginProcess(process, ends[0], limits));
}

PluginProcess::~PluginProcess() {
  if (messages_ >= 0) close(messages_); // the process ends by itself, and what it printed is written
  messages_ = -1;
  for (int tries = 0; tries < 100 && process_ >= 0; ++tries) {
    siginfo_t ended{};
    if (waitid(P_PID, static_cast<id_t>(process_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0)
      break;
    usleep(10000);
  }
  end();
}

int PluginProcess::end() {
  if (messages_ >= 0) close(messages_);
  messages_ = -1;
  if (process_ < 0) return 0;
  kill(-process_, SIGKILL); // if it is dead already, its status remains what it was
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

std::optional<PluginReply> PluginProcess::ask(const PluginRequest& request, const std::string& step) {
  if (process_ < 0) return std::nullopt;
  const auto fail = [&](std::string fault) {
    fault_ = std::move(fault);
    end();
    return std::nullopt;
  };
  // The process ends by itself where the other end is closed, so its status is worth waiting for.
  const auto ended = [&] {
    int status = 0;
    for (int tries = 0; tries < 200; ++tries) {
      if (waitpid(process_, &status, WNOHANG) == process_) {
        const pid_t group = process_;
        process_ = -1;
        kill(-group, SIGKILL);
        return fail(fmt::format("{} {}", describe_end(status), step));
      }
      usleep(10000);
    }
    return fail(fmt::format("closed its connection {}", step));
  };
  if (send(messages_, &request, sizeof request, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof request)) return ended();
  const auto deadline = Clock::now() + std::chrono::duration<double>(limits_.step_s);
  for (;;) {
    if (limits_.cancel != nullptr && limits_.cancel->cancelled()) return fail("was interrupted");
    if (Clock::now() >= deadline) return fail(fmt::format("hangs: no answer within {:g} s {}", limits_.step_s, step));
    pollfd waiting{messages_, POLLIN, 0};
    if (poll(&waiting, 1, 100) <= 0) continue;
    PluginReply reply;
    const ssize_t size = recv(messages_, &reply, sizeof reply, 0);
    if (size < 0 && errno == EINTR) continue;
    if (size != static_cast<ssize_t>(sizeof reply)) return ended();
    reply.text[sizeof reply.text - 1] = '\0';
    if (reply.failed != 0) return fail(fmt::format("failed {}: {}", step, printable(reply.text)));
    return reply;
  }
}

} // namespace kindling::app
