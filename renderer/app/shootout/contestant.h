// The contestants of a race, and those that are accelerators in this process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/shootout/trace_rays.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kindling::app {

// One build.
struct BuildMeasurement {
  WorkTime work;                             // wall time, and CPU time of the process that builds
  std::optional<uint64_t> peak_growth_bytes; // unset if not asked for, or if the system does not report it
  uint64_t huge_page_bytes = 0;              // 0 also if not asked for
  accel::Statistics statistics;
};

// Builds and traces on request. Rays are named by their set's index in the list that the contestant
// was given. One that fails has a fault from then on, and leaves the race.
class Contestant {
 public:
  virtual ~Contestant() = default;

  // Builds once more; with `measures_memory` also the fields of memory are set.
  [[nodiscard]] virtual std::optional<BuildMeasurement> build(int threads, bool measures_memory) = 0;
  // False for the calls of others.
  [[nodiscard]] virtual bool has(CallForm form) const = 0;
  // Traces a set on one thread; CPU time is that of the thread.
  [[nodiscard]] virtual std::optional<WorkTime> trace(size_t set, CallForm form, uint32_t batch_size,
                                                      Answers& answers) = 0;
  // time_single_calls() for a set of nearest-hit rays; empty if it fails.
  [[nodiscard]] virtual std::vector<float> time_singles(size_t set) = 0;
  // For questions about single rays after the build; not to be timed.
  [[nodiscard]] virtual const accel::Accelerator& queries() const = 0;
  // Returns what went wrong, as "crashed (SIGSEGV) in a build on 1 thread"; empty if nothing did.
  [[nodiscard]] virtual std::string fault() const { return {}; }
};

// Builds once, with `threads` threads including the calling one.
[[nodiscard]] std::unique_ptr<accel::Accelerator> build_variant(const accel::BuildInput& input,
                                                                const AcceleratorVariant& variant, int threads);

// An accelerator of this library. For Embree also its packet and stream calls, if wanted.
class LocalContestant final : public Contestant {
 public:
  // Builds `variant` on request. Input and sets are borrowed.
  LocalContestant(const accel::BuildInput& input, const AcceleratorVariant& variant, std::span<const RaySet> sets,
                  bool embree_calls);
  // Has been built already; borrows the accelerator.
  LocalContestant(const accel::Accelerator& accelerator, std::span<const RaySet> sets, bool embree_calls);

  std::optional<BuildMeasurement> build(int threads, bool measures_memory) override;
  bool has(CallForm form) const override { return by(form) != nullptr; }
  std::optional<WorkTime> trace(size_t set, CallForm form, uint32_t batch_size, Answers& answers) override;
  std::vector<float> time_singles(size_t set) override;
  const accel::Accelerator& queries() const override { return *accelerator_; }

 private:
  // The accelerator for a form of call; null if it does not have it.
  [[nodiscard]] const accel::Accelerator* by(CallForm form) const;
  void adopt(const accel::Accelerator& accelerator);

  accel::BuildInput input_;
  AcceleratorVariant variant_;
  std::span<const RaySet> sets_;
  bool embree_calls_;
  std::unique_ptr<accel::Accelerator> owned_;
  const accel::Accelerator* accelerator_ = nullptr;
  std::vector<std::unique_ptr<accel::Accelerator>> own_calls_; // in the order of CallForm
};

} // namespace kindling::app
