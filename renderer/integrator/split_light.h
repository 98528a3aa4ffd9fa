// The arrays of a batch of paths whose light is split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/split_view.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// One thread's. Sized once.
struct SplitLight {
  // `groups` must outlive this. `reuses`: paths are shared between pixels.
  SplitLight(size_t batch_size, size_t shadow_rays, const LightGroupsView& groups, bool reuses)
      : by_group(batch_size * groups.count), by_pass(batch_size), firsts(batch_size), colors(batch_size),
        shadows(shadow_rays), tails(reuses ? batch_size * std::max(groups.count, 1U) : 0),
        second_groups(reuses ? batch_size : 0), view{&groups,        groups.count,  by_group.data(),
                                                     by_pass.data(), firsts.data(), colors.data(),
                                                     shadows.data(), tails.data(),  second_groups.data()} {}
  SplitLight(const SplitLight&) = delete;
  SplitLight& operator=(const SplitLight&) = delete;

  std::vector<SplitView::Classes> by_group;
  std::vector<SplitView::Passes> by_pass;
  std::vector<FirstEvent> firsts;
  std::vector<LobeColors> colors;
  std::vector<SplitShadow> shadows; // parallel to PathContext::shadow_records
  std::vector<Rgb> tails;
  std::vector<uint8_t> second_groups;
  SplitView view;
};

} // namespace kindling
