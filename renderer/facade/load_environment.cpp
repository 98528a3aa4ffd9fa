// Makes an environment from an image file or a constant color.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/load_environment.h"

#include "renderer/image/decode_image.h"
#include "renderer/import/files/file_bytes.h"

#include <array>
#include <numbers>
#include <span>
#include <utility>

namespace kindling {

namespace {

uint64_t hash_image(const Image& image) {
  const std::array<int, 4> shape{image.width, image.height, image.channels, static_cast<int>(image.type)};
  return gltf::hash_content(std::as_bytes(std::span(image.pixels)), gltf::hash_bytes(std::as_bytes(std::span(shape))));
}

} // namespace

Result<LoadedEnvironment> load_environment(const WorldSettings& settings, EnvironmentTimes* times) {
  const auto intensity = static_cast<float>(settings.env_intensity);
  if (settings.env_color) return LoadedEnvironment{std::make_shared<Environment>(*settings.env_color * intensity)};
  if (settings.env_file.empty()) return LoadedEnvironment{};
  Stopwatch clock;
  Result<Image> image = read_image_file(settings.env_file);
  if (!image.ok()) return Error{image.error().kind, "--env: " + image.error().message};
  const uint64_t hash = hash_image(image.value());
  const WorkTime reading = clock.lap();
  const auto rotation_rad = static_cast<float>(settings.env_rotation_deg * std::numbers::pi / 180.0);
  EnvironmentPointer environment =
      std::make_shared<Environment>(std::make_shared<const Image>(std::move(image).value()), rotation_rad, intensity);
  if (times != nullptr) *times = {reading, clock.lap()};
  return LoadedEnvironment{std::move(environment), hash};
}

} // namespace kindling
