// The state of a view that its pages share and change: camera, time, sampling, display.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/aov.h"
#include "renderer/session/image_settings.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kindling {

inline constexpr uint32_t kMaxViewSpp = 65536;

// Settings of a view at its start, by the command line. Those that ViewState has are its defaults.
struct ViewOptions {
  WorldSettings world;
  ImageSettings image;
  std::string display_view; // DisplayOptions
  double exposure_stops = 0.0;
  std::string ocio_config;
  int threads = 0; // 0: all
};

// Members of one look through a camera. An orbit replaces the scene's camera.
struct ViewCamera {
  std::string name; // of the scene's camera, or its index; empty: the first, or the fitted one
  std::optional<V3f> orbit;
  V3f target{0.0f};
  double roll_deg = 0.0;                // of an orbit, about its viewing direction: --turn
  std::optional<double> orthographic_m; // of an orbit: ImageSettings::orthographic_m
  std::optional<double> yfov_deg;
  std::optional<double> f_stop;           // unset: that of the camera; 0: none
  std::optional<double> focus_distance_m; // unset: that of the camera
  bool operator==(const ViewCamera&) const = default;
};

// AOVs that a view can show; it has no shadow catchers.
[[nodiscard]] constexpr bool is_offered(Aov aov) { return aov != Aov::shadow_catcher; }

struct ViewState {
  // --- camera and time, which change while somebody moves ---
  ViewCamera camera;
  std::optional<double> time_s;
  // --- image ---
  V2i size_px{0, 0}; // 0: unknown, until the first page has asked for one
  uint32_t spp = 1024;
  bool guiding = true;
  Aov shown = Aov::beauty;
  // --- World ---
  std::string scene_name;
  std::string variant_name;
  // --- display ---
  std::string display_view;
  double exposure_stops = 0.0;
  bool false_color = false; // of the luminance
  bool denoise = false;     // then pixels share no paths, either

  bool operator==(const ViewState&) const = default;
};

// The widest change between two states, which decides how much is done again.
enum class ViewChange { none, display, image, motion, world };
[[nodiscard]] ViewChange compare(const ViewState& before, const ViewState& after);

[[nodiscard]] ViewState initial_state(const ViewOptions& options);

// Applies the members of a JSON object to a state. Fails (usage) for anything else: a member that
// is unknown, of another type, or out of range; the state is unchanged then.
[[nodiscard]] Result<void> apply_json(std::string_view json, ViewState& state);
[[nodiscard]] std::string to_json(const ViewState& state);

// Returns the settings of the whole image of a state, to which `options` contribute all that the
// state lacks.
[[nodiscard]] ImageSettings image_settings(const ViewState& state, const ViewOptions& options);
[[nodiscard]] WorldSettings world_settings(const ViewState& state, const ViewOptions& options);

// Returns the settings of an image while the camera moves: one of that many pixels at most, in the
// aspect ratio of the whole one, with so many samples, without guiding.
[[nodiscard]] ImageSettings moving_settings(const ViewState& state, const ViewOptions& options, double max_paths,
                                            uint32_t seed);

} // namespace kindling
