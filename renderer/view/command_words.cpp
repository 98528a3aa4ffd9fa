// Settings of a frame as flags.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/command_words.h"

#include <fmt/format.h>

#include <optional>

namespace kindling {

namespace {

// Collects flags with their values.
class Words {
 public:
  explicit Words(std::vector<std::string> words) : words_(std::move(words)) {}

  void add(const char* flag, std::string value) {
    if (value.starts_with('-')) { // which would be read as a flag
      words_.push_back(fmt::format("{}={}", flag, value));
      return;
    }
    words_.emplace_back(flag);
    words_.push_back(std::move(value));
  }
  template <typename T>
  void add(const char* flag, const std::optional<T>& value) {
    if (value) add(flag, fmt::format("{}", *value)); // the shortest text that gives the same bits
  }
  void add_text(const char* flag, const std::string& text) {
    if (!text.empty()) add(flag, text);
  }
  void add(const char* flag, const V3f& value) { add(flag, fmt::format("{},{},{}", value.x, value.y, value.z)); }

  [[nodiscard]] std::vector<std::string> take() { return std::move(words_); }

 private:
  std::vector<std::string> words_;
};

void add_camera(const ImageSettings& image, Words& words) {
  words.add_text("--camera", image.camera);
  if (image.orbit) {
    words.add("--orbit", *image.orbit);
    words.add("--orthographic", image.orthographic_m);
    words.add("--target", image.target);
  }
  if (image.orbit && image.turn) {
    words.add("--turn", fmt::format("{}", image.turn->angle_deg));
    words.add("--orbit-axis", image.turn->axis);
  }
  words.add("--fov", image.yfov_deg);
  const LensOptions& lens = image.lens;
  if (lens.pinhole) words.add("--f-stop", "none");
  words.add("--f-stop", lens.f_stop);
  words.add("--focal-length", lens.focal_length_mm);
  words.add("--focus-distance", lens.focus_distance_m);
  if (lens.focus_pixel) words.add("--focus-pixel", fmt::format("{},{}", lens.focus_pixel->x, lens.focus_pixel->y));
  words.add("--aperture-blades", lens.blades);
  words.add("--aperture-rotation", lens.rotation_deg);
  words.add("--anamorphic", lens.anamorphic_ratio);
  words.add("--cats-eye", lens.cats_eye);
}

} // namespace

const std::vector<std::string>& written_flags() {
  static const std::vector<std::string> flags{"--size",
                                              "--scene",
                                              "--variant",
                                              "--time",
                                              "--camera",
                                              "--orbit",
                                              "--orthographic",
                                              "--turn",
                                              "--orbit-axis",
                                              "--target",
                                              "--fov",
                                              "--f-stop",
                                              "--focal-length",
                                              "--focus-distance",
                                              "--focus-pixel",
                                              "--aperture-blades",
                                              "--aperture-rotation",
                                              "--anamorphic",
                                              "--cats-eye",
                                              "--backfaces",
                                              "--studio",
                                              "--spp",
                                              "--planned-spp",
                                              "--seed",
                                              "--guiding",
                                              "--path-reuse",
                                              "--aov",
                                              "--denoise",
                                              "--view",
                                              "--exposure"};
  return flags;
}

std::vector<std::string> command_words(const LinearFrame& frame, const ViewState& display,
                                       const std::filesystem::path& scene_file,
                                       const std::vector<std::string>& passed_on, bool denoised) {
  const ImageSettings& image = frame.image;
  std::vector<std::string> begin{"kindling", "render", scene_file.string()};
  begin.insert(begin.end(), passed_on.begin(), passed_on.end());
  Words words(std::move(begin));
  words.add("--size", fmt::format("{}x{}", frame.size_px.x, frame.size_px.y));
  words.add_text("--scene", frame.world.scene_name);
  words.add_text("--variant", frame.world.variant_name);
  words.add("--time", image.time_s);
  add_camera(image, words);
  if (image.backfaces != Backfaces::automatic) words.add("--backfaces", std::string(backfaces_name(image.backfaces)));
  if (frame.world.studio != Studio::automatic) words.add("--studio", std::string(studio_name(frame.world.studio)));
  words.add("--spp", image.spp);
  words.add("--planned-spp", image.planned_spp);
  if (image.seed != 0) words.add("--seed", fmt::format("{}", image.seed));
  if (image.guiding != Guiding::automatic) words.add("--guiding", std::string(guiding_name(image.guiding)));
  if (!image.chooses_path_reuse) words.add("--path-reuse", fmt::format("{}", image.integrator.path_reuse));
  std::string aovs;
  for (const AovInfo& info : kAovs)
    if (image.aovs.contains(info.aov)) aovs += (aovs.empty() ? "" : ",") + std::string(info.name);
  words.add_text("--aov", aovs);
  if (denoised) words.add("--denoise", std::string(denoising_name(Denoising::fast)));
  words.add_text("--view", display.display_view);
  if (display.exposure_stops != 0.0) words.add("--exposure", fmt::format("{}", display.exposure_stops));
  words.add("-o", frame_file_name(frame, scene_file, aovs.empty() ? "png" : "exr"));
  return words.take();
}

std::string frame_file_name(const LinearFrame& frame, const std::filesystem::path& scene_file, const char* extension) {
  return fmt::format("{}-{}spp.{}", scene_file.stem().string(), frame.image.samples_per_pixel(), extension);
}

} // namespace kindling
