// Light groups among the layers of an EXR image, and their mixture.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/denoise/exr_layers.h"
#include "renderer/app/options/options.h"
#include "renderer/base/math.h"
#include "renderer/base/result.h"
#include "renderer/image/write_image.h"

#include <string>
#include <vector>

namespace kindling::app {

struct LightLayer {
  std::string group;
  ThreeChannels channels;
};

// Finds the layers Combined_GROUP of an image, as Kindling and Blender name them (Blender with a
// view layer in front), in the order of the file. Each layer of `image` has one channel.
[[nodiscard]] std::vector<LightLayer> find_light_layers(const ExrImage& image);

// Returns the factor of each layer. Fails (usage) on a name that no layer has.
[[nodiscard]] Result<std::vector<Rgb>> factors_of(const std::vector<LightLayer>& layers,
                                                  const std::vector<LightFactor>& wanted, const Rgb& others);

// Multiplies the layers by the factors, and makes `color` their sum; if all factors are 1 the image
// remains as it is. Layers of light that do not fit the new color are removed: noisy, variance,
// direct and others by Kindling's and Blender's names. Indices into image.layers become invalid.
void relight(ExrImage& image, const ThreeChannels& color, const std::vector<LightLayer>& layers,
             const std::vector<Rgb>& factors);

} // namespace kindling::app
