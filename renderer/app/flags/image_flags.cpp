// The flags of output images: names, formats, view.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/image_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

namespace kindling::app {

void add_output_flag(FlagSet& flags, RenderOptions& o, const std::string& default_name) {
  flags.repeated(
      "-o,--output", "FILE",
      fmt::format("Output file: .png, .jpg, .exr, or .kacc for the sums of all samples; - is standard output as PNG, "
                  "exr:- and jpg:- as EXR and JPEG; may be given several times [{}]",
                  default_name),
      [&o](auto text) {
        std::filesystem::path path;
        Result<void> set = set_path(text, path);
        if (set.ok()) o.outputs.push_back(path);
        return set;
      });
}

void add_image_format_flags(FlagSet& flags, RenderOptions& o) {
  flags.toggle("--exr-float", fmt::format("Write EXR colors in 32 bits [{} bits]", o.exr_half ? 16 : 32), o.exr_half,
               false);
  flags.value("--png-bits", "8|16", fmt::format("Bits per channel of PNG files [{}]", o.png_bits),
              [&o](auto text) -> Result<void> {
                if (text != "8" && text != "16") return unknown_name("depth", text, {"8", "16"});
                o.png_bits = text == "8" ? 8 : 16;
                return {};
              });
  flags.value("--jpeg-quality", "N", fmt::format("Quality of JPEG files, 1 to 100 [{}]", o.jpeg_quality),
              [&o](auto text) { return store(parse_integer(text, 1, 100), o.jpeg_quality); });
  flags.value(
      "--cryptomatte-levels", "N",
      fmt::format("Objects and materials of a pixel that Cryptomatte layers distinguish, 1 to {}, rounded up to "
                  "an even number [{}]",
                  kMaxMatteLevels, o.matte_levels),
      [&o](auto text) { return store(parse_integer(text, 1, kMaxMatteLevels), o.matte_levels); });
  flags.value(
      "--denoise", "off|fast|best",
      fmt::format(
          "Denoise images with Open Image Denoise, for which 'kindling --version' names the script that installs it; "
          "best takes longer [{}]",
          denoising_name(o.denoising)),
      [&o](auto text) {
        return choose(denoising_from_name(text), o.denoising, "way of denoising", text, {"off", "fast", "best"});
      });
  flags.value("--view", "NAME", "OpenColorIO view of PNG and JPEG files [the configuration's default]",
              [&o](auto text) { return set_text(text, o.view); });
  flags.value("--exposure", "STOPS|auto",
              fmt::format("Exposure of PNG and JPEG files: a factor of 2^STOPS before the view, or auto: a middle gray "
                          "for the mean of the image's log luminance [{:g}]",
                          *o.exposure_stops),
              [&o](auto text) -> Result<void> {
                if (text != "auto") return store(parse_number(text, -64.0, 64.0), o.exposure_stops);
                o.exposure_stops.reset();
                return {};
              });
  flags.value("--ocio", "CONFIG", "OpenColorIO configuration [$OCIO, else the built-in one]",
              [&o](auto text) { return set_text(text, o.ocio_config); });
}

void add_finished_image_flags(FlagSet& flags, RenderOptions& o, const std::string& default_name) {
  add_output_flag(flags, o, default_name);
  add_image_format_flags(flags, o);
  flags.group("Machine");
  flags.value("--threads", "N", fmt::format("Threads; 0: all cores [{}]", o.threads),
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  flags.group("Reports");
  flags.toggle("-q,--quiet", "Print errors only", o.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.verbose);
}

} // namespace kindling::app
