// The flags of `kindling view`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/view/command_words.h"
#include "renderer/view/view_state.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

// Flags of render that change pixels and that a page can do with.
const std::vector<std::string> kLiveFlags{"--view",
                                          "--exposure",
                                          "--ocio",
                                          "--seed",
                                          "--sampler",
                                          "--filter",
                                          "--filter-width",
                                          "--outliers",
                                          "--scene",
                                          "--variant",
                                          "--time",
                                          "--point-size",
                                          "--outlines",
                                          "--follow-links",
                                          "--camera",
                                          "--orbit",
                                          "--target",
                                          "--fov",
                                          "--backfaces",
                                          "--env",
                                          "--env-rotation",
                                          "--env-intensity",
                                          "--env-color",
                                          "--studio",
                                          "--light-radius",
                                          "--sun-angle",
                                          "--background",
                                          "--f-stop",
                                          "--focal-length",
                                          "--focus-distance",
                                          "--aperture-blades",
                                          "--aperture-rotation",
                                          "--anamorphic",
                                          "--cats-eye",
                                          "--shutter",
                                          "--shutter-angle",
                                          "--fps",
                                          "--integrator",
                                          "--max-bounces",
                                          "--max-diffuse-bounces",
                                          "--max-glossy-bounces",
                                          "--max-transmission-bounces",
                                          "--roulette-start",
                                          "--clamp-direct",
                                          "--clamp-indirect",
                                          "--caustics",
                                          "--light-paths",
                                          "--photons",
                                          "--environment-filter",
                                          "--manifold-samples",
                                          "--guiding",
                                          "--ao-distance",
                                          "--threads",
                                          "--accel",
                                          "--accel-quality",
                                          "--batch-size",
                                          "--texture-memory",
                                          "--quiet",
                                          "--verbose"};

// Flags that a command line with the same pixels does not need.
const std::vector<std::string> kNotPassedOn{"--listen", "--port", "--quiet", "--verbose", "--threads"};

} // namespace

void add_view_flags(FlagSet& flags, LiveOptions& o) {
  flags.group("Server");
  flags.value("--listen", "ADDRESS",
              fmt::format("Address of this machine to listen on; others than 127.0.0.1 let other machines connect [{}]",
                          o.listen),
              [&o](auto text) { return set_text(text, o.listen); });
  flags.value(
      "--port", "N",
      fmt::format("Port to listen on, 0: any free one [{}, or any free one if that is taken]", kDefaultViewPort),
      [&o](auto text) { return store(parse_integer(text, 0, 65535), o.port); });
  flags.group("Image");
  flags.value("--size", "WxH", "Image size in pixels [that of the page]",
              [&o](auto text) { return store(parse_size(text), o.image.size_px); });
  flags.value(
      "--spp", "N",
      fmt::format("Samples per pixel with which an image is complete, at most {} [{}]", kMaxViewSpp, ViewState().spp),
      [&o](auto text) { return store(parse_integer(text, 1, kMaxViewSpp), o.image.spp); });
  flags.only(kLiveFlags);
  add_render_flags(flags, o.image);
  flags.only({});
}

Result<void> check_view_flags(const FlagSet& flags, LiveOptions& o) {
  if (o.image.scene_file.empty())
    return usage_error("no scene; use 'kindling view SCENE [flags]' with a .gltf or .glb file");
  if (Result<void> checked = check_render_flags(flags, o.image); !checked.ok()) return checked;
  if (!o.image.exposure_stops) return usage_error("--exposure: 'auto' has no meaning here; use a number of stops");
  std::vector<std::string> except = written_flags();
  except.insert(except.end(), kNotPassedOn.begin(), kNotPassedOn.end());
  o.passed_on = flags.given_words(except);
  return {};
}

} // namespace kindling::app
