// A plugin in a race: in a process of its own, with every answer checked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/answer_examiner.h"
#include "renderer/app/shootout/contestant.h"
#include "renderer/app/shootout/plugins/plugin_process.h"
#include "renderer/app/shootout/plugins/shared_race.h"

#include <memory>
#include <span>
#include <string>

namespace kindling::app {

// Faults beside those of its process: answers that are none (ids out of range, numbers that are not
// finite, rays left out), hits that are not where they say, other answers to the same rays in
// another round, and work by other threads while it traces.
class PluginContestant final : public Contestant {
 public:
  // `race` holds geometry and sets, which are borrowed as well.
  PluginContestant(PluginSpec plugin, const accel::BuildInput& geometry, std::span<const RaySet> sets,
                   const SharedMemory& race, const PluginLimits& limits);
  ~PluginContestant() override;

  // Opens the library; a fault if that fails.
  void open();
  // One line by the plugin about itself; empty before open().
  [[nodiscard]] const std::string& description() const { return description_; }
  // Destroys the accelerator, which may fail too.
  void release();

  std::optional<BuildMeasurement> build(int threads, bool measures_memory) override;
  bool has(CallForm form) const override { return every_accelerator_has(form); }
  std::optional<WorkTime> trace(size_t set, CallForm form, uint32_t batch_size, Answers& answers) override;
  std::vector<float> time_singles(size_t set) override;
  const accel::Accelerator& queries() const override;
  std::string fault() const override;

 private:
  class Remote;

  [[nodiscard]] accel::Hit intersect(const accel::Ray& ray);
  std::optional<PluginReply> ask(const PluginRequest& request, const std::string& step);

  PluginSpec plugin_;
  accel::BuildInput geometry_;
  std::span<const RaySet> sets_;
  AnswerExaminer examiner_;
  std::optional<SharedMemory> answers_;
  std::unique_ptr<PluginProcess> process_;
  std::unique_ptr<Remote> remote_;
  std::string description_;
  std::string fault_;
};

} // namespace kindling::app
