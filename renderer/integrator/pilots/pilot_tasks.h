// Runs the tasks of a pilot on all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/path_integrator.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

namespace kindling {

// The work of a pilot's tasks.
struct PilotWork {
  bool complete = false; // else it was stopped, or the world abandoned
  RayCounters rays;
  double busy_s = 0.0; // summed over the threads
};

// Calls trace(task, context) for each task in [0, count), on the threads of the current TBB arena,
// with contexts of the integrator. `stopped` is polled before each task and may be empty.
template <typename Trace>
[[nodiscard]] PilotWork run_pilot_tasks(const PathIntegrator& integrator, const World& world,
                                        const std::function<bool()>& stopped, size_t count, const Trace& trace) {
  using Clock = std::chrono::steady_clock;
  tbb::enumerable_thread_specific<std::unique_ptr<PathContext>> contexts([&] {
    std::unique_ptr<PathContext> context = integrator.make_path_context();
    context->traces_parts = true;
    return context;
  });
  std::atomic<bool> complete{true};
  std::atomic<double> busy_s{0.0};
  tbb::parallel_for(size_t{0}, count, [&](size_t task) {
    if (!complete || world.abandoned() || (stopped && stopped())) complete = false;
    if (!complete) return;
    const StandardArithmetic standard_arithmetic;
    const Clock::time_point start = Clock::now();
    trace(task, *contexts.local());
    busy_s += std::chrono::duration<double>(Clock::now() - start).count();
  });
  PilotWork work{.complete = complete && !world.abandoned(), .rays = {}, .busy_s = busy_s};
  for (const std::unique_ptr<PathContext>& context : contexts) work.rays.add(context->counters);
  return work;
}

} // namespace kindling
