// Queries for scenes split into a persistent and a transient tree.
// Persistent meshes have a tree of their own, whose queries run first; the rest of each ray then
// goes through the tree of the transient meshes. Other scenes never use this code. It is compiled
// separately, so that their queries stay unchanged. The choice of tree for a triangle affects only
// time: of hits at equal distance the smallest ids count, as within one tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/packet.h"
#include "accel/kdtree/kernels/stream.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

inline float end_of(const Ray& ray, const Hit& hit) { return hit.is_hit() ? hit.t : ray.t_max; }

inline void take_if_nearer(const Structure& s, const Ray& ray, const TreeHit& found, Hit& hit) {
  if (hit.is_hit() && found.t > hit.t) return;
  const Hit other = CandidateFilter{s.filter, ray, s.transient_tree, kNoId}.resolve(found);
  if (!hit.is_hit() || other.t < hit.t || comes_before(other, hit)) hit = other;
}
inline void take_if_nearer(const Structure&, const Ray&, const TreeHit&, uint8_t& blocked) { blocked = 1; }

// The remaining rays of a batch: those that may meet something in the other tree, cut at their
// hits.
class RemainingRays {
 public:
  static constexpr size_t kMax = 256; // size of the batch

  RemainingRays(const Tree& tree, std::span<const Ray> rays, std::span<const Hit> hits) {
    for (size_t i = 0; i < rays.size(); ++i) add(tree, rays, i, end_of(rays[i], hits[i]));
  }
  RemainingRays(const Tree& tree, std::span<const Ray> rays, std::span<const uint8_t> blocked) {
    for (size_t i = 0; i < rays.size(); ++i)
      if (blocked[i] == 0) add(tree, rays, i, rays[i].t_max);
  }

  [[nodiscard]] std::span<const Ray> rays() const { return std::span<const Ray>(rays_.data(), count_); }
  [[nodiscard]] size_t number(size_t i) const { return numbers_[i]; } // index in the batch of ray i

 private:
  void add(const Tree& tree, std::span<const Ray> rays, size_t i, float t_far) {
    const Ray& ray = rays[i];
    float enter = std::max(ray.t_min, 0.0f), leave = t_far;
    if (!can_hit(ray) || !clip_to_box(tree.clip_bounds, load_origin(ray),
                                      Float4{1.0f, 1.0f, 1.0f, 1.0f} / load_direction(ray), enter, leave))
      return;
    assert(count_ < kMax);
    rays_[count_] = ray;
    rays_[count_].t_max = t_far;
    numbers_[count_++] = static_cast<uint16_t>(i);
  }

  std::array<Ray, kMax> rays_;
  std::array<uint16_t, kMax> numbers_;
  size_t count_ = 0;
};

// Traces rays in any order and direction.
template <bool kAny, class Finish>
[[gnu::noinline]] void trace_mixed(const Structure& s, std::span<const Ray> rays, const Finish& finish) {
  if (rays.size() < kMinStreamRays) {
    for (size_t i = 0; i < rays.size(); ++i) trace_indexed<kAny>(s.transient_tree, s.filter, rays, i, finish);
    return;
  }
  Stream<kAny> stream(s.transient_tree, s.filter);
  stream.trace(rays, finish);
}

template <bool kAny, class Finish>
[[gnu::noinline]] void trace_coherent(const Structure& s, std::span<const Ray> rays, const Finish& finish) {
  trace_packets<kAny>(s.transient_tree, s.filter, rays, finish, [&](std::span<const uint32_t> numbers) {
    std::array<Ray, RemainingRays::kMax> apart;
    for (size_t k = 0; k < numbers.size(); ++k) apart[k] = rays[numbers[k]];
    trace_mixed<kAny>(s, std::span<const Ray>(apart).first(numbers.size()),
                      [&](size_t k, const TreeHit& hit) { finish(numbers[k], hit); });
  });
}

template <bool kAny, bool kCoherent, class Answer>
inline void add_transient(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  for (size_t first = 0; first < rays.size(); first += RemainingRays::kMax) {
    const size_t count = std::min(RemainingRays::kMax, rays.size() - first);
    const auto part = rays.subspan(first, count);
    const RemainingRays rest(s.transient_tree, part, std::span<const Answer>(answers.subspan(first, count)));
    if (rest.rays().empty()) continue;
    const auto finish = [&](size_t i, const TreeHit& hit) {
      const size_t number = first + rest.number(i);
      take_if_nearer(s, rays[number], hit, answers[number]);
    };
    if constexpr (kCoherent)
      trace_coherent<kAny>(s, rest.rays(), finish);
    else
      trace_mixed<kAny>(s, rest.rays(), finish);
  }
}

template <const Queries& kWorld>
inline Hit intersect(const Structure& s, const Ray& ray) {
  Hit hit = kWorld.intersect(s, ray);
  if (!can_hit(ray)) return hit;
  float t_far = end_of(ray, hit);
  TreeHit found;
  const CandidateFilter filter{s.filter, ray, s.transient_tree, kNoId};
  if (trace_tree<false>(s.transient_tree, ray, std::max(ray.t_min, 0.0f), filter, t_far, found))
    take_if_nearer(s, ray, found, hit);
  return hit;
}
template <const Queries& kWorld>
inline bool occluded(const Structure& s, const Ray& ray) {
  if (kWorld.occluded(s, ray)) return true;
  if (!can_hit(ray)) return false;
  float t_far = ray.t_max;
  TreeHit found;
  const CandidateFilter filter{s.filter, ray, s.transient_tree, kNoId};
  return trace_tree<true>(s.transient_tree, ray, std::max(ray.t_min, 0.0f), filter, t_far, found);
}

// Answers a batch query: the persistent tree first, then the transient one.
template <const Queries& kWorld, bool kAny, bool kCoherent, class Answer,
          void (*Queries::*query)(const Structure&, std::span<const Ray>, std::span<Answer>)>
inline void batch_split(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  (kWorld.*query)(s, rays, answers);
  add_transient<kAny, kCoherent>(s, rays, answers);
}

template <const Queries& kWorld>
constexpr Queries make_split_queries() {
  return {intersect<kWorld>,
          occluded<kWorld>,
          batch_split<kWorld, false, false, Hit, &Queries::intersect_stream>,
          batch_split<kWorld, true, false, uint8_t, &Queries::occluded_stream>,
          batch_split<kWorld, false, true, Hit, &Queries::intersect_coherent>,
          batch_split<kWorld, true, true, uint8_t, &Queries::occluded_coherent>};
}

} // namespace kindling::accel::kd::KINDLING_SIMD
