// Renders on a device, and on a device and the processor at the same time.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_device.h"

#include "renderer/app/render/render_image.h"
#include "renderer/device/failure_reason.h"
#include "renderer/session/render_session.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>
#include <utility>

namespace kindling::app {
namespace {

RenderSettings settings_of(const ScalingStage& stage, const RenderOptions& options, uint32_t samples_per_pixel,
                           DeviceKind device, int threads) {
  RenderSettings settings = make_render_settings(options, stage.built.size_px);
  settings.samples_per_pixel = samples_per_pixel;
  settings.device = device;
  settings.threads = threads;
  return settings;
}

Error device_error(const Error& error) {
  return {error.kind, "--device: " + failure_reason(error.message) + "; leave out --device"};
}

// Parts of one frame, rendered at the same time.
class SharedFrame {
 public:
  SharedFrame(const ScalingStage& stage, const RenderSettings& processor, const RenderSettings& device)
      : stage_(stage), sides_{Side{processor, 0.0, {}}, Side{device, 0.0, {}}} {}

  void render() {
    std::thread other([this] { render(sides_[1]); });
    render(sides_[0]);
    other.join();
  }
  [[nodiscard]] double seconds(size_t side) const { return sides_[side].seconds; }
  [[nodiscard]] Result<RenderOutcome>& outcome(size_t side) { return *sides_[side].outcome; }

 private:
  struct Side {
    RenderSettings settings;
    double seconds = 0.0;
    std::optional<Result<RenderOutcome>> outcome;
  };
  void render(Side& side) const {
    const Stopwatch clock;
    side.outcome.emplace(kindling::render(*stage_.built.world, *stage_.built.camera, side.settings, nullptr, nullptr));
    side.seconds = clock.elapsed().wall_s;
  }

  const ScalingStage& stage_;
  std::array<Side, 2> sides_; // processor and device
};

} // namespace

Result<std::string> try_device(DeviceKind kind, const DeviceNotice& notice) {
  Result<std::unique_ptr<Device>> device = open_device(kind, 1, notice);
  if (!device.ok()) return device_error(device.error());
  return device.value()->name();
}

Result<DeviceSample> measure_device(const ScalingStage& stage, const RenderOptions& options, uint32_t samples_per_pixel,
                                    DeviceKind device, int threads) {
  const RenderSettings settings = settings_of(stage, options, samples_per_pixel, device, threads);
  const Stopwatch clock;
  Result<RenderOutcome> outcome = render(*stage.built.world, *stage.built.camera, settings, nullptr, nullptr);
  const WorkTime time = clock.elapsed();
  if (!outcome.ok()) return device_error(outcome.error());
  const RenderStatistics& statistics = outcome.value().statistics;
  DeviceSample sample;
  sample.time = {statistics.render_s, time.cpu_s};
  sample.start_s = statistics.device.start_s;
  sample.rays = statistics.rays.total();
  sample.paths = statistics.rays.paths;
  sample.scene_bytes = statistics.device.scene_bytes;
  sample.hash = hash_film(outcome.value().film);
  return sample;
}

std::optional<std::pair<PixelRect, PixelRect>> divide_rows(const PixelRect& crop, double share) {
  const int first = crop.min.y / kBlockSize, end = (crop.max.y + kBlockSize - 1) / kBlockSize; // blocks of rows
  if (end - first < 2) return std::nullopt;
  const int mine = std::clamp(static_cast<int>(std::lround(share * (end - first))), 1, end - first - 1);
  const int cut = (first + mine) * kBlockSize;
  return std::pair{PixelRect{crop.min, V2i(crop.max.x, cut)}, PixelRect{V2i(crop.min.x, cut), crop.max}};
}

Result<SharedSample> measure_shared(const ScalingStage& stage, const RenderOptions& options, uint32_t samples_per_pixel,
                                    DeviceKind device, int threads, double share) {
  RenderSettings here = settings_of(stage, options, samples_per_pixel, DeviceKind::cpu, threads);
  RenderSettings there = settings_of(stage, options, samples_per_pixel, device, threads);
  const PixelRect whole = here.wanted_pixels();
  const auto parts = divide_rows(whole, share);
  if (!parts)
    return Error{ErrorKind::usage,
                 "--device: an image of less than 9 rows cannot be shared by a device and the processor; use a larger "
                 "--size"};
  here.region = parts->first;
  there.region = parts->second;

  const Stopwatch clock;
  SharedFrame frame(stage, here, there);
  frame.render();
  for (const size_t side : {0, 1})
    if (const Result<RenderOutcome>& outcome = frame.outcome(side); !outcome.ok())
      return side == 0 ? outcome.error() : device_error(outcome.error());
  const Stopwatch merge_clock;
  Film film(here.size_px, whole, here.aovs);
  if (here.outliers == Outliers::trim) film.trim_outliers();
  if (const Film& part = frame.outcome(0).value().film; part.has_splats()) film.enable_splats(part.splat_area());
  for (const size_t side : {0, 1}) film.add(frame.outcome(side).value().film);
  SharedSample sample;
  sample.merge_s = merge_clock.elapsed().wall_s;
  sample.wall_s = clock.elapsed().wall_s;
  sample.processor_s = frame.seconds(0);
  sample.device_s = frame.seconds(1);
  sample.processor_share = static_cast<double>(parts->first.pixel_count()) / static_cast<double>(whole.pixel_count());
  for (const size_t side : {0, 1}) sample.paths += frame.outcome(side).value().statistics.rays.paths;
  sample.threads = threads;
  sample.hash = hash_film(film);
  return sample;
}

double balanced_share(const DeviceScaling& device, double threads_s) {
  double here = 0.0, there = 0.0; // shares of the frame per second
  if (!device.shared.empty()) {
    const SharedSample& last = device.shared.back();
    here = last.processor_share / std::max(last.processor_s, 1e-9);
    there = (1.0 - last.processor_share) / std::max(last.device_s, 1e-9);
  } else if (!device.alone.empty()) {
    here = 1.0 / std::max(threads_s, 1e-9);
    there = 1.0 / std::max(device.alone.back().time.wall_s, 1e-9);
  }
  return here + there > 0.0 ? here / (here + there) : 0.5;
}

} // namespace kindling::app
