// JSON of frames, scenes and pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/frame_header.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include <unistd.h>

namespace kindling {

namespace {

using nlohmann::json;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json list_of(const V3f& v) { return {v.x, v.y, v.z}; }
json number_or_null(const std::optional<double>& value) { return value ? json(*value) : json(); }

// The range of all key times, or null without animations.
json time_range(const Scene& scene) {
  float begin = kInfinity, end = -kInfinity;
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (!channel.times_s.empty()) {
        begin = std::min(begin, channel.times_s.front());
        end = std::max(end, channel.times_s.back());
      }
  return begin <= end ? json{begin, end} : json();
}

json material_values(const SurfacePoint& surface) {
  const BsdfParameters& bsdf = surface.bsdf;
  json values{{"base color", list_of(bsdf.base_color)}, {"metallic", bsdf.metallic}, {"roughness", bsdf.roughness}};
  if (surface.unlit) values = json::object();
  if (surface.emitted != Rgb(0.0f)) values["emission"] = list_of(surface.emitted);
  if (surface.unlit || !surface.layered) return values;
  const LayerParameters& layers = surface.layers.bsdf;
  values["ior"] = bsdf.ior;
  const std::pair<const char*, float> strengths[] = {{"clearcoat", layers.clearcoat},
                                                     {"anisotropy", layers.anisotropy},
                                                     {"iridescence", layers.iridescence},
                                                     {"transmission", layers.transmission},
                                                     {"diffuse transmission", layers.diffuse_transmission}};
  for (const auto& [name, strength] : strengths)
    if (strength > 0.0f) values[name] = strength;
  if (layers.sheen_color != Rgb(0.0f)) values["sheen color"] = list_of(layers.sheen_color);
  return values;
}

} // namespace

CameraSeen as_orbit(const PlacedCamera& camera, double distance_m) {
  const M44f& m = camera.camera_to_world;
  const V3f eye(m[3][0], m[3][1], m[3][2]);
  const V3f back = V3f(m[2][0], m[2][1], m[2][2]).normalized();
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  constexpr double kLevelDeg = 1e-3; // rounding of a camera that has no roll
  CameraSeen seen;
  const auto radius = static_cast<float>(distance_m);
  seen.orbit = V3f(static_cast<float>(std::atan2(back.x, back.z) * kDegrees),
                   static_cast<float>(std::acos(std::clamp(back.y, -1.0f, 1.0f)) * kDegrees), radius);
  seen.target = eye - back * radius;
  // The roll is the angle to a camera that looks in this direction and has a horizontal x axis.
  const float theta = seen.orbit.x * kPi / 180.0f;
  const V3f right(std::cos(theta), 0.0f, -std::sin(theta)), actual(m[0][0], m[0][1], m[0][2]);
  const double roll_deg = std::atan2(back.dot(right.cross(actual)), right.dot(actual)) * kDegrees;
  if (std::abs(roll_deg) > kLevelDeg) seen.roll_deg = roll_deg;
  const SceneCamera& lens = camera.camera;
  if (lens.kind == SceneCamera::Kind::orthographic) seen.orthographic_m = 2.0 * std::abs(lens.ymag);
  seen.yfov_deg = lens.kind == SceneCamera::Kind::orthographic
                      ? 2.0 * std::atan(std::abs(lens.ymag) / std::max(distance_m, 1e-6)) * kDegrees
                      : lens.yfov_rad * kDegrees;
  if (lens.lens.f_stop) {
    seen.f_stop = *lens.lens.f_stop;
    if (lens.lens.focus_distance_m) seen.focus_distance_m = *lens.lens.focus_distance_m;
  }
  return seen;
}

std::string header_json(const ViewState& state, const LinearFrame* frame, const DisplayedFrame* displayed,
                        const HeaderFacts& facts, uint64_t version, uint64_t image) {
  json header{{"version", version},
              {"image", image},
              {"state", json::parse(to_json(state))},
              {"status", facts.status},
              {"error", facts.error},
              {"scene", facts.scene},
              {"rays_per_s", facts.rays_per_s},
              {"resident_bytes", facts.resident_bytes},
              {"command", facts.command},
              {"camera",
               {{"orbit", list_of(facts.camera.orbit)},
                {"target", list_of(facts.camera.target)},
                {"roll", facts.camera.roll_deg},
                {"orthographic", number_or_null(facts.camera.orthographic_m)},
                {"fov", facts.camera.yfov_deg},
                {"f_stop", number_or_null(facts.camera.f_stop)},
                {"focus", number_or_null(facts.camera.focus_distance_m)}}}};
  if (frame && displayed) {
    header["frame"] = {{"size", {frame->size_px.x, frame->size_px.y}},
                       {"samples", frame->image.samples_per_pixel()},
                       {"planned", frame->image.planned_samples()},
                       {"moving", frame->moving},
                       {"complete", frame->complete},
                       {"denoised", !displayed->denoised.empty()},
                       {"render_s", frame->render_s},
                       {"histogram", displayed->histogram},
                       {"range", displayed->range}};
  }
  return text_of(header);
}

std::string describe_scene(const Renderer& renderer, const std::string& file_name,
                           const std::vector<std::string>& views) {
  const Scene& scene = renderer.scene();
  json scenes = json::array(), aovs = json::array();
  for (const auto& one : scene.scenes) scenes.push_back(one.name);
  for (const AovInfo& info : kAovs)
    if (is_offered(info.aov)) aovs.push_back(info.name);
  json variants = scene.variants;
  return text_of({{"file", file_name},
                  {"cameras", renderer.cameras()},
                  {"scenes", scenes},
                  {"variants", variants},
                  {"times", time_range(scene)},
                  {"views", views},
                  {"aovs", aovs},
                  {"histogram", {kHistogramMinStops, kHistogramMaxStops}}});
}

std::string describe_pixel(const LinearFrame& frame, const V2i& pixel, const std::optional<Rgb>& denoised,
                           const PickedSurface* picked) {
  const size_t index =
      static_cast<size_t>(pixel.y) * static_cast<size_t>(frame.size_px.x) + static_cast<size_t>(pixel.x);
  const float* rgba = &frame.rgba[index * 4];
  json result{{"pixel", {pixel.x, pixel.y}},
              {"size", {frame.size_px.x, frame.size_px.y}},
              {"rgb", {rgba[0], rgba[1], rgba[2]}},
              {"alpha", rgba[3]}};
  if (denoised) result["denoised"] = {denoised->x, denoised->y, denoised->z};
  if (!frame.shown.empty()) {
    const AovInfo& info = aov_info(frame.state.shown);
    const auto channels = static_cast<size_t>(info.channels);
    const auto first = frame.shown.begin() + static_cast<std::ptrdiff_t>(index * channels);
    result["shown"] = {{"name", info.name}, {"values", std::vector<float>(first, first + info.channels)}};
  }
  if (picked)
    result["surface"] = {{"node", picked->node},
                         {"material", picked->material},
                         {"depth_m", picked->depth_m},
                         {"position", list_of(picked->surface.position)},
                         {"normal", list_of(picked->surface.shading_normal)},
                         {"values", material_values(picked->surface)}};
  return text_of(result);
}

std::string describe_path(const ReplayedPath& path) {
  json vertices = json::array();
  for (size_t i = 0; i < path.replayed.trace.size(); ++i) {
    const PathVertex& vertex = path.replayed.trace[i];
    const PathWay& way = path.ways[i];
    json entry{{"event", vertex.event},
               {"bounce", vertex.bounce},
               {"step", path_step_name(way.step)},
               {"material", vertex.material},
               {"throughput", list_of(vertex.throughput)},
               {"radiance", list_of(vertex.radiance)},
               {"distance", vertex.distance}};
    if (way.seen) entry["way"] = {{(*way.seen)[0].x, (*way.seen)[0].y}, {(*way.seen)[1].x, (*way.seen)[1].y}};
    vertices.push_back(std::move(entry));
  }
  return text_of({{"pixel", {path.pixel.x, path.pixel.y}},
                  {"size", {path.size_px.x, path.size_px.y}},
                  {"sample", path.sample},
                  {"radiance", list_of(path.replayed.radiance)},
                  {"vertices", vertices}});
}

uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  uint64_t pages = 0, resident = 0;
  return file >> pages >> resident ? resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

} // namespace kindling
