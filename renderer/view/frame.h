// One frame of a view: the pixels of an image as rendered, and as a browser shows them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/facade/renderer.h"
#include "renderer/view/view_state.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kindling {

// Pixels of a film after a pass. All of its samples belong to the image of `image`.
struct LinearFrame {
  ViewState state;     // that it was rendered for
  ImageSettings image; // with ImageSettings::spp set to the samples that the pixels have
  WorldSettings world; // with decided studio
  V2i size_px{0, 0};
  std::vector<float> rgba;   // Film::resolve_rgba()
  std::vector<float> shown;  // values of ViewState::shown, if that is another AOV than beauty
  std::vector<float> albedo; // for a denoiser, as `normal`; else empty
  std::vector<float> normal;
  bool moving = false;   // a quick image of a view that moves
  bool complete = false; // has all samples that were asked for
  double render_s = 0.0;
  uint64_t rays = 0;
};
using LinearFramePointer = std::shared_ptr<const LinearFrame>;

// Returns a frame of a film.
[[nodiscard]] LinearFrame make_linear_frame(const Film& film, const ViewState& state);

inline constexpr size_t kHistogramBins = 64;
inline constexpr float kHistogramMinStops = -10.0f, kHistogramMaxStops = 6.0f; // relative to luminance 1

struct DisplayedFrame {
  std::string jpeg;
  // Number of pixels by the binary logarithm of their luminance, denoised if that is displayed,
  // before exposure and view. The first and last bin have those beyond.
  std::array<uint32_t, kHistogramBins> histogram{};
  std::array<float, 2> range{}; // of the values that false colors show
  std::vector<float> denoised;  // RGBA as LinearFrame::rgba, if the display is made of it; else empty
};

// Display of frames in one view and exposure.
class FrameDisplay {
 public:
  // Fails (usage) if there is no such view, with a list.
  [[nodiscard]] Result<void> choose(const std::string& view, double exposure_stops, const std::string& ocio_config);

  // Fails (render_failed) if the image cannot be encoded or denoised. `denoiser` may be null.
  [[nodiscard]] Result<DisplayedFrame> display(const LinearFrame& frame, const ViewState& state,
                                               const Denoiser* denoiser) const;
  [[nodiscard]] const DisplayTransform& transform() const { return *transform_; }

 private:
  std::optional<DisplayTransform> transform_;
  std::string view_, config_;
  double exposure_stops_ = 0.0;
};

// Returns a color of the map "turbo" (Mikhailov 2019, by its polynomials) for t in [0, 1], as
// display values.
[[nodiscard]] std::array<float, 3> turbo(float t);

enum class FileKind { png, exr };
// Returns the bytes of a file with the pixels of the frame, as write_film() makes it: EXR files
// have the AOV that is shown as a layer. `denoised`: in place of the frame's pixels; empty: none.
// Fails (input_output) if no temporary file can be written.
[[nodiscard]] Result<std::string> make_file(const LinearFrame& frame, const std::vector<float>& denoised, FileKind kind,
                                            const DisplayTransform& transform, const std::string& command_line);

} // namespace kindling
