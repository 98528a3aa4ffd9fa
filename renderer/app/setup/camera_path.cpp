// Reads paths and interpolates their keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/camera_path.h"

#include "renderer/facade/choose.h"
#include "renderer/facade/shutter.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <type_traits>
#include <utility>

namespace kindling::app {

namespace {

using PathJson = nlohmann::json;

constexpr int kMotionKeys = 9; // of a camera on a spline, over the shutter interval

// Reads a list of three finite numbers. False if it is none.
bool read_vector(const PathJson& json, V3d& vector) {
  if (!json.is_array() || json.size() != 3) return false;
  for (int i = 0; i < 3; ++i) {
    const PathJson& number = json[static_cast<size_t>(i)];
    if (!number.is_number() || !(std::abs(number.get<double>()) <= kMaxTransform)) return false;
    vector[i] = number.get<double>();
  }
  return true;
}

// The cubic through b and c whose slopes there follow from their neighbors a and d, all at their
// times, at a time between those of b and c.
template <typename Value>
Value catmull_rom(const std::array<Value, 4>& v, const std::array<double, 4>& t, double time) {
  const double span = t[2] - t[1], s = (time - t[1]) / span, s2 = s * s, s3 = s2 * s;
  const Value slope1 = (v[2] - v[0]) * (span / (t[2] - t[0])), slope2 = (v[3] - v[1]) * (span / (t[3] - t[1]));
  return v[1] * (2.0 * s3 - 3.0 * s2 + 1.0) + slope1 * (s3 - 2.0 * s2 + s) + v[2] * (3.0 * s2 - 2.0 * s3) +
         slope2 * (s3 - s2);
}

} // namespace

Result<CameraPath> CameraPath::load(const std::filesystem::path& file, const std::string& camera) {
  if (file.extension() == ".json") return load_json(file);
  ImportOptions options;
  options.decode_textures = false;
  Result<Scene> scene = load_gltf(file, options, nullptr);
  if (!scene.ok()) return scene.error();
  CameraPath path;
  path.file_ = file.string();
  path.camera_ = camera;
  path.scene_ = std::move(scene).value();
  if (const Result<PlacedCamera> placed = path.at(0.0, std::nullopt); !placed.ok()) return placed.error();
  return path;
}

Result<CameraPath> CameraPath::load_json(const std::filesystem::path& file) {
  const auto invalid = [&](const std::string& what) {
    return Error{ErrorKind::scene_invalid, fmt::format("{}: {}", file.string(), what)};
  };
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{ErrorKind::input_output, fmt::format("{}: cannot be read", file.string())};
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const PathJson json = PathJson::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("keys") || !json["keys"].is_array() || json["keys"].empty())
    return invalid("is no camera path; it must be an object with a list 'keys'");
  CameraPath path;
  path.file_ = file.string();
  if (json.contains("interpolation")) {
    if (json["interpolation"] != "linear" && json["interpolation"] != "smooth")
      return invalid("interpolation: is neither \"smooth\" nor \"linear\"");
    path.linear_ = json["interpolation"] == "linear";
  }
  for (size_t i = 0; i < json["keys"].size(); ++i) {
    const PathJson& in_file = json["keys"][i];
    Key key;
    const auto wrong = [&](const char* member, const char* wanted) {
      return invalid(fmt::format("keys[{}].{}: is not {}", i, member, wanted));
    };
    if (!in_file.is_object()) return invalid(fmt::format("keys[{}]: is not an object", i));
    if (!in_file.contains("time") || !in_file["time"].is_number() || !std::isfinite(in_file["time"].get<double>()))
      return wrong("time", "a number of seconds");
    key.time_s = in_file["time"];
    if (i > 0 && !(key.time_s > path.keys_.back().time_s)) return wrong("time", "after that of the key before");
    if (!in_file.contains("position") || !read_vector(in_file["position"], key.position))
      return wrong("position", "a list of three numbers");
    if (!in_file.contains("target") || !read_vector(in_file["target"], key.target))
      return wrong("target", "a list of three numbers");
    if (in_file.contains("up") && !read_vector(in_file["up"], key.up)) return wrong("up", "a list of three numbers");
    if (in_file.contains("fov")) {
      const PathJson& fov = in_file["fov"];
      if (!fov.is_number() || !(fov.get<double>() >= 0.01 && fov.get<double>() <= 179.0))
        return wrong("fov", "an angle of 0.01 to 179 degrees");
      key.yfov_deg = fov;
    }
    path.keys_.push_back(key);
  }
  return path;
}

