// JSON of a view's state with its ranges, and the settings that follow from it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_state.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kindling {

namespace {

using nlohmann::json;

constexpr int kMinSide = 16, kMaxSide = 4096;
constexpr double kMaxCoordinate = 1e9; // meters
constexpr size_t kMaxName = 256;

Error wrong(const std::string& member, const std::string& accepted) {
  return {ErrorKind::usage, fmt::format("{}: use {}", member, accepted)};
}

std::optional<double> number_in(const json& value, double min, double max) {
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  return std::isfinite(number) && number >= min && number <= max ? std::optional(number) : std::nullopt;
}

// Null is unset.
Result<void> set_number(const json& value, const std::string& member, double min, double max,
                        std::optional<double>& target) {
  if (value.is_null()) {
    target.reset();
    return {};
  }
  const std::optional<double> number = number_in(value, min, max);
  if (!number) return wrong(member, fmt::format("a number from {:g} to {:g}, or null", min, max));
  target = number;
  return {};
}

Result<void> set_number(const json& value, const std::string& member, double min, double max, double& target) {
  const std::optional<double> number = number_in(value, min, max);
  if (!number) return wrong(member, fmt::format("a number from {:g} to {:g}", min, max));
  target = *number;
  return {};
}

Result<void> set_flag(const json& value, const std::string& member, bool& target) {
  if (!value.is_boolean()) return wrong(member, "true or false");
  target = value.get<bool>();
  return {};
}

Result<void> set_name(const json& value, const std::string& member, std::string& target) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxName)
    return wrong(member, fmt::format("a text of at most {} bytes", kMaxName));
  target = value.get<std::string>();
  return {};
}

std::optional<V3f> vector_of(const json& value) {
  if (!value.is_array() || value.size() != 3) return std::nullopt;
  V3f result;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> number = number_in(value[static_cast<size_t>(i)], -kMaxCoordinate, kMaxCoordinate);
    if (!number) return std::nullopt;
    result[i] = static_cast<float>(*number);
  }
  return result;
}

Result<void> set_size(const json& value, V2i& target) {
  if (value.is_array() && value.size() == 2) {
    const std::optional<double> x = number_in(value[0], kMinSide, kMaxSide),
                                y = number_in(value[1], kMinSide, kMaxSide);
    if (x && y) {
      target = V2i(static_cast<int>(*x), static_cast<int>(*y));
      return {};
    }
  }
  return wrong("size", fmt::format("[width, height] from {} to {} pixels", kMinSide, kMaxSide));
}

Result<void> set_orbit(const json& value, std::optional<V3f>& target) {
  if (value.is_null()) {
    target.reset();
    return {};
  }
  const std::optional<V3f> orbit = vector_of(value);
  if (!orbit || orbit->z < 0.0f) return wrong("orbit", "[theta, phi, radius] in degrees and meters, or null");
  target = orbit;
  return {};
}

