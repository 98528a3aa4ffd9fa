// Versions of the libraries that read and write images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kindling {

// Returns names and versions. Those of OpenEXR and OpenColorIO are of the libraries that are loaded
// now, that of OpenImageIO, which is loaded only when it is needed, is the one that the program was
// built with.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> image_library_versions();

} // namespace kindling
