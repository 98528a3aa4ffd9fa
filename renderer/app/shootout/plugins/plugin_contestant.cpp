// Asks the process of a plugin, and examines its answers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/plugin_contestant.h"

#include "renderer/app/shootout/plugins/examine_hits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

namespace kindling::app {

namespace {

std::string step_of(const RaySet& set, CallForm form) {
  return fmt::format("while tracing {} by {} calls", set.name, call_form_name(form));
}

} // namespace

// Asks for the nearest hit of single rays; everything follows from it.
class PluginContestant::Remote final : public accel::Accelerator {
 public:
  explicit Remote(PluginContestant& contestant) : contestant_(contestant) {}
  accel::Hit intersect(const accel::Ray& ray) const override { return contestant_.intersect(ray); }
  bool occluded(const accel::Ray& ray) const override { return contestant_.intersect(ray).is_hit(); }
  void intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override {
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = contestant_.intersect(rays[i]);
  }
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> blocked) const override {
    for (size_t i = 0; i < rays.size(); ++i) blocked[i] = contestant_.intersect(rays[i]).is_hit() ? 1 : 0;
  }
  Imath::Box3f bounds() const override { return {}; }
  accel::Statistics statistics() const override { return {}; }

 private:
  PluginContestant& contestant_;
};

PluginContestant::PluginContestant(PluginSpec plugin, const accel::BuildInput& geometry, std::span<const RaySet> sets,
                                   const SharedMemory& race, const PluginLimits& limits)
    : plugin_(std::move(plugin)), geometry_(geometry), sets_(sets), examiner_(geometry),
      remote_(std::make_unique<Remote>(*this)) {
  Result<SharedMemory> answers = SharedMemory::create(std::max(answer_bytes(sets), sizeof(accel::Ray)));
  if (!answers.ok()) {
    fault_ = answers.error().message;
    return;
  }
  answers_ = std::move(answers).value();
  Result<std::unique_ptr<PluginProcess>> process = PluginProcess::start(plugin_, race, *answers_, limits);
  if (!process.ok())
    fault_ = process.error().message;
  else
    process_ = std::move(process).value();
}

PluginContestant::~PluginContestant() = default;

const accel::Accelerator& PluginContestant::queries() const { return *remote_; }

std::string PluginContestant::fault() const { return !fault_.empty() || !process_ ? fault_ : process_->fault(); }

std::optional<PluginReply> PluginContestant::ask(const PluginRequest& request, const std::string& step) {
  if (!fault().empty()) return std::nullopt;
  return process_->ask(request, step);
}

void PluginContestant::open() {
  PluginRequest request;
  request.step = PluginStep::open;
  if (const auto reply = ask(request, "while being opened")) description_ = reply->text;
}

void PluginContestant::release() {
  PluginRequest request;
  request.step = PluginStep::release;
  (void)ask(request, "while destroying its accelerator");
}

std::optional<BuildMeasurement> PluginContestant::build(int threads, bool measures_memory) {
  PluginRequest request;
  request.step = PluginStep::build;
  request.threads = static_cast<uint32_t>(threads);
  request.measures_memory = measures_memory ? 1 : 0;
  const auto reply = ask(request, fmt::format("in a build on {} thread{}", threads, threads == 1 ? "" : "s"));
  if (!reply) return std::nullopt;
  BuildMeasurement result;
  result.work = {reply->wall_s, reply->cpu_s};
  if (reply->peak_growth_bytes != kUnknownBytes) result.peak_growth_bytes = reply->peak_growth_bytes;
  result.huge_page_bytes = reply->huge_page_bytes;
  result.statistics.memory_bytes = reply->memory_bytes;
  result.statistics.node_count = reply->node_count;
  result.statistics.leaf_count = reply->leaf_count;
  result.statistics.reference_count = reply->reference_count;
  result.statistics.triangle_count = reply->triangle_count;
  result.statistics.instance_count = reply->instance_count;
  examiner_.forget();
  return result;
}

std::optional<WorkTime> PluginContestant::trace(size_t set, CallForm form, uint32_t batch_size, Answers& answers) {
  PluginRequest request;
  request.step = PluginStep::trace;
  request.set = static_cast<uint32_t>(set);
  request.form = static_cast<uint32_t>(form);
  request.batch_size = batch_size;
  const std::string step = step_of(sets_[set], form);
  const auto reply = ask(request, step);
  if (!reply) return std::nullopt;
  const std::span<std::byte> bytes = answers.bytes();
  std::copy_n(answers_->data(), bytes.size(), bytes.begin());

  if (const std::string wrong = examiner_.examine(sets_[set], set, form, answers); !wrong.empty())
    fault_ = fmt::format("lies {}: {}", step, wrong);
  const double elsewhere_s = reply->process_cpu_s - reply->cpu_s;
  if (elsewhere_s > 0.005 + 0.2 * reply->cpu_s)
    fault_ = fmt::format("cheats {}: other threads worked for {:.3g} s", step, elsewhere_s);
  if (!fault_.empty()) return std::nullopt;
  return WorkTime{reply->wall_s, reply->cpu_s};
}

std::vector<float> PluginContestant::time_singles(size_t set) {
  PluginRequest request;
  request.step = PluginStep::time_singles;
  request.set = static_cast<uint32_t>(set);
  if (!ask(request, "while tracing a heat map")) return {};
  std::vector<float> times(sets_[set].rays.size());
  std::memcpy(times.data(), answers_->data(), times.size() * sizeof(float));
  return times;
}

accel::Hit PluginContestant::intersect(const accel::Ray& ray) {
  if (!fault().empty()) return {};
  std::memcpy(answers_->data(), &ray, sizeof ray);
  PluginRequest request;
  request.step = PluginStep::query;
  if (!ask(request, "in a query of a single ray")) return {};
  accel::Hit hit;
  std::memcpy(&hit, answers_->data(), sizeof hit);
  if (const std::string why = why_no_hit(geometry_, ray, hit); !why.empty()) {
    fault_ = "lies in a query of a single ray: it hits " + why;
    return {};
  }
  return hit;
}

} // namespace kindling::app
