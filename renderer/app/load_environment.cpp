// An environment from a picture or a colour.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/load_environment.h"

#include "renderer/image/decode_image.h"

#include <numbers>

namespace kindling::app {

Result<EnvironmentPointer> load_environment(const RenderOptions& options) {
  const auto intensity = static_cast<float>(options.env_intensity);
  if (options.env_color) return EnvironmentPointer(std::make_shared<Environment>(*options.env_color * intensity));
  if (options.env_file.empty()) return EnvironmentPointer();
  Result<Image> image = read_image_file(options.env_file);
  if (!image.ok()) return Error{image.error().kind, "--env: " + image.error().message};
  const auto rotation_rad = static_cast<float>(options.env_rotation_deg * std::numbers::pi / 180.0);
  return EnvironmentPointer(
      std::make_shared<Environment>(std::make_shared<const Image>(std::move(image).value()), rotation_rad, intensity));
}

} // namespace kindling::app
