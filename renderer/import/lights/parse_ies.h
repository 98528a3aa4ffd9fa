// IES LM-63: photometry of luminaires as text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"

#include <string_view>

namespace kindling::gltf {

// Versions of 1986 to 2019, types A, B and C. Candela are multiplied by the file's multiplier and ballast factor, and until 1995 by the
// ballast-lamp photometric factor. Keywords, TILT (skipped: how light depends on the burning position), lamps, sizes and watts have no
// effect, as EXT_lights_ies allows. Errors are of kind scene_invalid, "line N: what was found, what would be accepted".
[[nodiscard]] Result<Photometry> parse_ies(std::string_view text);

} // namespace kindling::gltf
