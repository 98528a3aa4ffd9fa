// Which image a render makes, as text: every setting that a pixel depends on, and none besides.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/scene/shutter.h"

#include <cstdint>
#include <optional>
#include <string>

namespace kindling::app {

// What the scene has decided where the options leave it to the scene.
struct ResolvedImage {
  V2i size_px{0, 0};
  std::optional<int> camera;      // index of --camera; unset: an orbit, or fitted to the scene
  int scene = 0;                  // index of --scene
  int variant = -1;               // index of --variant, kNone: the plain materials
  std::optional<Shutter> shutter; // in times of the animations
  std::optional<double> time_s;   // of what has one state for the whole image; unset: the rest pose
  uint64_t environment_hash = 0;  // of the pixels of --env; 0 without one
};

// A JSON object on one line with keys in order, one for each flag of `kindling render` that pixels depend on, with defaults filled in: two
// renders of one scene by one program with the same text make the same image to the bit, up to the number of samples. What does
// not belong to it: the number of samples (only what sampling is laid out for), threads, tiles, schedule, batches, memory for textures, the
// forms of the Whitted tracer, which all make the same pixels; and what is done with finished pixels: files, view, exposure, bits.
[[nodiscard]] std::string pixel_settings(const RenderOptions& options, const ResolvedImage& resolved);

} // namespace kindling::app
