// SPDX-License-Identifier: Apache-2.0
#include "accel/simd_target.h"

#include <array>
#include <utility>

namespace kindling::accel {
namespace {

constexpr std::array kNames = {std::pair{SimdTarget::portable, std::string_view("portable")},
                               std::pair{SimdTarget::avx2, std::string_view("avx2")},
                               std::pair{SimdTarget::avx512, std::string_view("avx512")}};

} // namespace

std::vector<SimdTarget> simd_targets() {
  std::vector<SimdTarget> targets = {SimdTarget::portable};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2"))
    targets.push_back(SimdTarget::avx2);
  if (targets.back() == SimdTarget::avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
    targets.push_back(SimdTarget::avx512);
#endif
  return targets;
}

SimdTarget best_simd_target() { return simd_targets().back(); }

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
