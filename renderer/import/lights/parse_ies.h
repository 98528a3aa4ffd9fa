// Parser of IES LM-63 files: photometry of luminaires.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"

#include <string_view>

namespace kindling::gltf {

// Reads versions 1986 to 2019, types A, B and C. Candela are multiplied by the file's multiplier
// and ballast factor, until 1995 also by the ballast-lamp photometric factor. Keywords, TILT
// (dependence on the burning position), lamps, sizes and watts have no effect, as EXT_lights_ies
// permits. Errors are of kind scene_invalid: "line N: value, expected values".
[[nodiscard]] Result<Photometry> parse_ies(std::string_view text);

} // namespace kindling::gltf