CameraPath::Key CameraPath::key_at(double time_s) const {
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time_s,
                                      [](double time, const Key& key) { return time < key.time_s; });
  if (after == keys_.begin()) return keys_.front();
  if (after == keys_.end()) return keys_.back();
  const Key &b = *(after - 1), &c = *after;
  Key result;
  result.time_s = time_s;
  // At the ends, the slope is that of the line to the only neighbor.
  const Key& a = after - 1 == keys_.begin() ? b : *(after - 2);
  const Key& d = after + 1 == keys_.end() ? c : *(after + 1);
  const auto between = [&](auto Key::*member) {
    if (linear_) return b.*member + (c.*member - b.*member) * ((time_s - b.time_s) / (c.time_s - b.time_s));
    return catmull_rom<std::remove_cvref_t<decltype(b.*member)>>({a.*member, b.*member, c.*member, d.*member},
                                                                 {a.time_s, b.time_s, c.time_s, d.time_s}, time_s);
  };
  result.position = between(&Key::position);
  result.target = between(&Key::target);
  result.up = between(&Key::up);
  result.yfov_deg = std::clamp(between(&Key::yfov_deg), 0.01, 179.0);
  return result;
}

Result<PlacedCamera> CameraPath::at(double time_s, const std::optional<Shutter>& shutter) const {
  if (scene_) {
    const Result<PosedScene> posed = pose_scene(*scene_, {.time_s = time_s, .shutter = shutter});
    if (!posed.ok()) return posed.error();
    ImageSettings image;
    image.camera = camera_;
    Result<std::optional<PlacedCamera>> chosen = choose_camera(*scene_, posed.value(), image);
    if (!chosen.ok()) return chosen.error();
    if (!chosen.value()) return usage_error(fmt::format("--camera-path: {} has no camera", file_));
    return *std::move(chosen).value();
  }
  const auto matrix = [](const Key& key) { return look_at(V3f(key.position), V3f(key.target), V3f(key.up)); };
  const double open_s = shutter ? shutter->open_s : time_s;
  PlacedCamera placed;
  const Key key = key_at(open_s);
  placed.camera.name = "path";
  placed.camera.yfov_rad = static_cast<float>(key.yfov_deg) * (kPi / 180.0f);
  placed.camera_to_world = matrix(key);
  for (int i = 1; shutter && shutter->close_s > open_s && i < kMotionKeys; ++i)
    placed.later_transforms.push_back(matrix(key_at(open_s + (shutter->close_s - open_s) * i / (kMotionKeys - 1))));
  return placed;
}

Result<std::optional<CameraPath>> load_camera_path(const RenderOptions& options) {
  if (options.camera_path.empty()) return std::optional<CameraPath>();
  Result<CameraPath> path = CameraPath::load(options.camera_path, options.camera);
  if (!path.ok()) return path.error();
  return std::optional(std::move(path).value());
}

Result<void> place_on_path(const std::optional<CameraPath>& path, RenderScene& scene, RenderOptions& options) {
  if (!path) return {};
  if (!scene.path_start) {
    Result<PlacedCamera> start = path->at(0.0, std::nullopt);
    if (!start.ok()) return start.error();
    scene.path_start = std::move(start).value();
  }
  const double time_s = options.time_s.value_or(0.0);
  Result<PlacedCamera> placed = path->at(time_s, std::nullopt);
  if (!placed.ok()) return placed.error();
  options.own_camera = std::move(placed).value();
  if (options.aovs.needs_motion())
    for (const double step : {-1.0, 1.0}) {
      Result<PlacedCamera> neighbor = path->at(time_s + step * options.frame_step.time_s, std::nullopt);
      if (!neighbor.ok()) return neighbor.error();
      (step < 0.0 ? options.frame_step.previous_camera : options.frame_step.next_camera) = std::move(neighbor).value();
    }
  const Result<std::optional<Shutter>> shutter = choose_shutter(scene.scene, scene.root, options);
  if (!shutter.ok()) return shutter.error();
  if (!shutter.value()) return {};
  placed = path->at(time_s, shutter.value());
  if (!placed.ok()) return placed.error();
  options.own_camera = std::move(placed).value();
  return {};
}

} // namespace kindling::app
