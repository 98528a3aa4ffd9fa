// Detects the instruction sets of this processor, and maps them to names.
// SPDX-License-Identifier: Apache-2.0
#include "accel/simd_target.h"

#include <array>
#include <utility>

namespace kindling::accel {
namespace {

constexpr std::array kNames = {std::pair{SimdTarget::portable, std::string_view("portable")},
                               std::pair{SimdTarget::sse2, std::string_view("sse2")},
                               std::pair{SimdTarget::sse42, std::string_view("sse4.2")},
                               std::pair{SimdTarget::avx, std::string_view("avx")},
                               std::pair{SimdTarget::avx2, std::string_view("avx2")},
                               std::pair{SimdTarget::avx512, std::string_view("avx512")}};

// The names avx2 and avx512 include all that the kd-tree's and Embree's kernels of that name need.
SimdTarget best_of_processor() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("sse4.2") || !__builtin_cpu_supports("popcnt")) return SimdTarget::sse2;
  if (!__builtin_cpu_supports("avx")) return SimdTarget::sse42;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi") ||
      !__builtin_cpu_supports("bmi2"))
    return SimdTarget::avx;
  if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512cd") ||
      !__builtin_cpu_supports("avx512vl") || !__builtin_cpu_supports("avx512bw") || !__builtin_cpu_supports("avx512dq"))
    return SimdTarget::avx2;
  return SimdTarget::avx512;
#else
  return SimdTarget::portable;
#endif
}

template <size_t n>
std::vector<SimdTarget> up_to_best(const std::array<SimdTarget, n>& targets) {
  std::vector<SimdTarget> out(targets.begin(), targets.end());
  std::erase_if(out, [best = best_of_processor()](SimdTarget target) { return target > best; });
  return out;
}

} // namespace

std::vector<SimdTarget> simd_targets() {
  return up_to_best(std::array{SimdTarget::portable, SimdTarget::avx2, SimdTarget::avx512});
}

SimdTarget best_simd_target() { return simd_targets().back(); }

std::vector<SimdTarget> embree_simd_targets() {
  return up_to_best(
      std::array{SimdTarget::sse2, SimdTarget::sse42, SimdTarget::avx, SimdTarget::avx2, SimdTarget::avx512});
}

std::string_view simd_target_name(SimdTarget target) {
  for (const auto& [value, name] : kNames)
    if (value == target) return name;
  return {};
}

std::optional<SimdTarget> simd_target_from_name(std::string_view text) {
  for (const auto& [value, name] : kNames)
    if (name == text) return value;
  return std::nullopt;
}

} // namespace kindling::accel
