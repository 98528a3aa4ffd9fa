// Filters of Open Image Denoise: prefilters of albedo and normal, then the color.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/denoiser.h"

#include "renderer/denoise/oidn_library.h"

#include <fmt/format.h>

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

Plane finite(std::span<const float> values, size_t stride) {
  Plane plane(values.size() / stride * 3);
  for (size_t i = 0; i < plane.size(); ++i) {
    const float value = values[i / 3 * stride + i % 3];
    plane[i] = std::isfinite(value) ? value : 0.0f;
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
  void run(Denoising quality, oidn::Progress progress, void* user) {
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

std::string_view denoising_name(Denoising denoising) {
  switch (denoising) {
  case Denoising::off: return "off";
  case Denoising::fast: return "fast";
  case Denoising::best: return "best";
  }
  return "";
}

std::optional<Denoising> denoising_from_name(std::string_view name) {
  for (const Denoising denoising : {Denoising::off, Denoising::fast, Denoising::best})
    if (name == denoising_name(denoising)) return denoising;
  return std::nullopt;
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
                                             const std::function<bool(double)>& on_progress) const {
  assert(quality != Denoising::off &&
         image.rgba.size() == 4 * static_cast<size_t>(image.size_px.x) * static_cast<size_t>(image.size_px.y));
  const bool has_albedo = !image.albedo.empty(), has_normal = has_albedo && !image.normal.empty();
  const bool prefilters = quality == Denoising::best;
  Plane color = finite(image.rgba, 4), albedo = finite(image.albedo, 3), normal = finite(image.normal, 3);
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
    run.run(quality, Steps::report, &steps);
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
  return result;
}

} // namespace kindling
