// Examines the answers of contestants that are not to be trusted.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/trace_rays.h"

#include <map>
#include <string>
#include <utility>

namespace kindling::app {

// Answers must be possible when they are first given, and the same from then on.
class AnswerExaminer {
 public:
  // The geometry is borrowed.
  explicit AnswerExaminer(const accel::BuildInput& geometry) : geometry_(geometry) {}

  // Returns what is wrong with answers to a set, whose index is `number`, by a form of call, as
  // "ray 17 hits triangle 90 of mesh 2, which has 36"; empty if nothing is.
  [[nodiscard]] std::string examine(const RaySet& set, size_t number, CallForm form, const Answers& answers);
  // Forgets earlier answers: another build may break ties otherwise.
  void forget() { hashes_.clear(); }

 private:
  [[nodiscard]] std::string why_impossible(const RaySet& set, const Answers& answers) const;

  accel::BuildInput geometry_;
  std::map<std::pair<size_t, CallForm>, uint64_t> hashes_; // of the first answers to a set
};

} // namespace kindling::app
