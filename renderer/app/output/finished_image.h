// Writing of images that are changed after their render: denoised, relit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"
#include "renderer/image/display_transform.h"
#include "renderer/image/write_image.h"

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace kindling::app {

struct FinishedImage {
  std::vector<float> rgba; // premultiplied
  V2i size_px{0, 0};
  std::map<std::string, std::string> text; // metadata of PNG and JPEG files
  std::function<ExrImage()> exr;           // all layers of EXR files
};

// Writes an image to all outputs, and prints the names of its files. `view` is that of `options`,
// except that --exposure auto is measured here and reported. Returns the first error; further ones
// are printed.
[[nodiscard]] Result<void> write_finished_image(const std::vector<std::filesystem::path>& outputs,
                                                const FinishedImage& image, const RenderOptions& options,
                                                DisplayTransform view, Console& console);

} // namespace kindling::app
