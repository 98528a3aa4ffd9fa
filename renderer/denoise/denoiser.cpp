// Filters of Open Image Denoise: prefilters of albedo and normal, then the color.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/denoiser.h"

#include "renderer/denoise/oidn_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {

struct Denoiser::Started {
  oidn::Library library;
  oidn::Device device = nullptr;

  explicit Started(oidn::Library opened) : library(std::move(opened)) {}
  ~Started() {
    if (device != nullptr) library.release_device(device);
  }
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;

  // Returns the error of the device since the last call.
  [[nodiscard]] Result<void> check() const {
    const char* message = nullptr;
    const int code = library.device_error(device, &message);
    if (code == oidn::kNoError) return {};
    if (code == oidn::kCancelled) return Error{ErrorKind::render_failed, "denoising was cancelled"};
    return Error{ErrorKind::render_failed,
                 fmt::format("Open Image Denoise: {} (error {})", message != nullptr ? message : "no message", code)};
  }
};

namespace {

using Plane = std::vector<float>; // three floats per pixel

// Returns the mean of the finite values of a channel around a pixel; 0 if there are none.
float mean_around(std::span<const float> values, size_t stride, const V2i& size_px, const V2i& pixel, size_t channel) {
  double sum = 0.0;
  int count = 0;
  for (int y = std::max(pixel.y - 1, 0); y <= std::min(pixel.y + 1, size_px.y - 1); ++y)
    for (int x = std::max(pixel.x - 1, 0); x <= std::min(pixel.x + 1, size_px.x - 1); ++x) {
      const float value =
          values[(static_cast<size_t>(y) * static_cast<size_t>(size_px.x) + static_cast<size_t>(x)) * stride + channel];
      if (!std::isfinite(value)) continue;
      sum += value;
      ++count;
    }
  return count > 0 ? static_cast<float>(sum / count) : 0.0f;
}

// Returns the first three of `stride` channels, all finite: the network would spread others over
// the whole image.
Plane finite(std::span<const float> values, size_t stride, const V2i& size_px) {
  Plane plane(values.size() / stride * 3);
  for (size_t i = 0; i < plane.size(); ++i) {
    const size_t pixel = i / 3, channel = i % 3, width = static_cast<size_t>(size_px.x);
    const float value = values[pixel * stride + channel];
    plane[i] = std::isfinite(value)
                   ? value
                   : mean_around(values, stride, size_px,
                                 V2i(static_cast<int>(pixel % width), static_cast<int>(pixel / width)), channel);
  }
  return plane;
}

// One filter, released at the end of its scope.
class FilterRun {
 public:
  FilterRun(const oidn::Library& library, oidn::Device device, const V2i& size_px)
      : library_(library), size_px_(size_px), filter_(library.new_filter(device, "RT")) {}
  ~FilterRun() {
    if (filter_ != nullptr) library_.release_filter(filter_);
  }
  FilterRun(const FilterRun&) = delete;
  FilterRun& operator=(const FilterRun&) = delete;

  void set(const char* name, Plane& plane) {
    library_.set_image(filter_, name, plane.data(), oidn::kFloat3, static_cast<size_t>(size_px_.x),
                       static_cast<size_t>(size_px_.y), 0, 0, 0);
  }
  void set(const char* name, bool value) { library_.set_bool(filter_, name, value); }
  void run(Denoising quality, uint64_t max_scratch_bytes, oidn::Progress progress, void* user) {
    library_.set_int(filter_, "maxMemoryMB",
                     static_cast<int>(std::clamp<uint64_t>(max_scratch_bytes >> 20, 1, 1 << 20)));
    library_.set_int(filter_, "quality", quality == Denoising::best ? oidn::kHighQuality : oidn::kFastQuality);
    library_.set_progress(filter_, progress, user);
    library_.commit_filter(filter_);
    library_.execute_filter(filter_);
  }
  [[nodiscard]] bool exists() const { return filter_ != nullptr; }

 private:
  const oidn::Library& library_;
  V2i size_px_;
  oidn::Filter filter_;
};

// Fractions of one filter as fractions of all.
struct Steps {
  const std::function<bool(double)>& on_progress;
  double done = 0.0;
  double count;

