// Formats the summary of a render.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/report.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

// "12.3 M", or "812".
std::string count(uint64_t value) { return format_count(static_cast<double>(value)); }

std::string rate(double per_second, std::string_view unit) {
  const std::string text = format_count(per_second);
  return text + (text.find(' ') == std::string::npos ? " " : "") + std::string(unit) + "/s";
}

} // namespace

std::string describe_motion(const MotionStatistics& motion) {
  if (motion.max_keys == 0) return "motion: nothing moves while the shutter is open";
  const auto is_one = [](size_t n) { return n == 1; };
  return fmt::format(
      "motion: {} that move{}, {} that deform{}, {} keys at most, {}",
      fmt::format("{} instance{}", motion.moving_instance_count, is_one(motion.moving_instance_count) ? "" : "s"),
      is_one(motion.moving_instance_count) ? "s" : "",
      fmt::format("{} mesh{}", motion.deforming_mesh_count, is_one(motion.deforming_mesh_count) ? "" : "es"),
      is_one(motion.deforming_mesh_count) ? "s" : "", motion.max_keys, format_bytes(motion.key_bytes));
}

namespace {

std::string pilot_line(std::string_view name, double pilot_s, std::string_view choice, double predicted) {
  return fmt::format("  {:<7} {} of pilot: {} ({:.2f} predicted)\n", name, format_seconds(pilot_s), choice, predicted);
}

// Formats the choice of each pilot that was traced as a line.
std::string pilot_lines(const RenderStatistics& s, double mean_spp) {
  std::string text;
  if (const LightPathChoice& l = s.light_paths; l.camera_paths > 0)
    text += pilot_line("lights", l.pilot_s,
                       l.fraction > 0.0f ? fmt::format("light paths for {:g} of the samples", l.fraction)
                                         : std::string("no light paths"),
                       l.predicted);
  if (const DirectSampleChoice& d = s.direct_samples; d.paths > 0)
    text += pilot_line("direct", d.pilot_s,
                       fmt::format("{} light sample{}{} at the first surface", d.count, d.count == 1 ? "" : "s",
                                   d.reflections > 0 ? fmt::format(" and {} of reflections", d.reflections) : ""),
                       d.predicted);
  if (const SampleChoice& p = s.path_reuse; p.paths > 0)
    text += pilot_line("reuse", p.pilot_s,
                       p.count > 1 ? fmt::format("{} pixels share their paths", p.count)
                                   : std::string("no paths are shared between pixels"),
                       p.predicted);
  if (const PhotonChoice& p = s.photons; p.paths > 0)
    text += pilot_line("photons", p.pilot_s,
                       p.fraction > 0.0f ? fmt::format("{:g} photons for each sample of a pixel", p.fraction)
                                         : std::string("no photons are gathered"),
                       p.predicted);
  if (const RateChoice& c = s.sample_rates; c.paths > 0)
    text +=
        pilot_line("rates", c.pilot_s,
                   c.rule.kind() == SampleRateKind::noise
                       ? fmt::format("pixels have {:.1f} samples on average, more where there is more noise", mean_spp)
                       : std::string("all pixels have the same samples"),
                   c.predicted);
  return text;
}

} // namespace

