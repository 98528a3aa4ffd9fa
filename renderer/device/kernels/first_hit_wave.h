// The memory of a wave of ambient occlusion or of a debug view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/wave.h"

namespace kindling {

struct SampleColor {
  Rgb rgb;
  float alpha = 0.0f;
};

// The argument of the kernels of first_hit_kernels.h.
struct FirstHitWave : Wave {
  SampleColor* colors = nullptr; // by sample
};

} // namespace kindling
