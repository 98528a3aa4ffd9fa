// Takes the layers of an EXR image apart.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/denoise/denoisable_image.h"

#include "renderer/image/read_exr.h"

#include <utility>

namespace kindling::app {

Result<DenoisableImage> read_denoisable(const std::filesystem::path& file) {
  Result<ExrImage> image = read_exr(file);
  if (!image.ok()) return image.error();
  Result<DenoisableLayers> layers = find_layers(image.value());
  if (!layers.ok()) return Error{layers.error().kind, file.string() + ": " + layers.error().message};
  DenoisableImage result{std::move(image).value(), std::move(layers).value(), {}, {}, {}, {}, {}};
  const DenoisableLayers& found = result.layers;
  const std::vector<float> color = interleave(result.image, found.noisy.value_or(found.color));
  result.rgba.assign(color.size() / 3 * 4, 1.0f);
  for (size_t i = 0; i < color.size() / 3; ++i) {
    for (size_t c = 0; c < 3; ++c) result.rgba[4 * i + c] = color[3 * i + c];
    if (found.alpha) result.rgba[4 * i + 3] = result.image.layers[*found.alpha].values[i];
  }
  if (found.albedo) result.albedo = interleave(result.image, *found.albedo);
  if (found.normal) result.normal = interleave(result.image, *found.normal);
  if (found.samples) result.samples = result.image.layers[*found.samples].values;
  result.motion = find_motion(result.image, found);
  return result;
}

} // namespace kindling::app
