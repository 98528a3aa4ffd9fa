// The kernels by name, with the type of their argument.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

struct FirstHitWave;
struct PathWave;
struct TreeWave;
struct RayBatch;

// KERNEL(name, argument): the function kernels::name(const argument&, uint32_t number).
#define KINDLING_KERNELS(KERNEL)                                                                                       \
  KERNEL(begin_path, PathWave)                                                                                         \
  KERNEL(intersect, PathWave)                                                                                          \
  KERNEL(intersect_opaque, PathWave)                                                                                   \
  KERNEL(shade, PathWave)                                                                                              \
  KERNEL(shade_beside_light_paths, PathWave)                                                                           \
  KERNEL(shade_beside_photons, PathWave)                                                                               \
  KERNEL(shade_reused, PathWave)                                                                                       \
  KERNEL(shade_with_manifolds, PathWave)                                                                               \
  KERNEL(trace_shadow, PathWave)                                                                                       \
  KERNEL(place_kinds, PathWave)                                                                                        \
  KERNEL(sort_paths, PathWave)                                                                                         \
  KERNEL(trace_shadow_opaque, PathWave)                                                                                \
  KERNEL(add_shadows, PathWave)                                                                                        \
  KERNEL(start_sharing, PathWave)                                                                                      \
  KERNEL(link_paths, PathWave)                                                                                         \
  KERNEL(trace_link, PathWave)                                                                                         \
  KERNEL(trace_link_opaque, PathWave)                                                                                  \
  KERNEL(share_light, PathWave)                                                                                        \
  KERNEL(receive_light, PathWave)                                                                                      \
  KERNEL(finish_pixel, PathWave)                                                                                       \
  KERNEL(begin_split, PathWave)                                                                                        \
  KERNEL(shade_split, PathWave)                                                                                        \
  KERNEL(split_shadow, PathWave)                                                                                       \
  KERNEL(split_tail, PathWave)                                                                                         \
  KERNEL(split_shared, PathWave)                                                                                       \
  KERNEL(finish_split_pixel, PathWave)                                                                                 \
  KERNEL(begin_light_path, PathWave)                                                                                   \
  KERNEL(scatter_light_path, PathWave)                                                                                 \
  KERNEL(scatter_split_light_path, PathWave)                                                                           \
  KERNEL(begin_photon_path, PathWave)                                                                                  \
  KERNEL(leave_photon, PathWave)                                                                                       \
  KERNEL(trace_sight, PathWave)                                                                                        \
  KERNEL(trace_sight_opaque, PathWave)                                                                                 \
  KERNEL(begin_tree, TreeWave)                                                                                         \
  KERNEL(take_node, TreeWave)                                                                                          \
  KERNEL(trace_node, TreeWave)                                                                                         \
  KERNEL(finish_tree_pixel, TreeWave)                                                                                  \
  KERNEL(show_first_hit, FirstHitWave)                                                                                 \
  KERNEL(finish_first_hit_pixel, FirstHitWave)                                                                         \
  KERNEL(nearest_hit, RayBatch)                                                                                        \
  KERNEL(any_hit, RayBatch)

enum class Kernel : uint8_t {
#define KINDLING_KERNEL_NAME(name, argument) name,
  KINDLING_KERNELS(KINDLING_KERNEL_NAME)
#undef KINDLING_KERNEL_NAME
};
// "shade"
[[nodiscard]] constexpr const char* kernel_name(Kernel kernel) {
  constexpr std::array kNames{
#define KINDLING_KERNEL_NAME(name, argument) #name,
      KINDLING_KERNELS(KINDLING_KERNEL_NAME)
#undef KINDLING_KERNEL_NAME
  };
  return kNames[static_cast<size_t>(kernel)];
}

#define KINDLING_KERNEL(name, argument) Kernel::name,
inline constexpr std::array kAllKernels{KINDLING_KERNELS(KINDLING_KERNEL)};
#undef KINDLING_KERNEL
inline constexpr size_t kKernelCount = kAllKernels.size();
// Room for the largest argument.
inline constexpr size_t kMaxArgumentBytes = 4096;

} // namespace kindling
