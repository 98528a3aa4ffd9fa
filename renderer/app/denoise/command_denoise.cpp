// Reads an EXR image, denoises its color, writes it with its other layers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/denoise/command_denoise.h"

#include "renderer/app/denoise/exr_layers.h"
#include "renderer/app/merge/command_merge.h"
#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/denoise_image.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/finished_image.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/terminal/stopwatch.h"
#include "renderer/app/text/text_format.h"
#include "renderer/image/read_exr.h"

#include <fmt/format.h>

#include <array>
#include <span>
#include <utility>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

class DenoiseCommand {
 public:
  DenoiseCommand(const DenoiseOptions& options, const std::string& command_line, Console& console)
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

    Result<ExrImage> image = read_exr(options_.file);
    if (!image.ok()) return image.error();
    image_ = std::move(image).value();
    Result<DenoisableLayers> layers = find_layers(image_);
    if (!layers.ok()) return Error{layers.error().kind, options_.file.string() + ": " + layers.error().message};
    layers_ = std::move(layers).value();

    const Clock::time_point start = Clock::now();
    Result<std::optional<DenoisedImage>> denoised = denoise();
    if (!denoised.ok()) return denoised.error();
    if (!denoised.value() || signals_.received() != 0) {
      console_.note("interrupted: nothing was written");
      return exit_code_of_signal(signals_.received());
    }
    denoised_ = *std::move(denoised).value();
    const V2i size = size_px();
    const std::string line = fmt::format("denoised {}x{} {} by {} in {}", size.x, size.y, describe_guides(),
                                         denoised_.by, format_seconds(seconds_since(start)));
    const FinishedImage finished{
        denoised_.rgba, size_px(), {{"kindling:denoised", denoised_.by}}, [this] { return denoised_image(); }};
    if (Result<void> done =
            write_finished_image(outputs.value(), finished, options_.image, std::move(view).value(), console_);
        !done.ok())
      return done.error();
    console_.line(line);
    return kExitOk;
  }

 private:
  [[nodiscard]] V2i size_px() const { return image_.data_max_px - image_.data_min_px; }

  [[nodiscard]] std::string describe_guides() const {
    if (layers_.albedo && layers_.normal) return "with albedo and normal";
    return layers_.albedo ? "with albedo" : "without albedo and normal";
  }

  Result<std::optional<DenoisedImage>> denoise() {
    const std::vector<float> color = interleave(image_, layers_.noisy.value_or(layers_.color));
    std::vector<float> rgba(color.size() / 3 * 4, 1.0f), albedo, normal;
    for (size_t i = 0; i < color.size() / 3; ++i) {
      for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = color[3 * i + c];
      if (layers_.alpha) rgba[4 * i + 3] = image_.layers[*layers_.alpha].values[i];
    }
    if (layers_.albedo) albedo = interleave(image_, *layers_.albedo);
    if (layers_.normal) normal = interleave(image_, *layers_.normal);
    if (!layers_.albedo)
      console_.warning(fmt::format("{}: has no albedo, so that textures and edges blur", options_.file.string()));
    return denoise_image({size_px(), rgba, albedo, normal}, options_.image.denoising, options_.image.threads, display_,
                         &cancel_);
  }

  // Puts the denoised color in the place of the noisy one, which becomes the layer "noisy".
  [[nodiscard]] ExrImage denoised_image() const {
    ExrImage image = image_;
    for (size_t c = 0; c < 3; ++c) {
      if (!layers_.noisy) {
        constexpr std::array<const char*, 3> kNoisy{"noisy.R", "noisy.G", "noisy.B"};
        ExrLayer noisy = image_.layers[layers_.color[c]];
        noisy.channel_names = {kNoisy[c]};
        image.layers.push_back(std::move(noisy));
      }
      ExrLayer& shown = image.layers[layers_.color[c]];
      shown.half = options_.image.exr_half && shown.half;
      for (size_t i = 0; i < shown.values.size(); ++i) shown.values[i] = denoised_.rgba[4 * i + c];
    }
    image.text["kindling:denoised"] = denoised_.by;
    image.text["kindling:denoisedBy"] = command_line_;
    return image;
  }

  const DenoiseOptions& options_;
  const std::string& command_line_;
  Console& console_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  ExrImage image_;
  DenoisableLayers layers_{};
  DenoisedImage denoised_;
};

} // namespace

Result<int> run_denoise(const DenoiseOptions& options, const std::string& command_line, Console& console) {
  if (!is_accumulation(options.file)) return DenoiseCommand(options, command_line, console).run();
  MergeOptions merge;
  merge.parts = {options.file};
  merge.allow_missing = true;
  merge.image = options.image;
  return run_merge(merge, command_line, console);
}

} // namespace kindling::app
