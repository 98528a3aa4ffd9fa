// Output files of a render: names are checked before the work, images are written after it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/output/report.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/film/write_film.h"
#include "renderer/image/atomic_file.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// The output name without -o: the scene's stem with .png, with -#### for frames, with the number
// and .kacc for a part.
[[nodiscard]] std::filesystem::path default_output(const RenderOptions& options);

// The names of the output files. Fails before any work on an extension that cannot be written or a
// name that is given twice or is an input of the command as well (usage), and on a name that no
// file can be written to, as check_writable() finds it (input_output), also for --stats and
// --checkpoint.
[[nodiscard]] Result<std::vector<std::filesystem::path>> choose_outputs(const RenderOptions& options);
// True for names of accumulation files (.kacc), false for names of images.
[[nodiscard]] bool is_accumulation(const std::filesystem::path& path);
// True for names that are written as EXR.
[[nodiscard]] bool is_exr(const std::filesystem::path& path);

// True if the image exists and its render was not interrupted, as its metadata would state.
[[nodiscard]] bool is_finished_image(const std::filesystem::path& path);

// The metadata of the images. Keys without a standard name in OpenEXR begin with "kindling:".
[[nodiscard]] ImageMetadata make_metadata(const RenderReport& report, const Camera& camera);

struct WrittenImages {
  std::vector<std::string> files;   // written successfully
  std::optional<Error> first_error; // further ones have been printed
  bool denoising_cancelled = false; // by a signal: the images are noisy, and marked as interrupted
  double denoise_s = 0.0;           // 0 without --denoise
  double write_s = 0.0;
};

// The arguments of write_images(). All references must outlive the call.
struct ImageWriting {
  const DisplayTransform& view;
  const ImageMetadata& metadata;
  const RenderOptions& options; // formats, denoising, exposure
  ProgressDisplay& display;
  Console& console;
  const CancelToken* cancel = nullptr; // of denoising
  // Gets the image as in a JPEG file, 8-bit RGB; null: no video is made.
  std::function<Result<void>(const std::vector<uint8_t>& rgb, const V2i& size_px)> frame{};
};

// Denoises if that is asked for, and writes each image, also after a failure, so that a full disk
// costs no more than it must. Reports Phase::denoise and Phase::write.
[[nodiscard]] WrittenImages write_images(const std::vector<std::filesystem::path>& outputs, const Film& film,
                                         const ImageWriting& writing);

// Predicts how long write_images() will take on this machine, in seconds. Runs the denoiser, if it
// is asked for, on a small image, which also makes the first real one faster.
[[nodiscard]] double predict_write_s(const std::vector<std::filesystem::path>& outputs, const RenderOptions& options,
                                     const V2i& size_px);

// Writes a file completely or not at all.
[[nodiscard]] Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

} // namespace kindling::app
