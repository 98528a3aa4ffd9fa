// From scene-linear Rec. 709 to display values through an OpenColorIO view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling {

struct DisplayOptions {
  std::string
      view; // empty: the config's default; built-in: "Standard", "ACES 1.0 SDR", "Khronos PBR Neutral", "AgX", "Raw"
  float exposure_stops = 0.0f; // scene values are multiplied by 2^exposure first
  std::string ocio_config;     // path; empty: $OCIO where set, else the built-in config
};

// Immutable and thread-safe.
class DisplayTransform {
 public:
  // An unknown view is refused with the list of those that exist.
  [[nodiscard]] static Result<DisplayTransform> create(const DisplayOptions& options);
  // The views of that config, default first.
  [[nodiscard]] static Result<std::vector<std::string>> list_views(const std::string& ocio_config);

  // In place; rgba interleaved, straight alpha (alpha is untouched). Output not clamped.
  void apply(std::span<float> rgba) const;

  [[nodiscard]] const std::string& view() const; // the view in use, for metadata

  DisplayTransform(DisplayTransform&&) noexcept;
  DisplayTransform& operator=(DisplayTransform&&) noexcept;
  ~DisplayTransform();

 private:
  struct Impl;
  explicit DisplayTransform(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

} // namespace kindling
