// Reads EXR images, blends frames, denoises colors, writes them with their other layers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/denoise/command_denoise.h"

#include "renderer/app/denoise/denoisable_image.h"
#include "renderer/app/merge/command_merge.h"
#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/denoise_image.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/finished_image.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/terminal/stopwatch.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <system_error>
#include <utility>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// A file, and what is made of it.
struct Job {
  fs::path file;
  std::vector<fs::path> outputs;
  int frame = 0; // its number; without --frames of no meaning
};

class DenoiseCommand {
 public:
  DenoiseCommand(const DenoiseOptions& options, const std::string& command_line, Console& console)
      : options_(options), command_line_(command_line), console_(console), signals_(cancel_),
        display_(console, options.image.progress, {std::nullopt, &signals_}) {}

  Result<int> run() {
    Result<DisplayTransform> view = choose_view(options_.image);
    if (!view.ok()) return view.error();
    Result<std::vector<Job>> jobs = find_jobs();
    if (!jobs.ok()) return jobs.error();
    if (Result<void> remain = check_files(jobs.value(), view.value()); !remain.ok()) return remain.error();
    for (size_t i = 0; i < jobs.value().size(); ++i) {
      const Result<bool> done = run(jobs.value()[i]);
      if (!done.ok()) return done.error();
      const bool more = i + 1 < jobs.value().size();
      if (done.value() && !(more && signals_.received() != 0)) continue;
      console_.note(options_.frames.empty() ? "interrupted: nothing was written"
                                            : "interrupted: later frames were not denoised");
      return exit_code_of_signal(signals_.received());
    }
    return kExitOk;
  }

 private:
  [[nodiscard]] Result<std::vector<Job>> find_jobs() const {
    if (options_.frames.empty()) {
      Result<std::vector<fs::path>> outputs = choose_outputs(options_.image);
      if (!outputs.ok()) return outputs.error();
      return std::vector<Job>{{options_.file, std::move(outputs).value(), 0}};
    }
    std::vector<Job> jobs;
    for (const int frame : options_.frames) {
      RenderOptions image = options_.image;
      for (fs::path& output : image.outputs) output = name_of_frame(output, frame);
      Result<std::vector<fs::path>> outputs = choose_outputs(image);
      if (!outputs.ok()) return outputs.error();
      jobs.push_back({name_of_frame(options_.file, frame), std::move(outputs).value(), frame});
    }
    return jobs;
  }

  // Nothing that any frame needs is overwritten.
  [[nodiscard]] Result<void> check_files(std::span<const Job> jobs, const DisplayTransform& view) const {
    std::vector<fs::path> read;
    std::vector<NamedFile> written;
    for (const Job& job : jobs) {
      for (int number = job.frame - neighbors(); number <= job.frame + neighbors(); ++number)
        read.push_back(options_.frames.empty() ? job.file : name_of_frame(options_.file, number));
      for (NamedFile& file : files_written(options_.image, job.outputs)) written.push_back(std::move(file));
    }
    std::sort(read.begin(), read.end());
    read.erase(std::unique(read.begin(), read.end()), read.end());
    for (const std::vector<NamedFile>& files : {with_role("the image", read), with_role(kViewFile, view.files())})
      if (Result<void> remain = check_inputs_remain(written, files); !remain.ok()) return remain;
    return {};
  }

  [[nodiscard]] int neighbors() const { return options_.frames.empty() ? 0 : options_.neighbors; }

  // Returns false, and writes nothing, after a signal.
  [[nodiscard]] Result<bool> run(const Job& job) {
    const Clock::time_point start = Clock::now();
    const Result<std::shared_ptr<const DenoisableImage>> read = frame(job.file);
    if (!read.ok()) return read.error();
    const DenoisableImage& image = *read.value();
    Result<BlendedFrame> blended = blend(job, read.value());
    if (!blended.ok()) return blended.error();
    if (image.albedo.empty())
      console_.warning(fmt::format("{}: has no albedo, so that textures and edges blur", job.file.string()));
    Result<std::optional<DenoisedImage>> denoised =
        denoise_image({image.size_px(), blended.value().rgba, image.albedo, image.normal}, options_.image.denoising,
                      options_.image.threads, display_, &cancel_);
    if (!denoised.ok()) return denoised.error();
    if (!denoised.value() || signals_.received() != 0) return false;
    Result<DisplayTransform> view = choose_view(options_.image);
    if (!view.ok()) return view.error();
    const V2i size = image.size_px();
    const std::string blend_note =
        neighbors() > 0 ? fmt::format(", blended from {:.1f} frames,", blended.value().mean_frames) : "";
    const std::string line = fmt::format("denoised {}x{} {}{} by {} in {}", size.x, size.y, describe_guides(image),
                                         blend_note, denoised.value()->by, format_seconds(seconds_since(start)));
    const FinishedImage finished{denoised.value()->rgba, size, {{"kindling:denoised", denoised.value()->by}}, [&] {
                                   return denoised_image(image, *denoised.value());
                                 }};
    if (Result<void> done =
            write_finished_image(job.outputs, finished, options_.image, std::move(view).value(), console_);
        !done.ok())
      return done.error();
    console_.line(line);
    return true;
  }

