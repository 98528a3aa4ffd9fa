// The flags of files of pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/image_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

namespace kindling::app {

void add_output_flag(FlagSet& flags, RenderOptions& o, const std::string& default_name) {
  flags.repeated(
      "-o,--output", "FILE",
      fmt::format(
          "Where to write: .png, .jpg, .exr, or .kacc for all sums of samples; - is standard output as PNG, exr:- "
          "and jpg:- as these; several are allowed [{}]",
          default_name),
      [&o](auto text) {
        std::filesystem::path path;
        Result<void> set = set_path(text, path);
        if (set.ok()) o.outputs.push_back(path);
        return set;
      });
}

void add_image_format_flags(FlagSet& flags, RenderOptions& o) {
  flags.toggle("--exr-float", "EXR colors in 32 bits [16]", o.exr_half, false);
  flags.value("--png-bits", "8|16", "Bits of a PNG's channels [8]", [&o](auto text) -> Result<void> {
    if (text != "8" && text != "16") return unknown_name("depth", text, {"8", "16"});
    o.png_bits = text == "8" ? 8 : 16;
    return {};
  });
  flags.value("--jpeg-quality", "N", fmt::format("Quality of JPEG images, 1 to 100 [{}]", o.jpeg_quality),
              [&o](auto text) { return store(parse_integer(text, 1, 100), o.jpeg_quality); });
  flags.value("--view", "NAME", "OpenColorIO view of PNG and JPEG images [the configuration's default]",
              [&o](auto text) { return set_text(text, o.view); });
  flags.value("--exposure", "STOPS", "Multiply PNG and JPEG images by 2^STOPS before the view [0]",
              [&o](auto text) { return store(parse_number(text, -64.0, 64.0), o.exposure_stops); });
  flags.value("--ocio", "CONFIG", "OpenColorIO configuration [$OCIO, else the built-in one]",
              [&o](auto text) { return set_text(text, o.ocio_config); });
}

} // namespace kindling::app
