// Module kindling_oiio, HDR part: decoding by OpenImageIO.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_interface.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <type_traits>

namespace {

// Decodes an image; returns an empty string on success, else the detail of the error.
std::string decode_hdr(const void* bytes, size_t size, int width, int height, float* pixels) {
  // One thread for each conversion, because the caller decodes images in parallel.
  static const bool once = OIIO::attribute("threads", 1);
  static_cast<void>(once);
  OIIO::Filesystem::IOMemReader memory(const_cast<void*>(bytes), size); // outlives the input
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create("hdr");
  if (!input || !input->set_ioproxy(&memory)) return "OpenImageIO was built without its reader of hdr";
  const auto error = [&input](const char* fallback) {
    const std::string message = input->geterror();
    return message.empty() ? std::string(fallback) : message;
  };
  OIIO::ImageSpec spec;
  if (!input->open("memory.hdr", spec, OIIO::ImageSpec())) return error("it cannot be opened");
  if (spec.width != width || spec.height != height || spec.nchannels != 3 || spec.format != OIIO::TypeFloat) {
    return "its header is contradictory";
  }
  if (!input->read_native_scanlines(0, 0, spec.y, spec.y + height, 0, pixels)) return error("corrupt data");
  return {};
}

} // namespace

extern "C" __attribute__((visibility("default"))) int kindling_oiio_decode_hdr_1(const void* bytes, size_t size,
                                                                                 int width, int height, float* pixels,
                                                                                 char* message, size_t message_size) {
  try {
    const std::string error = decode_hdr(bytes, size, width, height, pixels);
    if (error.empty()) return 0;
    std::snprintf(message, message_size, "%s", error.c_str());
  } catch (const std::exception& e) {
    std::snprintf(message, message_size, "%s", e.what());
  } catch (...) {
    std::snprintf(message, message_size, "unknown failure");
  }
  return 1;
}

static_assert(std::is_same_v<decltype(kindling_oiio_decode_hdr_1), kindling_oiio_decode_hdr_function>);
