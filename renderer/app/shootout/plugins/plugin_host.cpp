// Opens a plugin and answers requests one by one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/plugin_host.h"

#include "accel/plugin/load_plugin.h"
#include "renderer/app/shootout/measure_build.h"
#include "renderer/app/shootout/plugins/plugin_messages.h"
#include "renderer/app/shootout/plugins/shared_race.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/base/standard_arithmetic.h"

#include <fmt/format.h>

#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <span>

namespace kindling::app {

namespace {

class PluginHost {
 public:
  PluginHost(const char* file, const char* options, SharedRace race, SharedMemory answers)
      : file_(file), options_(options), race_(std::move(race)), answers_(std::move(answers)) {}

  // Until the other end is closed.
  void serve() {
    PluginRequest request;
    while (recv(kMessageDescriptor, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request)) {
      PluginReply reply;
      std::string error = answer(request, reply);
      if (error.empty() && accelerator_) error = accelerator_->failure();
      reply.failed = error.empty() ? 0 : 1;
      if (!error.empty()) set_text(reply, error);
      if (send(kMessageDescriptor, &reply, sizeof reply, MSG_NOSIGNAL) < 0) return;
    }
  }

 private:
  static void set_text(PluginReply& reply, const std::string& text) {
    std::snprintf(reply.text, sizeof reply.text, "%s", text.c_str());
  }

  // Returns the reason of a failure.
  std::string answer(const PluginRequest& request, PluginReply& reply) {
    switch (request.step) {
    case PluginStep::open: {
      std::string error;
      plugin_ = accel::AcceleratorPlugin::open(file_, error);
      if (plugin_) set_text(reply, plugin_->description());
      return error;
    }
    case PluginStep::build: return build(request, reply);
    case PluginStep::trace: return trace_set(request, reply);
    case PluginStep::query: {
      const auto ray = answers_.array<accel::Ray>(0, 1);
      if (!ray || !accelerator_) return kOutOfOrder;
      const accel::Hit hit = accelerator_->intersect(accel::Ray(ray->front()));
      std::memcpy(answers_.data(), &hit, sizeof hit);
      return {};
    }
    case PluginStep::time_singles: {
      if (!accelerator_ || request.set >= race_.sets().size()) return kOutOfOrder;
      const std::vector<float> times = time_single_calls(*accelerator_, race_.sets()[request.set].rays);
      return answer(std::as_bytes(std::span(times))) ? "" : kOutOfOrder;
    }
    case PluginStep::release: accelerator_.reset(); return {};
    }
    return kOutOfOrder;
  }

  std::string build(const PluginRequest& request, PluginReply& reply) {
    accelerator_.reset();
    if (!plugin_) return kOutOfOrder;
    accel::PluginBuild built;
    const BuildMeasurement measured = measure_build(request.measures_memory != 0, [&] {
      const StandardArithmetic standard_arithmetic;
      built = plugin_->build(race_.geometry(), static_cast<int>(request.threads), options_);
    });
    if (!built.accelerator) return built.error;
    accelerator_ = std::move(built.accelerator);
    const accel::Statistics statistics = accelerator_->statistics();
    reply.wall_s = measured.work.wall_s;
    reply.cpu_s = measured.work.cpu_s;
    reply.peak_growth_bytes = measured.peak_growth_bytes.value_or(kUnknownBytes);
    reply.huge_page_bytes = measured.huge_page_bytes;
    reply.memory_bytes = statistics.memory_bytes;
    reply.node_count = statistics.node_count;
    reply.leaf_count = statistics.leaf_count;
    reply.reference_count = statistics.reference_count;
    reply.triangle_count = statistics.triangle_count;
    reply.instance_count = statistics.instance_count;
    return {};
  }

  std::string trace_set(const PluginRequest& request, PluginReply& reply) {
    if (!accelerator_ || request.set >= race_.sets().size()) return kOutOfOrder;
    const StandardArithmetic standard_arithmetic;
    const RaySet& set = race_.sets()[request.set];
    Answers answers(set);
    // No valid answers: those that a plugin leaves out are noticed.
    std::ranges::fill(answers.bytes(), std::byte{0xee});
    const double process_start = process_clock_s(ShootoutClock::cpu);
    const WorkTime work = measure(
        clock_s, [&] { trace(*accelerator_, set, static_cast<CallForm>(request.form), request.batch_size, answers); });
    reply.process_cpu_s = process_clock_s(ShootoutClock::cpu) - process_start;
    reply.wall_s = work.wall_s;
    reply.cpu_s = work.cpu_s;
    return answer(answers.bytes()) ? "" : kOutOfOrder;
  }

  // Puts bytes where the race reads answers. False if there is no room for them.
  [[nodiscard]] bool answer(std::span<const std::byte> bytes) {
    if (bytes.size() > answers_.size()) return false;
    std::ranges::copy(bytes, answers_.data());
    return true;
  }

  static constexpr const char* kOutOfOrder = "was asked out of order";

  std::string file_;
  std::string options_;
  SharedRace race_;
  SharedMemory answers_;
  std::unique_ptr<accel::AcceleratorPlugin> plugin_;
  std::unique_ptr<accel::PluginAccelerator> accelerator_;
};

// If memory runs out, the system ends this process before others.
void volunteer_for_the_end() {
  if (std::FILE* file = std::fopen("/proc/self/oom_score_adj", "w")) {
    std::fputs("1000", file);
    std::fclose(file);
  }
}

} // namespace

bool is_plugin_host(std::span<const char* const> arguments) {
  return !arguments.empty() && std::strcmp(arguments[0], kPluginHostCommand) == 0;
}

Result<int> run_plugin_host(std::span<const char* const> arguments) {
  prctl(PR_SET_PDEATHSIG, SIGKILL); // of the thread that races
  const Error alone{ErrorKind::usage,
                    fmt::format("{}: is started by 'kindling shootout --plugin FILE' alone", kPluginHostCommand)};
  if (arguments.size() != 3) return alone;
  Result<SharedMemory> race_memory = SharedMemory::open(kRaceDescriptor, false);
  Result<SharedMemory> answers = SharedMemory::open(kAnswerDescriptor, true);
  if (!race_memory.ok() || !answers.ok()) return alone;
  Result<SharedRace> race = SharedRace::read(race_memory.value());
  if (!race.ok()) return race.error();
  volunteer_for_the_end();
  PluginHost(arguments[1], arguments[2], std::move(race).value(), std::move(answers).value()).serve();
  return kExitOk;
}

} // namespace kindling::app
