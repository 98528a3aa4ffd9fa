// Reads an image with light groups, mixes them and writes the result.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/relight/command_relight.h"

#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/denoise_image.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/finished_image.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/output/render_metadata.h"
#include "renderer/app/relight/light_layers.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/film/write_film.h"
#include "renderer/image/read_exr.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// Layers of one channel each, as read_exr() returns them.
void add_channels(const std::vector<std::string>& names, bool half, const std::vector<float>& values, ExrImage& image) {
  for (size_t c = 0; c < names.size(); ++c) {
    ExrLayer& layer = image.layers.emplace_back();
    layer.channel_names = {names[c]};
    layer.half = half;
    layer.values.resize(values.size() / names.size());
    for (size_t i = 0; i < layer.values.size(); ++i) layer.values[i] = values[i * names.size() + c];
  }
}

// The image of an accumulation, in full precision.
ExrImage image_of(const Accumulation& accumulation) {
  const PixelRect& crop = accumulation.identity.crop;
  const Film& whole = accumulation.state.film;
  const bool is_whole = whole.crop() == crop;
  const Film cut = is_whole ? Film(whole.size_px(), {}, {}) : whole.cut(crop);
  const Film& film = is_whole ? whole : cut;
  ExrImage image;
  image.display_size_px = film.size_px();
  image.data_min_px = crop.min;
  image.data_max_px = crop.max;
  add_channels({"R", "G", "B", "A"}, true, film.resolve_rgba(), image);
  for (const AovInfo& info : kAovs)
    if (info.aov != Aov::beauty && info.aov != Aov::alpha && film.aovs().contains(info.aov))
      add_channels(channel_names(info.aov), info.half, film.resolve(info.aov), image);
  for (size_t i = 0; i < film.light_groups().size(); ++i)
    add_channels(light_group_channels(film.light_groups()[i]), true, film.resolve_light_group(i), image);
  const ImageMetadata metadata = metadata_of(accumulation);
  image.text = metadata.text;
  image.numbers = metadata.numbers;
  image.integers = metadata.integers;
  image.matrices["worldToCamera"] = metadata.world_to_camera;
  image.matrices["worldToNDC"] = metadata.world_to_ndc;
  return image;
}

class RelightCommand {
 public:
  RelightCommand(const RelightOptions& options, const std::string& command_line, Console& console)
      : options_(options), command_line_(command_line), console_(console), signals_(cancel_),
        display_(console, options.image.progress, {std::nullopt, &signals_}) {}

  Result<int> run() {
    const Result<std::vector<fs::path>> outputs = choose_outputs(options_.image);
    if (!outputs.ok()) return outputs.error();
    Result<DisplayTransform> view = choose_view(options_.image);
    if (!view.ok()) return view.error();
    const std::vector<NamedFile> written = files_written(options_.image, outputs.value());
    for (const std::vector<NamedFile>& read :
         {with_role("the image", std::span(&options_.file, 1)), with_role(kViewFile, view.value().files())})
      if (Result<void> remain = check_inputs_remain(written, read); !remain.ok()) return remain.error();

    if (Result<void> done = read(); !done.ok()) return done.error();
    const Result<DenoisableLayers> color = find_layers(image_);
    if (!color.ok()) return in_file(color.error());
    const std::vector<LightLayer> groups = find_light_layers(image_);
    if (groups.empty())
      return Error{ErrorKind::usage,
                   options_.file.string() + ": it has no light groups; render it with --light-groups"};
    const Result<std::vector<Rgb>> factors = factors_of(groups, options_.factors, options_.others);
    if (!factors.ok()) return factors.error();
    if (image_.text.contains("kindling:denoised") && options_.image.denoising == Denoising::off)
      console_.note("its color was denoised, its light groups were not; --denoise denoises the new image");
    relight(image_, color.value().color, groups, factors.value());
    image_.text["kindling:relitBy"] = command_line_;
    image_.text.erase("kindling:denoised");

    if (Result<bool> denoised = denoise(); !denoised.ok())
      return denoised.error();
    else if (!denoised.value() || signals_.received() != 0) {
      console_.note("interrupted: nothing was written");
      return exit_code_of_signal(signals_.received());
    }
    choose_precision();
    const FinishedImage finished{rgba_, size_px(), {{"kindling:relitBy", command_line_}}, [this] { return image_; }};
    if (Result<void> done =
            write_finished_image(outputs.value(), finished, options_.image, std::move(view).value(), console_);
        !done.ok())
      return done.error();
    console_.line(describe(groups, factors.value()));
    return kExitOk;
  }

