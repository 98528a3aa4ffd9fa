// Harness: configurations of OpenColorIO, and names of them.
//
// The first line is the view; "path" there takes the rest as the name of a configuration.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/display_transform.h"
#include "tests/fuzz/fuzz_support.h"

#include <algorithm>
#include <array>
#include <string>

using namespace kindling;
using namespace kindling::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  std::string_view text = input_text(data, size);
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string first(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  DisplayOptions options;
  if (first == "path") {
    options.ocio_config = std::string(text);
  } else {
    options.view = first;
    options.ocio_config = folder.write("config.ocio", text).string();
  }
  static_cast<void>(DisplayTransform::list_views(options.ocio_config));
  const Result<DisplayTransform> transform = DisplayTransform::create(options);
  if (!transform) {
    require(!transform.error().message.empty(), "an error has a message");
    return 0;
  }
  std::array<float, 16> pixels = {0.18f, 0.18f, 0.18f, 1.0f, 0.0f, -1.0f, 1e30f, 0.5f, 10.0f, 0.0f, 0.0f, 1.0f};
  transform.value().apply(pixels);
  return 0;
}