  static bool report(void* user, double fraction) {
    const auto& steps = *static_cast<const Steps*>(user);
    return !steps.on_progress || steps.on_progress((steps.done + fraction) / steps.count);
  }
};

} // namespace

uint64_t denoise_memory_bytes(const V2i& size_px, Denoising quality, uint64_t max_scratch_bytes) {
  if (quality == Denoising::off) return 0;
  // Measured with 2.5.1, 640x360 to 1920x1080.
  constexpr uint64_t kLibrary = 120U << 20;                        // weights, kernels, threads
  constexpr uint64_t kPlanes = 16 + 4 * 12;                        // the result, color, albedo, normal
  const uint64_t scratch = quality == Denoising::best ? 640 : 320; // of a pixel
  const uint64_t pixels = static_cast<uint64_t>(size_px.x) * static_cast<uint64_t>(size_px.y);
  return kLibrary + pixels * kPlanes + std::min(pixels * scratch, max_scratch_bytes);
}

Result<Denoiser> Denoiser::open(int threads) {
  Result<oidn::Library> library = oidn::open_library();
  if (!library.ok()) return library.error();
  auto started = std::make_shared<Started>(std::move(library).value());
  const oidn::Library& functions = started->library;
  started->device = functions.new_device(oidn::kCpuDevice);
  if (threads > 0 && started->device != nullptr) functions.set_device_int(started->device, "numThreads", threads);
  if (started->device != nullptr) functions.commit_device(started->device);
  if (Result<void> ready = started->check(); !ready.ok()) return ready.error();
  Denoiser denoiser;
  denoiser.version_ = fmt::format("{}.{}.{}", functions.get_device_int(started->device, "versionMajor"),
                                  functions.get_device_int(started->device, "versionMinor"),
                                  functions.get_device_int(started->device, "versionPatch"));
  denoiser.started_ = std::move(started);
  return denoiser;
}

Result<std::vector<float>> Denoiser::denoise(const NoisyImage& image, Denoising quality,
                                             const std::function<bool(double)>& on_progress,
                                             uint64_t max_scratch_bytes) const {
  assert(quality != Denoising::off &&
         image.rgba.size() == 4 * static_cast<size_t>(image.size_px.x) * static_cast<size_t>(image.size_px.y));
  const bool has_albedo = !image.albedo.empty(), has_normal = has_albedo && !image.normal.empty();
  const bool prefilters = quality == Denoising::best;
  Plane color = finite(image.rgba, 4, image.size_px), albedo = finite(image.albedo, 3, image.size_px),
        normal = finite(image.normal, 3, image.size_px);
  Steps steps{on_progress, 0.0, 1.0 + (prefilters ? (has_albedo ? 1.0 : 0.0) + (has_normal ? 1.0 : 0.0) : 0.0)};
  // Filters in place.
  const auto filter = [&](const char* name, Plane& plane, bool is_color) -> Result<void> {
    FilterRun run(started_->library, started_->device, image.size_px);
    if (!run.exists()) return started_->check();
    run.set(name, plane);
    if (is_color) {
      if (has_albedo) run.set("albedo", albedo);
      if (has_normal) run.set("normal", normal);
      run.set("hdr", true);
      run.set("cleanAux", prefilters && has_albedo);
    }
    run.set("output", plane);
    run.run(quality, max_scratch_bytes, Steps::report, &steps);
    steps.done += 1.0;
    return started_->check();
  };
  if (prefilters && has_albedo)
    if (Result<void> done = filter("albedo", albedo, false); !done.ok()) return done.error();
  if (prefilters && has_normal)
    if (Result<void> done = filter("normal", normal, false); !done.ok()) return done.error();
  if (Result<void> done = filter("color", color, true); !done.ok()) return done.error();

  std::vector<float> result(image.rgba.begin(), image.rgba.end());
  for (size_t i = 0; i < color.size() / 3; ++i)
    if (image.rgba[4 * i + 3] > 0.0f)
      for (size_t c = 0; c < 3; ++c) result[4 * i + c] = color[3 * i + c];
  for (float& value : result)
    if (!std::isfinite(value)) value = 0.0f;
  return result;
}

} // namespace kindling
