// Checks names of output files, and writes images with their metadata.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/outputs.h"

#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/denoise_image.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/video.h"
#include "renderer/app/terminal/stopwatch.h"
#include "renderer/app/text/text_format.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/image/atomic_file.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/image_metadata.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>

#include <unistd.h>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

bool holds_layers(const fs::path& path) { return is_exr(path) || is_accumulation(path); }

bool wants_layers(AovSet aovs) {
  return aovs.has_mattes() || std::any_of(kAovs.begin(), kAovs.end(), [&](const AovInfo& info) {
           return info.aov != Aov::beauty && info.aov != Aov::alpha && aovs.contains(info.aov);
         });
}

} // namespace

bool is_exr(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".exr" || path == "exr:-";
}

bool is_accumulation(const fs::path& path) { return path.extension() == kAccumulationExtension; }

fs::path default_output(const RenderOptions& options) {
  const std::string stem = options.scene_file.stem().string() + (options.frames.numbers.empty() ? "" : "-####");
  const bool is_part = options.part.samples || options.part.tiles;
  return is_part ? part_file_name(stem, options.part) : stem + ".png";
}

Result<std::vector<fs::path>> choose_outputs(const RenderOptions& options) {
  std::vector<fs::path> outputs = options.outputs;
  if (outputs.empty() && !options.frames.video_only) outputs.push_back(default_output(options));
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (is_video(outputs[i]))
      return usage_error(
          fmt::format("--output: {}: a video needs frames; add --turntable or --frames", outputs[i].string()));
    if (const std::string sentence = is_accumulation(outputs[i]) ? "" : unsupported_output(outputs[i]);
        !sentence.empty())
      return Error{ErrorKind::usage, "--output: " + sentence};
    for (size_t j = 0; j < i; ++j)
      if (is_standard_output(outputs[i]) && is_standard_output(outputs[j]))
        return Error{ErrorKind::usage, fmt::format("--output: {} and {}: standard output takes one image",
                                                   outputs[j].string(), outputs[i].string())};
  }
  const bool has_layers = std::any_of(outputs.begin(), outputs.end(), holds_layers);
  if (wants_layers(options.aovs) && !has_layers)
    return usage_error(fmt::format("{}: only .exr files hold further layers; add -o FILE.exr",
                                   options.aovs.has_mattes() ? "--cryptomatte" : "--aov"));
  if (options.integrator.light_groups != LightGrouping::off && !has_layers)
    return usage_error("--light-groups: only .exr and .kacc files hold light groups; add -o FILE.exr");
  for (const fs::path& output : outputs) {
    if (is_standard_output(output)) {
      if (isatty(STDOUT_FILENO) != 0)
        return Error{ErrorKind::usage,
                     fmt::format("--output: {}: standard output is a terminal; redirect it to a file or a pipe",
                                 output.string())};
      continue;
    }
    if (Result<void> writable = check_writable(output); !writable.ok()) return writable.error();
  }
  if (options.denoising_of_images() != Denoising::off)
    if (const Result<Denoiser> denoiser = Denoiser::open(options.threads); !denoiser.ok()) return denoiser.error();
  if (!options.stats_file.empty())
    if (Result<void> writable = check_writable(options.stats_file); !writable.ok())
      return Error{writable.error().kind, "--stats: " + writable.error().message};
  if (options.checkpoint.enabled())
    if (Result<void> writable = check_checkpoint_file(options.checkpoint.file); !writable.ok()) return writable.error();
  const std::vector<NamedFile> written = files_written(options, outputs);
  if (Result<void> differ = check_outputs_differ(written); !differ.ok()) return differ.error();
  if (Result<void> remain = check_inputs_remain(written, files_read(options)); !remain.ok()) return remain.error();
  return outputs;
}

bool is_finished_image(const fs::path& path) {
  if (is_accumulation(path)) {
    const Result<AccumulationSummary> summary = read_accumulation_summary(path);
    if (!summary.ok()) return false;
    const Coverage& coverage = summary.value().coverage;
    for (size_t i = 0; i < coverage.block_count(); ++i)
      if (!coverage.complete(i, summary.value().identity.part)) return false;
    return coverage.block_count() > 0;
  }
  // At the front of EXR and PNG files, uncompressed; mattes have a manifest of all names.
  constexpr size_t kMaxMetadata = 1U << 24;
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  std::string front(kMaxMetadata, '\0');
  file.read(front.data(), static_cast<std::streamsize>(front.size()));
  front.resize(static_cast<size_t>(file.gcount()));
  return !front.empty() && front.find(kInterruptedKey) == std::string::npos;
}

