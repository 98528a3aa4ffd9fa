// Lists as JSON every setting that the pixels of a render depend on, and no others.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/scene/shutter.h"
#include "renderer/session/image_settings.h"

#include <cstdint>
#include <optional>
#include <string>

namespace kindling {

// Values that settings leave to the scene, once they are known.
struct ResolvedImage {
  V2i size_px{0, 0};
  std::optional<int> camera;      // index into PosedScene::cameras; unset: an orbit, an own camera, or a fitted one
  int scene = 0;                  // index into Scene::scenes
  int variant = -1;               // index into Scene::variants; kNone: the plain materials
  std::optional<Shutter> shutter; // in times of the animations
  std::optional<double> time_s;   // of everything that has one state for the whole image; unset: the rest pose
  uint64_t environment_hash = 0;  // LoadedEnvironment::content_hash; 0 without an image
};

// Returns a JSON object on one line, keys in order and defaults filled in, with one member for each
// flag of `kindling render` that pixels depend on. Two renders of one scene by one program with
// equal text make the same image to the bit, up to the number of samples. Left out because they
// change no pixel: the number of samples (the planned number counts), threads, tiles, schedule,
// batches, memory for textures, the forms of the Whitted tracer, and everything done with finished
// pixels (files, view, exposure, bits).
[[nodiscard]] std::string pixel_settings(const WorldSettings& world, const ImageSettings& image,
                                         const ResolvedImage& resolved);

} // namespace kindling
