// Reads all channels of an EXR file, as write_exr() writes them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/decode_image.h"
#include "renderer/image/write_image.h"

#include <filesystem>

namespace kindling {

// Reads the first part that has more than one channel, else the first part; each channel becomes a
// layer, half or float as in the file. Of the attributes, strings, floats, integers and matrices of
// 4 x 4 remain. Fails (input_output) on files that cannot be read, are no EXR, have subsampled
// channels, deep pixels, or more pixels or channels than `limits` and 256.
[[nodiscard]] Result<ExrImage> read_exr(const std::filesystem::path& path, const ImageLimits& limits = {});

} // namespace kindling
