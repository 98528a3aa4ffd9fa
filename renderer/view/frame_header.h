// Numbers that are sent with a frame, and the description of a scene, as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/facade/renderer.h"
#include "renderer/view/frame.h"
#include "renderer/view/view_state.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kindling {

// A camera as an orbit, from which a page starts to move it.
struct CameraSeen {
  V3f orbit{0.0f, 90.0f, 1.0f}; // theta and phi in degrees, radius in meters
  V3f target{0.0f};
  double roll_deg = 0.0;
  double yfov_deg = 45.0;
  std::optional<double> orthographic_m;           // height of the image; set: it has no perspective
  std::optional<double> f_stop, focus_distance_m; // of its lens
};

// Returns the orbit with the position, direction and roll of a camera, about a target at this
// distance. The field of view of an orthographic camera has the same height at the target.
[[nodiscard]] CameraSeen as_orbit(const PlacedCamera& camera, double distance_m);

// Values that the header has besides those of the frame.
struct HeaderFacts {
  std::string status = "starting"; // "loading", "building", "rendering", "complete"
  std::string error;               // of the last load or render; empty: none
  CameraSeen camera;
  double rays_per_s = 0.0;
  uint64_t resident_bytes = 0;
  std::string command; // line of a shell
  uint64_t scene = 0;  // number of the description()
};

// `frame` and `displayed` may be null.
[[nodiscard]] std::string header_json(const ViewState& state, const LinearFrame* frame, const DisplayedFrame* displayed,
                                      const HeaderFacts& facts, uint64_t version, uint64_t image);

// Returns what can be chosen in a scene. `views`: of the color configuration.
[[nodiscard]] std::string describe_scene(const Renderer& renderer, const std::string& file_name,
                                         const std::vector<std::string>& views);

// Returns the values of a pixel and its surface. `denoised`: its color, if a denoised image is
// displayed. `picked` may be null.
[[nodiscard]] std::string describe_pixel(const LinearFrame& frame, const V2i& pixel, const std::optional<Rgb>& denoised,
                                         const PickedSurface* picked);

// Returns a replayed path: its vertices with the ways to them.
[[nodiscard]] std::string describe_path(const ReplayedPath& path);

// Returns the bytes of memory that the process has resident; 0 if unknown.
[[nodiscard]] uint64_t resident_bytes();

} // namespace kindling
