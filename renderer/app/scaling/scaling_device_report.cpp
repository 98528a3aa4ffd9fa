// The figures of a device beside those of threads, and their table.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_report.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {
namespace {

// The seconds of a render on the device without its start.
double work_s(const DeviceSample& sample) { return std::max(0.0, sample.time.wall_s - sample.start_s); }

template <typename Sample, typename Member>
std::vector<double> values_of(const std::vector<Sample>& samples, Member&& member) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(member(sample));
  return values;
}

double rate(uint64_t count, double seconds) { return seconds > 0.0 ? static_cast<double>(count) / seconds : 0.0; }

// The median of first[i] / second[i] over the rounds that have both; 0 if there are none.
double median_ratio(const std::vector<double>& first, const std::vector<double>& second) {
  std::vector<double> ratios;
  for (size_t i = 0; i < std::min(first.size(), second.size()); ++i)
    if (second[i] > 0.0) ratios.push_back(first[i] / second[i]);
  return ratios.empty() ? 0.0 : median(ratios);
}

std::string millions(double per_s) { return fmt::format("{:.3f}", per_s * 1e-6); }
std::string times_or_dash(double ratio) { return ratio > 0.0 ? fmt::format("{:.2f}x", ratio) : "-"; }

} // namespace

std::string device_renderer(const DeviceScaling& device, bool shared) {
  return std::string(device_kind_name(device.kind)) + (shared ? " and processor" : "");
}

DeviceSummary summarize_device(const ScalingReport& report, const SceneScaling& scene) {
  const DeviceScaling& device = *scene.device;
  DeviceSummary s;
  const auto wall_s = values_of(device.alone, [](const DeviceSample& d) { return d.time.wall_s; });
  const auto alone_work_s = values_of(device.alone, work_s);
  const auto shared_s = values_of(device.shared, [](const SharedSample& d) { return d.wall_s; });
  s.alone_s = summarize(wall_s);
  s.shared_s = summarize(shared_s);
  s.start_s = median(values_of(device.alone, [](const DeviceSample& d) { return d.start_s; }));
  s.samples_per_s = median(values_of(device.alone, [](const DeviceSample& d) { return rate(d.paths, work_s(d)); }));
  s.rays_per_s = median(values_of(device.alone, [](const DeviceSample& d) { return rate(d.rays, work_s(d)); }));
  s.shared_samples_per_s =
      median(values_of(device.shared, [](const SharedSample& d) { return rate(d.paths, d.wall_s); }));
  s.shared_speedup = median_ratio(wall_s, shared_s);
  s.processor_s = median(values_of(device.shared, [](const SharedSample& d) { return d.processor_s; }));
  s.device_s = median(values_of(device.shared, [](const SharedSample& d) { return d.device_s; }));
  s.merge_s = median(values_of(device.shared, [](const SharedSample& d) { return d.merge_s; }));
  if (!device.shared.empty()) s.processor_share = device.shared.back().processor_share;
  const AcceleratorScaling& tree = scene.accelerators[device.accelerator];
  for (const int threads : report.thread_counts) {
    const RenderRow* row = find_row(tree, report.schedules.front(), threads);
    if (row == nullptr || row->samples.empty()) continue;
    const auto times_s = values_of(row->samples, [](const RenderSample& r) { return r.time.wall_s; });
    const auto rates = values_of(row->samples, [](const RenderSample& r) { return rate(r.paths, r.time.wall_s); });
    s.processors.push_back({threads, median(times_s), median(rates), median_ratio(times_s, alone_work_s)});
  }
  return s;
}

std::string format_device_scaling(const ScalingReport& report, const SceneScaling& scene) {
  if (!scene.device || scene.device->alone.empty()) return {};
  const DeviceScaling& device = *scene.device;
  const DeviceSummary s = summarize_device(report, scene);
  TextTable table({{"renderer"},
                   {"time", true},
                   {"spread", true},
                   {"of it the start", true},
                   {"million samples/s", true},
                   {"device to it", true}});
  for (const DeviceSummary::Processor& p : s.processors)
    table.add({fmt::format("{} thread{}", p.threads, p.threads == 1 ? "" : "s"), format_seconds(p.median_s), "", "",
               millions(p.samples_per_s), times_or_dash(p.ratio)});
  table.add({device_renderer(device, false), format_seconds(s.alone_s.median),
             fmt::format("{:.1f} %", s.alone_s.spread_percent()), format_seconds(s.start_s), millions(s.samples_per_s),
             ""});
  std::string shared;
  if (!device.shared.empty()) {
    const int threads = device.shared.back().threads;
    table.add({fmt::format("{} and {} thread{}", device_renderer(device, false), threads, threads == 1 ? "" : "s"),
               format_seconds(s.shared_s.median), fmt::format("{:.1f} %", s.shared_s.spread_percent()), "",
               millions(s.shared_samples_per_s), ""});
    shared =
        fmt::format("  one frame by both: {:.1f} % of it by the processor in {}, the rest by the device in {}, merged "
                    "in {}; {:.2f} times the speed of the device alone\n",
                    s.processor_share * 100.0, format_seconds(s.processor_s), format_seconds(s.device_s),
                    format_seconds(s.merge_s), s.shared_speedup);
  }
  return fmt::format("\n{} ({}) beside {}, {}; samples/s of a device without its start\n{}{}",
                     device_renderer(device, false), printable(device.name),
                     scene.accelerators[device.accelerator].variant.name(), schedule_name(report.schedules.front()),
                     table.str(), shared);
}

} // namespace kindling::app