std::string format_summary(const RenderReport& r) {
  const RenderStatistics& s = r.statistics;
  const PhaseTimes& t = r.times;
  std::string crop;
  if (r.crop.width() != r.size_px.x || r.crop.height() != r.size_px.y)
    crop = fmt::format(" (crop of {}x{})", r.crop.width(), r.crop.height());
  std::string text = fmt::format(
      "{} {}x{}{} at {}{} spp, {} on {}\n", r.interrupted ? "interrupted:" : "rendered", r.size_px.x, r.size_px.y, crop,
      s.samples_per_pixel, r.interrupted ? fmt::format(" of {}", r.spp_wanted) : "", r.accelerator_description,
      s.device.name == "cpu" ? fmt::format("{} thread{}", s.threads, s.threads == 1 ? "" : "s")
                             : fmt::format("device {}", s.device.name));
  if (const TileStatistics& tiles = s.device.tiles; tiles.tiles > 0)
    text += fmt::format("  tiles   room for {} of {}; {} loaded, {} evicted, {} stages run again\n", count(tiles.slots),
                        count(tiles.tiles), count(tiles.loaded), count(tiles.evicted), count(tiles.stages_again));
  if (!s.device.why_cpu.empty()) text += fmt::format("  device  cpu, because: {}\n", s.device.why_cpu);
  text += fmt::format("  time    load {}", format_seconds(t.load_s));
  if (t.import.textures.wall_s >= 0.0005)
    text += fmt::format(" (textures {})", format_seconds(t.import.textures.wall_s));
  text += fmt::format(", build {}, render {}{}, write {}; {} in all\n", format_seconds(t.build_s),
                      format_seconds(t.render_s), t.denoise_s > 0.0 ? ", denoise " + format_seconds(t.denoise_s) : "",
                      format_seconds(t.write_s), format_seconds(t.total_s));
  if (r.adaptive.enabled())
    text += fmt::format("  noise   {:.1f}% of the pixels converged to {:g}; {:.1f} spp on average\n",
                        100.0 * s.converged_share, r.adaptive.noise_threshold, r.mean_spp);
  if (const GuidingStatistics& g = s.guiding; g.paths > 0)
    text += fmt::format(
        "  guiding {} of training: {} ({:.2f} predicted), {} ({:.2f} predicted){}{}{}\n", format_seconds(g.training_s),
        g.patches > 0 ? fmt::format("directions to {} patches", g.patches) : "directions not guided", g.predicted,
        g.light_regions > 0 ? fmt::format("lights by {} regions", g.light_regions) : "lights not guided",
        g.predicted_lights,
        g.environment_regions > 0 ? fmt::format(", the environment followed in {} regions ({:.2f} predicted)",
                                                g.environment_regions, g.predicted_environment)
                                  : std::string(),
        g.volume_regions > 0 ? fmt::format(", scattering by {} regions", g.volume_regions) : std::string(),
        g.caustic_regions > 0 ? fmt::format(", caustics by {} regions ({:.0f} % of the light)", g.caustic_regions,
                                            100.0 * g.caustic_share)
                              : std::string());
  text += pilot_lines(s, r.mean_spp);
  text += fmt::format("  start   first ray after {}, every pixel after {}\n", format_seconds(t.before_render_s),
                      format_seconds(r.time_to_first_pixel_s()));
  text += fmt::format("  rays    {}: camera {}, bounce {}, shadow {}{}; {}\n", count(s.rays.total()),
                      count(s.rays.camera), count(s.rays.bounce), count(s.rays.shadow),
                      s.rays.photon > 0 ? fmt::format(", and {} of photons", count(s.rays.photon)) : "",
                      rate(r.rays_per_s(), "rays"));
  text += fmt::format("  paths   {}; {}\n", count(s.rays.paths), rate(r.paths_per_s(), "paths"));
  if (const auto& c = r.checkpoint)
    text += fmt::format(
        "  saved   {} time{}{} in {} to {}; {} run{}, {} of rendering in all\n", c->saves, c->saves == 1 ? "" : "s",
        c->failed_saves > 0 ? fmt::format(", {} failed", c->failed_saves) : "", format_seconds(c->save_s), c->file,
        c->work.runs, c->work.runs == 1 ? "" : "s", format_seconds(c->work.render_s));
  text += fmt::format("  memory  peak {}: geometry {}, accelerator {}, textures {}, lights {}, film {}",
                      format_bytes(r.peak_resident_bytes), format_bytes(r.world.geometry_bytes),
                      format_bytes(r.world.accelerator.memory_bytes), format_bytes(r.world.texture_bytes),
                      format_bytes(r.world.light_bytes), format_bytes(r.film_bytes));
  return text;
}

} // namespace kindling::app
