// Files of frames, for downloads.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/write_film.h"
#include "renderer/image/write_image.h"
#include "renderer/texture/temporary_folder.h"
#include "renderer/view/frame.h"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace kindling {

namespace {

constexpr float kLargestHalf = 65504.0f;

ExrLayer make_layer(std::vector<std::string> names, bool half, std::vector<float> values) {
  if (half)
    for (float& value : values) value = std::clamp(value, -kLargestHalf, kLargestHalf);
  return {std::move(names), half, std::move(values)};
}

Result<void> write(const std::filesystem::path& file, const LinearFrame& frame, const std::vector<float>& denoised,
                   FileKind kind, const DisplayTransform& transform, const std::map<std::string, std::string>& text) {
  const std::vector<float>& rgba = denoised.empty() ? frame.rgba : denoised;
  if (kind == FileKind::png) return write_png(file, display_rgba(rgba, transform), frame.size_px, 8, text);
  ExrImage image;
  image.display_size_px = image.data_max_px = frame.size_px;
  image.layers.push_back(make_layer({"R", "G", "B", "A"}, true, rgba));
  if (const AovInfo& info = aov_info(frame.state.shown); !frame.shown.empty() && info.aov != Aov::alpha)
    image.layers.push_back(make_layer(channel_names(info.aov), info.half, frame.shown));
  image.text = text;
  image.integers["kindling:samplesPerPixel"] = static_cast<int>(frame.image.samples_per_pixel());
  return write_exr(file, image);
}

} // namespace

Result<std::string> make_file(const LinearFrame& frame, const std::vector<float>& denoised, FileKind kind,
                              const DisplayTransform& transform, const std::string& command_line) {
  const Result<TemporaryFolder> folder = TemporaryFolder::create();
  if (!folder.ok()) return folder.error();
  const std::filesystem::path file = folder.value().path() / (kind == FileKind::png ? "frame.png" : "frame.exr");
  const Result<void> written = write(file, frame, denoised, kind, transform, {{"kindling:commandLine", command_line}});
  if (!written.ok()) return written.error();
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof()) return Error{ErrorKind::input_output, file.string() + ": cannot be read back"};
  return bytes;
}

} // namespace kindling
