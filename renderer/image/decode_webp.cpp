// WebP decoder based on libwebp.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"

#include <webp/decode.h>

namespace kindling::image_detail {

namespace {

const char* describe(VP8StatusCode status) {
  switch (status) {
  case VP8_STATUS_OUT_OF_MEMORY: return "not enough memory";
  case VP8_STATUS_BITSTREAM_ERROR: return "corrupt data";
  case VP8_STATUS_UNSUPPORTED_FEATURE: return "it uses an unsupported feature";
  case VP8_STATUS_NOT_ENOUGH_DATA:
  case VP8_STATUS_SUSPENDED: return "the file ends early";
  default: return "corrupt header";
  }
}

} // namespace

Result<Image> decode_webp(Bytes bytes, const ImageLimits& limits) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPDecoderConfig config;
  if (!WebPInitDecoderConfig(&config)) return detail_error("the version of libwebp does not match its header");
  if (const auto status = WebPGetFeatures(data, bytes.size(), &config.input); status != VP8_STATUS_OK) {
    return detail_error(describe(status));
  }
  if (config.input.has_animation) return detail_error("it is an animation; use a still image");
  if (const auto error = check_size(config.input.width, config.input.height, limits)) return detail_error(*error);

  Image image = make_image(config.input.width, config.input.height, config.input.has_alpha ? 4 : 3, PixelType::u8);
  config.output.colorspace = config.input.has_alpha ? MODE_RGBA : MODE_RGB; // both with straight alpha
  config.output.is_external_memory = 1;
  config.output.u.RGBA.rgba = reinterpret_cast<uint8_t*>(image.pixels.data());
  config.output.u.RGBA.stride = image.width * image.channels;
  config.output.u.RGBA.size = image.pixels.size();
  const VP8StatusCode status = WebPDecode(data, bytes.size(), &config);
  WebPFreeDecBuffer(&config.output);
  if (status != VP8_STATUS_OK) return detail_error(describe(status));
  return image;
}

} // namespace kindling::image_detail