Result<void> set_member(const std::string& member, const json& value, ViewState& state) {
  ViewCamera& camera = state.camera;
  if (member == "camera") return set_name(value, member, camera.name);
  if (member == "orbit") return set_orbit(value, camera.orbit);
  if (member == "target") {
    const std::optional<V3f> target = vector_of(value);
    if (!target) return wrong(member, "[x, y, z] in meters");
    camera.target = *target;
    return {};
  }
  if (member == "roll") return set_number(value, member, -360.0, 360.0, camera.roll_deg);
  if (member == "orthographic") return set_number(value, member, 1e-6, kMaxCoordinate, camera.orthographic_m);
  if (member == "fov") return set_number(value, member, 0.1, 170.0, camera.yfov_deg);
  if (member == "f_stop") return set_number(value, member, 0.0, 1000.0, camera.f_stop);
  if (member == "focus") return set_number(value, member, 1e-6, kMaxCoordinate, camera.focus_distance_m);
  if (member == "time") return set_number(value, member, -1e6, 1e6, state.time_s);
  if (member == "size") return set_size(value, state.size_px);
  if (member == "spp") {
    const std::optional<double> spp = number_in(value, 1, kMaxViewSpp);
    if (!spp) return wrong(member, fmt::format("a number from 1 to {}", kMaxViewSpp));
    state.spp = static_cast<uint32_t>(*spp);
    return {};
  }
  if (member == "guiding") return set_flag(value, member, state.guiding);
  if (member == "false_color") return set_flag(value, member, state.false_color);
  if (member == "denoise") return set_flag(value, member, state.denoise);
  if (member == "scene") return set_name(value, member, state.scene_name);
  if (member == "variant") return set_name(value, member, state.variant_name);
  if (member == "view") return set_name(value, member, state.display_view);
  if (member == "exposure") return set_number(value, member, -32.0, 32.0, state.exposure_stops);
  if (member == "shown") {
    const std::optional<Aov> aov =
        value.is_string() ? aov_from_name(value.get_ref<const std::string&>()) : std::optional<Aov>();
    if (!aov || !is_offered(*aov)) return wrong(member, "the name of an AOV");
    state.shown = *aov;
    return {};
  }
  return wrong(member.substr(0, 32), "members of the state only");
}

json number_or_null(const std::optional<double>& value) { return value ? json(*value) : json(); }

} // namespace

ViewChange compare(const ViewState& before, const ViewState& after) {
  if (before == after) return ViewChange::none;
  if (before.scene_name != after.scene_name || before.variant_name != after.variant_name) return ViewChange::world;
  if (before.camera != after.camera || before.time_s != after.time_s) return ViewChange::motion;
  if (before.size_px != after.size_px || before.spp != after.spp || before.guiding != after.guiding ||
      before.shown != after.shown)
    return ViewChange::image;
  return ViewChange::display;
}

ViewState initial_state(const ViewOptions& options) {
  const ImageSettings& image = options.image;
  ViewState state;
  state.camera.name = image.camera;
  state.camera.orbit = image.orbit;
  state.camera.target = image.target;
  state.camera.orthographic_m = image.orthographic_m;
  state.camera.yfov_deg = image.yfov_deg;
  state.camera.f_stop = image.lens.pinhole ? std::optional(0.0) : image.lens.f_stop;
  state.camera.focus_distance_m = image.lens.focus_distance_m;
  state.time_s = image.time_s;
  state.size_px = image.size_px.value_or(V2i(0, 0));
  if (image.spp) state.spp = *image.spp;
  state.guiding = image.guiding != Guiding::off;
  state.scene_name = options.world.scene_name;
  state.variant_name = options.world.variant_name;
  state.display_view = options.display_view;
  state.exposure_stops = options.exposure_stops;
  return state;
}

Result<void> apply_json(std::string_view text, ViewState& state) {
  const auto no_nesting = [](int depth, json::parse_event_t, const json&) { return depth <= 3; };
  const json changes = json::parse(text, no_nesting, false);
  if (!changes.is_object()) return Error{ErrorKind::usage, "the body is no JSON object"};
  ViewState changed = state;
  for (const auto& [member, value] : changes.items())
    if (Result<void> set = set_member(member, value, changed); !set.ok()) return set;
  state = changed;
  return {};
}

std::string to_json(const ViewState& state) {
  const ViewCamera& camera = state.camera;
  json result{{"camera", camera.name},
              {"orbit", camera.orbit ? json{camera.orbit->x, camera.orbit->y, camera.orbit->z} : json()},
              {"target", {camera.target.x, camera.target.y, camera.target.z}},
              {"roll", camera.roll_deg},
              {"orthographic", number_or_null(camera.orthographic_m)},
              {"fov", number_or_null(camera.yfov_deg)},
              {"f_stop", number_or_null(camera.f_stop)},
              {"focus", number_or_null(camera.focus_distance_m)},
              {"time", number_or_null(state.time_s)},
              {"size", {state.size_px.x, state.size_px.y}},
              {"spp", state.spp},
              {"guiding", state.guiding},
              {"shown", aov_info(state.shown).name},
              {"scene", state.scene_name},
              {"variant", state.variant_name},
              {"view", state.display_view},
              {"exposure", state.exposure_stops},
              {"false_color", state.false_color},
              {"denoise", state.denoise}};
  return result.dump(-1, ' ', false, json::error_handler_t::replace);
}

