// Recording of a finished path: the light that each of its reflections brought.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_recorder.h"

namespace kindling {

void PathRecorder::finish_path(size_t slot, const Rgb& found) {
  const float total = luminance(found);
  if (!std::isfinite(total)) return;
  luminance_sum += static_cast<double>(total);
  const Path& path = paths_[slot];
  const size_t arrived = path.count - (path.in_flight ? 1 : 0);
  for (size_t i = 0; i < arrived; ++i) {
    const Reflection& reflection = reflections_[slot * kMaxReflections + i];
    const float brought = total - reflection.found_before;
    if (!(brought > 0.0f)) continue;
    GuideRecord& record = records.emplace_back(reflection.record);
    record.contribution2 = square(brought);
  }
}

} // namespace kindling
