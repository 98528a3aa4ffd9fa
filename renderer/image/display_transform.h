// Conversion of scene-linear Rec. 709 to display values by an OpenColorIO view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling {

struct DisplayOptions {
  // Name of the view; empty for the default. Built-in views: "Standard", "ACES 1.0 SDR", "Khronos
  // PBR Neutral", "AgX", "Raw".
  std::string view;
  float exposure_stops = 0.0f; // scene values are first multiplied by 2^exposure_stops
  std::string ocio_config;     // path; empty for $OCIO if set, else the built-in configuration
};

// An immutable, thread-safe display transform.
class DisplayTransform {
 public:
  // Creates a transform. The error for an unknown view lists the existing views.
  [[nodiscard]] static Result<DisplayTransform> create(const DisplayOptions& options);
  // Returns the views of a configuration, default first.
  [[nodiscard]] static Result<std::vector<std::string>> list_views(const std::string& ocio_config);

  // Transforms interleaved RGBA with straight alpha in place. Alpha is not changed; colors are not
  // clamped.
  void apply(std::span<float> rgba) const;

  [[nodiscard]] const std::string& view() const; // the view in use, for metadata
  // Returns the configuration's file and the files of its lookup tables that the view uses; none
  // for the built-in configuration.
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const;

  DisplayTransform(DisplayTransform&&) noexcept;
  DisplayTransform& operator=(DisplayTransform&&) noexcept;
  ~DisplayTransform();

 private:
  struct Impl;
  explicit DisplayTransform(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

} // namespace kindling
