// The entry point of all image decoders.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/decode_input.h"

#include "renderer/image/decode_image.h"

namespace kindling::fuzz {

void decode_to_the_end(Bytes bytes) {
  const ImageLimits limits{.max_side_px = 32768, .max_pixels = 1 << 20};
  const Result<Image> image = decode_image(bytes, "input", limits);
  if (!image) {
    require_good_message(image.error(), "input: ");
    return;
  }
  const Image& decoded = image.value();
  require(decoded.width >= 1 && decoded.height >= 1, "an image has pixels");
  require(decoded.pixels.size() == decoded.byte_count(), "an image has the bytes of its size");
}

} // namespace kindling::fuzz