ImageMetadata make_metadata(const RenderReport& r, const Camera& camera) {
  return make_metadata(MetadataFacts{.command_line = r.command_line,
                                     .scene_file = r.scene_file,
                                     .scene_hash = r.scene_hash,
                                     .integrator = r.integrator,
                                     .accelerator = r.accelerator_description,
                                     .seed = r.seed,
                                     .spp = r.statistics.samples_per_pixel,
                                     .spp_wanted = r.spp_wanted,
                                     .interrupted = r.interrupted,
                                     .threads = r.statistics.threads,
                                     .load_s = r.times.load_s,
                                     .build_s = r.times.build_s,
                                     .render_s = r.times.render_s},
                       camera);
}

namespace {

// Returns the first of two AOVs that the film has; empty if it has neither.
std::vector<float> resolve_either(const Film& film, Aov first, Aov second) {
  for (const Aov aov : {first, second})
    if (film.aovs().contains(aov)) return film.resolve(aov);
  return {};
}

// Denoises a film, guided by albedo and normal: of what mirrors and clear glass show, else of the
// first surfaces.
Result<std::optional<DenoisedImage>> denoise_film(const Film& film, const ImageWriting& writing) {
  const std::vector<float> rgba = film.resolve_rgba();
  const std::vector<float> albedo = resolve_either(film, Aov::denoising_albedo, Aov::albedo);
  const std::vector<float> normal = resolve_either(film, Aov::denoising_normal, Aov::normal);
  if (albedo.empty() || normal.empty())
    writing.console.warning("--denoise: the sums have no albedo and normal, so that textures and edges blur; render "
                            "with --denoise or --aov denoising_albedo,denoising_normal");
  return denoise_image({{film.crop().width(), film.crop().height()}, rgba, albedo, normal},
                       writing.options.denoising_of_images(), writing.options.threads, writing.display, writing.cancel);
}

} // namespace

WrittenImages write_images(const std::vector<fs::path>& outputs, const Film& film, const ImageWriting& writing) {
  const RenderOptions& options = writing.options;
  WrittenImages written;
  ImageMetadata metadata = writing.metadata;
  WriteOptions format{options.exr_half, options.png_bits, options.jpeg_quality, {}, options.matte_levels};
  DenoisedImage denoised;
  if (options.denoising_of_images() != Denoising::off && (!outputs.empty() || writing.frame)) {
    const Clock::time_point start = Clock::now();
    Result<std::optional<DenoisedImage>> done = denoise_film(film, writing);
    if (!done.ok()) { // the noisy image is worth more than none
      written.first_error = done.error();
    } else if (!done.value()) {
      written.denoising_cancelled = true;
      metadata.text[std::string(kInterruptedKey)] = "before it was denoised";
      writing.console.note("interrupted while denoising: the images are noisy");
    } else {
      denoised = *std::move(done).value();
      format.denoised = denoised.rgba;
      metadata.text["kindling:denoised"] = denoised.by;
    }
    written.denoise_s = seconds_since(start);
  }
  const Clock::time_point start = Clock::now();
  std::vector<fs::path> shown = outputs;
  if (writing.frame) shown.emplace_back("frame.png"); // has an exposure, too
  const std::optional<DisplayTransform> exposed = choose_exposure(options, film, metadata, shown, writing.console);
  const DisplayTransform& view = exposed ? *exposed : writing.view;
  writing.display.start_phase(Phase::write);
  const auto note_error = [&](const Error& error) {
    if (written.first_error)
      writing.console.error(error.message);
    else
      written.first_error = error;
  };
  for (size_t i = 0; i < outputs.size(); ++i) {
    const Result<void> done = write_film(outputs[i], film, view, metadata, format);
    if (!done.ok())
      note_error(done.error());
    else if (!is_standard_output(outputs[i]))
      written.files.push_back(outputs[i].string());
    writing.display.on_progress({.phase = Phase::write, .done = i + 1.0, .total = static_cast<double>(outputs.size())});
  }
  if (writing.frame)
    if (const Result<void> done =
            writing.frame(display_rgb8(film, view, format), V2i(film.crop().width(), film.crop().height()));
        !done.ok())
      note_error(done.error());
  writing.display.end_phase();
  written.write_s = seconds_since(start);
  return written;
}

double predict_write_s(const std::vector<fs::path>& outputs, const RenderOptions& options, const V2i& size_px) {
  // Measured for PNG, the slowest, on one core: the view transform and the compression.
  constexpr double kSecondsPerMegapixel = 0.3;
  const double megapixels = 1e-6 * static_cast<double>(size_px.x) * static_cast<double>(size_px.y);
  const Denoising denoising = options.denoising_of_images();
  return static_cast<double>(outputs.size()) * megapixels * kSecondsPerMegapixel +
         (denoising == Denoising::off ? 0.0 : predict_denoise_s(size_px, denoising, options.threads));
}

Result<void> write_text_file(const fs::path& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file.ok()) return file.error();
  file.value().write(text.data(), text.size());
  return file.value().commit();
}

} // namespace kindling::app
