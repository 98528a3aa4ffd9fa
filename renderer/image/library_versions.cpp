// Versions of the image libraries, from their own functions where they have one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/library_versions.h"

#include <OpenColorIO/OpenColorIO.h>
#include <openexr_base.h>

#include <fmt/format.h>

namespace kindling {

std::vector<std::pair<std::string, std::string>> image_library_versions() {
  int major = 0, minor = 0, patch = 0;
  exr_get_library_version(&major, &minor, &patch, nullptr);
  return {{"OpenEXR", fmt::format("{}.{}.{}", major, minor, patch)},
          {"OpenColorIO", OCIO_NAMESPACE::GetVersion()},
          {"OpenImageIO", KINDLING_OIIO_VERSION}};
}

} // namespace kindling