  // A file, read once for all frames that are blended with it.
  Result<std::shared_ptr<const DenoisableImage>> frame(const fs::path& file) {
    if (const auto known = frames_.find(file); known != frames_.end()) return known->second;
    Result<DenoisableImage> image = read_denoisable(file);
    if (!image.ok()) return image.error();
    return frames_[file] = std::make_shared<const DenoisableImage>(std::move(image).value());
  }

  // Blends a frame with those neighbors that exist.
  Result<BlendedFrame> blend(const Job& job, const std::shared_ptr<const DenoisableImage>& center) {
    if (neighbors() == 0) return BlendedFrame{center->rgba, 1.0};
    if (center->motion.empty())
      return usage_error(
          fmt::format("{}: has no motion vectors to blend frames along; render with --aov vector, or use "
                      "--neighbors 0",
                      job.file.string()));
    std::map<fs::path, std::shared_ptr<const DenoisableImage>> used{{job.file, center}};
    std::vector<NoisyFrame> frames{center->as_frame()};
    size_t before = 0;
    for (const int step : {-1, 1})
      for (int i = 1; i <= neighbors(); ++i) {
        const fs::path file = name_of_frame(options_.file, job.frame + step * i);
        std::error_code ignored;
        if (!fs::exists(file, ignored)) break;
        const Result<std::shared_ptr<const DenoisableImage>> read = frame(file);
        if (!read.ok()) return read.error();
        const DenoisableImage& other = *read.value();
        const bool same_place =
            other.size_px() == center->size_px() && other.image.data_min_px == center->image.data_min_px;
        if (!same_place || other.motion.empty())
          return usage_error(fmt::format("{}: cannot be blended with {}: {}", job.file.string(), file.string(),
                                         other.motion.empty() ? "it has no motion vectors" : "it has other pixels"));
        used[file] = read.value();
        frames.insert(step < 0 ? frames.begin() : frames.end(), other.as_frame());
        before += step < 0 ? 1 : 0;
      }
    frames_ = std::move(used); // earlier ones are not needed again
    return blend_frames(frames, before);
  }

  [[nodiscard]] static std::string describe_guides(const DenoisableImage& image) {
    if (!image.albedo.empty() && !image.normal.empty()) return "with albedo and normal";
    return image.albedo.empty() ? "without albedo and normal" : "with albedo";
  }

  // Puts the denoised color in the place of the noisy one, which becomes the layer "noisy".
  [[nodiscard]] ExrImage denoised_image(const DenoisableImage& source, const DenoisedImage& denoised) const {
    ExrImage image = source.image;
    for (size_t c = 0; c < 3; ++c) {
      if (!source.layers.noisy) {
        constexpr std::array<const char*, 3> kNoisy{"noisy.R", "noisy.G", "noisy.B"};
        ExrLayer noisy = source.image.layers[source.layers.color[c]];
        noisy.channel_names = {kNoisy[c]};
        image.layers.push_back(std::move(noisy));
      }
      ExrLayer& shown = image.layers[source.layers.color[c]];
      shown.half = options_.image.exr_half && shown.half;
      for (size_t i = 0; i < shown.values.size(); ++i) shown.values[i] = denoised.rgba[4 * i + c];
    }
    image.text["kindling:denoised"] = denoised.by;
    image.text["kindling:denoisedBy"] = command_line_;
    return image;
  }

  const DenoiseOptions& options_;
  const std::string& command_line_;
  Console& console_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  std::map<fs::path, std::shared_ptr<const DenoisableImage>> frames_;
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
