// The process-wide settings of OpenImageIO.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_setup.h"

#include <OpenImageIO/imageio.h>

namespace kindling::image_detail {

void prepare_oiio() {
  static const bool once = OIIO::attribute("threads", 1);
  static_cast<void>(once);
}

} // namespace kindling::image_detail
