// Camera paths of another file: keys in JSON, or an animated camera of a glTF file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/facade/render_scene.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/shutter.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// A JSON file is an object with `keys`, a list of at least one object in the order of `time`
// (seconds): `position` and `target` [x, y, z] in meters, `up` (default [0, 1, 0]) and `fov`
// (vertical, degrees, default 45). `interpolation` is "smooth" (default; a Catmull-Rom spline
// through the keys) or "linear". Before the first key and after the last the camera does not move.
class CameraPath {
 public:
  // Reads a .json, .gltf or .glb file. `camera`: name or index of a camera of a glTF file; empty:
  // its first. Fails (input_output, scene_invalid) with the place, and (usage) if there is no such
  // camera.
  [[nodiscard]] static Result<CameraPath> load(const std::filesystem::path& file, const std::string& camera);

  // Returns the camera at a time, in seconds; with a shutter, its motion between opening and
  // closing, whatever `time_s`.
  [[nodiscard]] Result<PlacedCamera> at(double time_s, const std::optional<Shutter>& shutter) const;

 private:
  struct Key {
    double time_s = 0.0;
    V3d position{0.0}, target{0.0}, up{0.0, 1.0, 0.0};
    double yfov_deg = 45.0;
  };
  [[nodiscard]] static Result<CameraPath> load_json(const std::filesystem::path& file);
  [[nodiscard]] Key key_at(double time_s) const;

  std::string file_;
  std::vector<Key> keys_; // of a JSON file
  bool linear_ = false;
  std::optional<Scene> scene_; // of a glTF file
  std::string camera_;
};

// Loads the path of RenderOptions::camera_path, if there is one.
[[nodiscard]] Result<std::optional<CameraPath>> load_camera_path(const RenderOptions& options);

// Sets RenderOptions::own_camera to the camera of the path at the time of the image, or over its
// shutter interval, and RenderScene::path_start. Does nothing without a path.
[[nodiscard]] Result<void> place_on_path(const std::optional<CameraPath>& path, RenderScene& scene,
                                         RenderOptions& options);

} // namespace kindling::app
