// Layers of color, albedo and normal among the channels of an EXR file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/write_image.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

using ThreeChannels = std::array<size_t, 3>; // indices into ExrImage::layers, each of one channel

struct DenoisableLayers {
  ThreeChannels color;                 // what is shown: R, G, B, else the only layer "Combined"
  std::optional<ThreeChannels> noisy;  // the color before it was denoised: noisy.R, ...
  std::optional<size_t> alpha;         // of the color
  std::optional<ThreeChannels> albedo; // 0 to 1
  std::optional<ThreeChannels> normal; // -1 to 1
  // Vector.X to Vector.W, or of Nuke: forward.u, forward.v, backward.u, backward.v.
  std::optional<std::array<size_t, 4>> vector, forward_backward;
  std::optional<size_t> samples; // kindling.samples
};

// Finds layers by their last name, in any case, as Kindling, Blender, pbrt and Mitsuba write them:
// albedo, Denoising Albedo; normal, N, Ns, sh_normal, Denoising Normal. Each layer of `image` has
// one channel. Fails (usage) without a color, or with several.
[[nodiscard]] Result<DenoisableLayers> find_layers(const ExrImage& image);

// Returns the values of these channels, interleaved.
[[nodiscard]] std::vector<float> interleave(const ExrImage& image, const ThreeChannels& channels);

// Returns motion vectors as NoisyFrame has them; empty without such layers.
[[nodiscard]] std::vector<float> find_motion(const ExrImage& image, const DenoisableLayers& layers);

} // namespace kindling::app
