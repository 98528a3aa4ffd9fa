// Judges answers by the geometry, and later ones by a hash of the first.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/answer_examiner.h"

#include "renderer/app/shootout/plugins/examine_hits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace kindling::app {

namespace {

// FNV-1a by words of 64 bits.
uint64_t hash_bytes(const void* data, size_t size) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (size_t at = 0; at < size; at += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + at, std::min(sizeof word, size - at));
    hash = (hash ^ word) * 0x100000001b3ULL;
    hash ^= hash >> 29;
  }
  return hash;
}

// What the contract fixes: a miss has no other numbers.
uint64_t hash_answers(Answers answers) {
  for (accel::Hit& hit : answers.hits)
    if (!hit.is_hit()) hit = accel::Hit();
  return answers.hits.empty() ? hash_bytes(answers.occluded.data(), answers.occluded.size())
                              : hash_bytes(answers.hits.data(), answers.hits.size() * sizeof(accel::Hit));
}

} // namespace

std::string AnswerExaminer::examine(const RaySet& set, size_t number, CallForm form, const Answers& answers) {
  const uint64_t hash = hash_answers(answers);
  const auto [known, is_first] = hashes_.try_emplace({number, form}, hash);
  if (is_first) return why_impossible(set, answers);
  return known->second == hash ? std::string() : "other answers to the same rays than before";
}

std::string AnswerExaminer::why_impossible(const RaySet& set, const Answers& answers) const {
  for (size_t i = 0; i < answers.occluded.size(); ++i)
    if (answers.occluded[i] > 1)
      return fmt::format("ray {} has the answer {}; 0 and 1 are allowed", i, answers.occluded[i]);
  size_t hits = 0, elsewhere = 0, first = 0;
  for (size_t i = 0; i < answers.hits.size(); ++i) {
    const accel::Hit& hit = answers.hits[i];
    if (const std::string why = why_no_hit(geometry_, set.rays[i], hit); !why.empty())
      return fmt::format("ray {} hits {}", i, why);
    if (!hit.is_hit()) continue;
    ++hits;
    if (lies_on_its_triangle(geometry_, set.rays[i], hit)) continue;
    if (elsewhere++ == 0) first = i;
  }
  // Few of them may be slivers, seen along their plane.
  if (elsewhere * 100 <= hits) return {};
  return fmt::format("{} of {} hits are not where their triangle is, ray {} first", elsewhere, hits, first);
}

} // namespace kindling::app