ImageSettings image_settings(const ViewState& state, const ViewOptions& options) {
  ImageSettings image = options.image;
  const ViewCamera& camera = state.camera;
  image.size_px = state.size_px;
  image.scale = 1.0;
  image.camera = camera.orbit ? std::string() : camera.name;
  image.orbit = camera.orbit;
  image.target = camera.target;
  image.yfov_deg = camera.yfov_deg;
  image.orthographic_m.reset();
  if (camera.orbit && camera.orthographic_m) {
    image.orthographic_m = camera.orthographic_m;
    image.yfov_deg.reset();
  }
  if (camera.orbit && camera.roll_deg != 0.0) {
    const M44f placed =
        orbit_camera({camera.orbit->x, camera.orbit->y, camera.orbit->z, camera.target}).camera_to_world;
    image.turn = CameraTurn{camera.roll_deg, V3f(placed[2][0], placed[2][1], placed[2][2]), camera.target};
  }
  image.time_s = state.time_s;
  if (camera.f_stop) {
    image.lens.pinhole = *camera.f_stop == 0.0;
    image.lens.f_stop = image.lens.pinhole ? std::nullopt : camera.f_stop;
  }
  if (image.lens.pinhole) image.lens = LensOptions{.pinhole = true};
  if (camera.focus_distance_m && image.lens.f_stop) {
    image.lens.focus_distance_m = camera.focus_distance_m;
    image.lens.focus_pixel.reset();
  }
  image.spp = image.planned_spp = state.spp;
  if (!state.guiding) image.guiding = Guiding::off;
  if (state.guiding && image.guiding == Guiding::off) image.guiding = Guiding::automatic;
  if (state.shown != Aov::beauty && state.shown != Aov::alpha) image.aovs.insert(state.shown);
  image.denoising = state.denoise ? Denoising::fast : Denoising::off;
  if (state.denoise) image.chooses_path_reuse = false; // images of the first samples are denoised, too
  return image;
}

WorldSettings world_settings(const ViewState& state, const ViewOptions& options) {
  WorldSettings world = options.world;
  world.scene_name = state.scene_name;
  world.variant_name = state.variant_name;
  return world;
}

ImageSettings moving_settings(const ViewState& state, const ViewOptions& options, double max_paths, uint32_t seed) {
  constexpr double kMinShare = 1.0 / 16; // of a side
  constexpr uint32_t kMaxSamples = 16;
  ImageSettings image = image_settings(state, options);
  const double pixels = static_cast<double>(state.size_px.x) * state.size_px.y;
  const double share = std::clamp(std::sqrt(max_paths / pixels), kMinShare, 1.0);
  const auto side = [share](int px) { return std::max(8, static_cast<int>(std::lround(px * share))); };
  image.size_px = V2i(side(state.size_px.x), side(state.size_px.y));
  image.spp = std::clamp(static_cast<uint32_t>(max_paths / pixels), 1U, kMaxSamples);
  image.planned_spp = image.spp;
  image.guiding = Guiding::off;
  image.chooses_light_paths = false;
  image.integrator.photons = 0.0f;
  image.chooses_photons = false;
  image.integrator.manifold_samples = 0;
  image.chooses_direct_samples = false;
  image.chooses_reflection_samples = false;
  image.chooses_path_reuse = false;
  image.sample_rates = SampleRateKind::even;
  image.denoising = Denoising::off;
  image.seed = seed;
  return image;
}

} // namespace kindling
