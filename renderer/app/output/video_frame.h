// Frames of videos that exist as images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

struct VideoFrame {
  std::vector<uint8_t> rgb; // rows from the top
  V2i size_px{0, 0};
};

// Returns the frame that a render has written as this image, with the bits that the video would get
// from the render: of PNG files of 8 bits that are opaque everywhere. Nothing for other files, and
// for files that are damaged.
[[nodiscard]] std::optional<VideoFrame> read_video_frame(const std::filesystem::path& image);

} // namespace kindling::app