 private:
  [[nodiscard]] V2i size_px() const { return image_.data_max_px - image_.data_min_px; }
  [[nodiscard]] Error in_file(const Error& error) const {
    return {error.kind, options_.file.string() + ": " + error.message};
  }

  static std::string describe(const std::vector<LightLayer>& groups, const std::vector<Rgb>& factors) {
    std::string text = "relit:";
    for (size_t i = 0; i < groups.size(); ++i) {
      const Rgb& f = factors[i];
      text += f.x == f.y && f.y == f.z ? fmt::format(" {} {:g}", groups[i].group, f.x)
                                       : fmt::format(" {} {:g},{:g},{:g}", groups[i].group, f.x, f.y, f.z);
      text += i + 1 < groups.size() ? "," : "";
    }
    return text;
  }

  Result<void> read() {
    if (!is_accumulation(options_.file)) {
      Result<ExrImage> image = read_exr(options_.file);
      if (!image.ok()) return image.error();
      image_ = std::move(image).value();
      return {};
    }
    Result<Accumulation> accumulation = read_accumulation(options_.file);
    if (!accumulation.ok()) return accumulation.error();
    image_ = image_of(accumulation.value());
    return {};
  }

  // The layers of color, by their indices after relight().
  [[nodiscard]] std::vector<float> rgba() const {
    const DenoisableLayers layers = find_layers(image_).value();
    std::vector<float> rgba(4 * image_.layers[layers.color[0]].values.size(), 1.0f);
    for (size_t i = 0; i < rgba.size() / 4; ++i) {
      for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = image_.layers[layers.color[c]].values[i];
      if (layers.alpha) rgba[4 * i + 3] = image_.layers[*layers.alpha].values[i];
    }
    return rgba;
  }

  // Returns false if a signal ended it.
  Result<bool> denoise() {
    rgba_ = rgba();
    if (options_.image.denoising == Denoising::off) return true;
    const DenoisableLayers layers = find_layers(image_).value();
    std::vector<float> albedo, normal;
    if (layers.albedo) albedo = interleave(image_, *layers.albedo);
    if (layers.normal) normal = interleave(image_, *layers.normal);
    if (!layers.albedo)
      console_.warning(fmt::format("{}: has no albedo, so that textures and edges blur", options_.file.string()));
    Result<std::optional<DenoisedImage>> denoised = denoise_image(
        {size_px(), rgba_, albedo, normal}, options_.image.denoising, options_.image.threads, display_, &cancel_);
    if (!denoised.ok()) return denoised.error();
    if (!denoised.value()) return false;
    constexpr std::array<const char*, 3> kNoisy{"noisy.R", "noisy.G", "noisy.B"};
    for (size_t c = 0; c < 3; ++c) {
      ExrLayer noisy = image_.layers[layers.color[c]];
      noisy.channel_names = {kNoisy[c]};
      image_.layers.push_back(std::move(noisy));
      std::vector<float>& values = image_.layers[layers.color[c]].values;
      for (size_t i = 0; i < values.size(); ++i) values[i] = denoised.value()->rgba[4 * i + c];
    }
    rgba_ = std::move(denoised.value()->rgba);
    image_.text["kindling:denoised"] = denoised.value()->by;
    return true;
  }

  // Colors of EXR files are half or float as --exr-float says; values beyond the largest half are
  // clamped, as renders are written.
  void choose_precision() {
    constexpr float kLargestHalf = 65504.0f;
    for (ExrLayer& layer : image_.layers) {
      layer.half = layer.half && options_.image.exr_half;
      if (layer.half)
        for (float& value : layer.values) value = std::clamp(value, -kLargestHalf, kLargestHalf);
    }
  }

  const RelightOptions& options_;
  const std::string& command_line_;
  Console& console_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  ExrImage image_;
  std::vector<float> rgba_; // what is shown
};

} // namespace

Result<int> run_relight(const RelightOptions& options, const std::string& command_line, Console& console) {
  return RelightCommand(options, command_line, console).run();
}

} // namespace kindling::app
