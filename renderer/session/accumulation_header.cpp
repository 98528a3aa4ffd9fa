// Reads headers without trusting them: every number, list and text is checked.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_header.h"

#include "renderer/session/checked_json.h"
#include "renderer/session/json_text.h"
#include "renderer/world/light_groups/light_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace kindling {
namespace {

constexpr uint64_t kMinCoverageBytes = 64U << 20; // lower bound of max_coverage_bytes()

using namespace checked;

Json rect_to_json(const PixelRect& rect) { return {rect.min.x, rect.min.y, rect.max.x, rect.max.y}; }

PixelRect rect_from_json(const Json& object, const char* key, const V2i& size_px) {
  const auto [x0, y0, x1, y1] = coordinates<4>(object, key);
  if (x1 < x0 || y1 < y0 || x1 > size_px.x || y1 > size_px.y) unsound(key, "a rectangle inside of the image");
  return {V2i(x0, y0), V2i(x1, y1)};
}

// Returns the pixels that light paths reach: at least those of the film.
PixelRect splat_area_from_json(const Json& json, const V2i& size_px, const PixelRect& film) {
  const PixelRect area = rect_from_json(json, "splats", size_px);
  if (!area.contains(film)) unsound("splats", "a rectangle around the area");
  return area;
}

Json counters_to_json(const RayCounters& rays) {
  Json json = {{"camera", rays.camera},
               {"bounce", rays.bounce},
               {"shadow", rays.shadow},
               {"paths", rays.paths},
               {"reflection", rays.whitted.reflection},
               {"transmission", rays.whitted.transmission},
               {"cache_hits", rays.whitted.cache_hits},
               {"cache_misses", rays.whitted.cache_misses},
               {"cache_bypasses", rays.whitted.cache_bypasses},
               {"non_finite", rays.non_finite}};
  if (rays.first_non_finite) {
    const auto& [pixel, sample] = *rays.first_non_finite;
    json["first_non_finite"] = {pixel.x, pixel.y, sample};
  }
  return json;
}

RayCounters counters_from_json(const Json& json) {
  RayCounters rays;
  read_whole(json, "camera", rays.camera);
  read_whole(json, "bounce", rays.bounce);
  read_whole(json, "shadow", rays.shadow);
  read_whole(json, "paths", rays.paths);
  read_whole(json, "reflection", rays.whitted.reflection);
  read_whole(json, "transmission", rays.whitted.transmission);
  read_whole(json, "cache_hits", rays.whitted.cache_hits);
  read_whole(json, "cache_misses", rays.whitted.cache_misses);
  read_whole(json, "cache_bypasses", rays.whitted.cache_bypasses);
  read_whole(json, "non_finite", rays.non_finite);
  if (json.contains("first_non_finite")) {
    const Json& first = list(json, "first_non_finite");
    if (first.size() != 3) unsound("first_non_finite", "a list of 3 numbers");
    const auto at = [&](size_t i, uint64_t largest) { return whole(first[i], "first_non_finite", largest); };
    rays.first_non_finite = {V2i(static_cast<int>(at(0, kMaxSide)), static_cast<int>(at(1, kMaxSide))),
                             static_cast<uint32_t>(at(2, std::numeric_limits<uint32_t>::max()))};
  }
  return rays;
}

// Returns a list [blocks, 1 if stopped else 0, first, end, first, end, ...] for each run of equal
// blocks.
Json runs_to_json(const Coverage& coverage) {
  Json runs = Json::array();
  for (size_t i = 0; i < coverage.block_count();) {
    const size_t first = i;
    while (i < coverage.block_count() && coverage[i] == coverage[first]) ++i;
    Json run = {i - first, coverage[first].stopped ? 1 : 0};
    for (const SampleRange& span : coverage[first].spans) {
      run.push_back(span.first);
      run.push_back(span.end);
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

std::vector<ParsedHeader::CoverageRun> runs_from_json(const Json& json, size_t block_count) {
  std::vector<ParsedHeader::CoverageRun> runs;
  size_t left = block_count;
  for (const Json& values : json) {
    if (!values.is_array() || values.size() < 2 || values.size() % 2 != 0) unsound("runs", "a list of runs of blocks");
    ParsedHeader::CoverageRun run;
    run.blocks = whole(values[0], "runs", left);
    if (run.blocks == 0) unsound("runs", "a list of runs of blocks");
    run.coverage.stopped = whole(values[1], "runs", 1) == 1;
    left -= run.blocks;
    for (size_t i = 2; i < values.size(); i += 2) {
      constexpr uint32_t kLargest = std::numeric_limits<uint32_t>::max();
      const SampleRange span{static_cast<uint32_t>(whole(values[i], "runs", kLargest)),
                             static_cast<uint32_t>(whole(values[i + 1], "runs", kLargest))};
      if (span.empty() || (i > 2 && span.first <= run.coverage.spans.back().end))
        unsound("runs", "sorted spans of samples");
      run.coverage.spans.push_back(span);
    }
    runs.push_back(std::move(run));
  }
  if (left != 0) throw Unsound(fmt::format("'runs' lack {} of {} blocks", left, block_count));
  return runs;
}

size_t block_count(const PixelRect& area) {
  const auto across = [](int begin, int end) {
    return static_cast<size_t>((end + kBlockSize - 1) / kBlockSize - begin / kBlockSize);
  };
  return area.empty() ? 0 : across(area.min.x, area.max.x) * across(area.min.y, area.max.y);
}

AccumulationIdentity identity_from_json(const Json& json) {
  AccumulationIdentity identity;
  identity.program = text(json, "program");
  identity.image = json_text(json, "image");
  const std::string hash = text(json, "scene_hash");
  const auto [end, error] = std::from_chars(hash.data(), hash.data() + hash.size(), identity.scene_hash, 16);
  if (error != std::errc{} || end != hash.data() + hash.size() || hash.size() != 16)
    unsound("scene_hash", "a number of 16 hexadecimal digits");
  for (const Json& argument : list(json, "arguments"))
    identity.arguments.push_back(text_from_json(argument, "arguments"));
  identity.folder = text(json, "folder");
  const auto [width, height] = coordinates<2>(json, "size");
  identity.size_px = V2i(width, height);
  identity.crop = rect_from_json(json, "crop", identity.size_px);
  read_whole(json, "samples_per_pixel", identity.samples_per_pixel);
  read_whole(json, "planned_samples", identity.planned_samples);
  const Json& part = list(json, "part");
  if (part.size() != 2) unsound("part", "a list of 2 numbers");
  identity.part.first = static_cast<uint32_t>(whole(part[0], "part", std::numeric_limits<uint32_t>::max()));
  identity.part.end = static_cast<uint32_t>(whole(part[1], "part", std::numeric_limits<uint32_t>::max()));
  identity.metadata = json_text(json, "metadata");
  return identity;
}

std::vector<std::string> light_groups_from_json(const Json& json) {
  if (json.empty() || json.size() > kMaxLightGroups)
    unsound("light_groups", fmt::format("a list of 1 to {} names", kMaxLightGroups));
  std::vector<std::string> names;
  for (const Json& name : json) {
    names.push_back(text_from_json(name, "light_groups"));
    if (names.back().empty() || std::find(names.begin(), names.end() - 1, names.back()) != names.end() - 1)
      unsound("light_groups", "a list of different names");
  }
  return names;
}

void read_mattes(const Json& json, AccumulationHeader& header) {
  for (const Json& name : list(json, "of")) {
    const std::string matte_name = text_from_json(name, "of");
    const std::optional<Matte> matte = matte_from_name(matte_name);
    if (!matte) throw Unsound(fmt::format("there is no matte {}", in_quotes(matte_name)));
    header.aovs.insert(*matte);
  }
  if (!header.aovs.has_mattes()) unsound("of", "a list of at least one matte");
  header.matte_terms = whole(member(json, "terms"), "terms", uint64_t{1} << 48); // whose bytes can be counted
}

ParsedHeader parse(std::string_view text_of_json) {
  if (json_depth(text_of_json) > kMaxJsonDepth) throw Unsound(fmt::format("it has more than {} levels", kMaxJsonDepth));
  const Json json = Json::parse(text_of_json);
  ParsedHeader parsed;
  AccumulationHeader& header = parsed.header;
  header.summary.identity = identity_from_json(json);
  const Json& work = member(json, "work");
  header.summary.work.render_s = seconds(work, "render_s");
  header.summary.work.thread_s = seconds(work, "thread_s");
  read_whole(work, "runs", header.summary.work.runs);
  header.summary.work.rays = counters_from_json(member(work, "rays"));
  if (work.contains("training_paths")) read_whole(work, "training_paths", header.summary.work.training_paths.emplace());
  if (work.contains("light_paths"))
    header.summary.work.light_paths = static_cast<float>(number(work, "light_paths", 1.0, "a fraction from 0 to 1"));
  if (work.contains("photons"))
    header.summary.work.photons = static_cast<float>(number(work, "photons", 1.0, "a number from 0 to 1"));
  if (work.contains("direct_samples")) read_whole(work, "direct_samples", header.summary.work.direct_samples.emplace());
  if (work.contains("reflection_samples"))
    read_whole(work, "reflection_samples", header.summary.work.reflection_samples.emplace());
  if (work.contains("path_reuse")) read_whole(work, "path_reuse", header.summary.work.path_reuse.emplace());
  if (work.contains("sample_rates")) {
    constexpr double kMax = std::numeric_limits<double>::max();
    const Json& rule = member(work, "sample_rates");
    header.summary.work.rate_rule =
        RateRule{number(rule, "scale", kMax, "a scale"), number(rule, "floor", kMax, "a luminance")};
  }
  for (const Json& name : list(json, "aovs")) {
    const std::string aov_name = text_from_json(name, "aovs");
    const std::optional<Aov> aov = aov_from_name(aov_name);
    if (!aov) throw Unsound(fmt::format("there is no AOV {}", in_quotes(aov_name)));
    header.aovs.insert(*aov);
  }
  if (json.contains("mattes")) read_mattes(json["mattes"], header);
  header.trims_outliers = flag(json, "trims_outliers");
  if (json.contains("light_groups")) header.light_groups = light_groups_from_json(list(json, "light_groups"));
  header.adaptive = flag(json, "adaptive");
  const Json& coverage = member(json, "coverage");
  parsed.area = rect_from_json(coverage, "area", header.summary.identity.size_px);
  if (json.contains("splats"))
    header.splat_area = splat_area_from_json(json, header.summary.identity.size_px, parsed.area);
  parsed.runs = runs_from_json(list(coverage, "runs"), block_count(parsed.area));
  for (const Json& plane : list(json, "planes")) {
    StoredPlane& stored = parsed.planes.emplace_back();
    stored.name = text(plane, "name");
    read_whole(plane, "record_bytes", stored.record_bytes);
    read_whole(plane, "records", stored.records);
  }
  if (parsed.planes != planes_of(header, parsed.area)) throw Unsound("'planes' are not those of such a film");
  header.summary.sum_bytes = byte_count(parsed.planes);
  const uint64_t max_bytes = max_coverage_bytes(parsed.planes);
  uint64_t span_bytes = 0;
  for (const ParsedHeader::CoverageRun& run : parsed.runs) {
    const uint64_t bytes = run.coverage.spans.size() * sizeof(SampleRange);
    if (bytes > 0 && run.blocks > (max_bytes - span_bytes) / bytes)
      throw Unsound(fmt::format("'runs' have more than {} bytes of spans", max_bytes));
    span_bytes += run.blocks * bytes;
  }
  return parsed;
}

} // namespace

uint64_t byte_count(std::span<const StoredPlane> planes) {
  uint64_t bytes = 0;
  for (const StoredPlane& plane : planes) bytes += uint64_t{plane.record_bytes} * plane.records;
  return bytes;
}

uint64_t max_coverage_bytes(std::span<const StoredPlane> planes) {
  return std::max(byte_count(planes), kMinCoverageBytes);
}

std::vector<StoredPlane> planes_of(const AccumulationHeader& header, const PixelRect& area) {
  const auto pixels = area.empty() ? 0 : static_cast<size_t>(area.pixel_count());
  Film film({1, 1}, {V2i(0), V2i(1)}, header.aovs); // planes do not depend on the size
  if (header.trims_outliers) film.trim_outliers();
  if (header.splat_area) film.enable_splats();
  film.split_by_light_groups(header.light_groups);
  std::vector<StoredPlane> planes;
  for (const Film::Plane& plane : film.planes())
    planes.push_back({std::string(plane.name), plane.bytes_per_pixel,
                      plane.of_splats ? static_cast<size_t>(header.splat_area->pixel_count()) : pixels});
  if (header.adaptive) {
    planes.push_back({"stop_at", sizeof(AdaptiveState::stop_at[0]), block_count(area)});
    planes.push_back({"rays", sizeof(AdaptiveState::rays[0]), block_count(area)});
    planes.push_back({"earlier", sizeof(AdaptiveState::earlier[0]), pixels});
  }
  if (header.aovs.has_mattes()) {
    planes.push_back({"matte_counts", sizeof(FlatMattes::counts[0]), pixels});
    planes.push_back({"mattes", sizeof(MatteTerm), header.matte_terms});
  }
  return planes;
}

std::string header_to_json(const AccumulationHeader& header) {
  const AccumulationIdentity& identity = header.summary.identity;
  const RenderWork& work = header.summary.work;
  const PixelRect& area = header.summary.coverage.area();
  Json json;
  json["program"] = text_to_json(identity.program);
  json["image"] = text_to_json(identity.image);
  json["scene_hash"] = fmt::format("{:016x}", identity.scene_hash);
  json["arguments"] = Json::array();
  for (const std::string& argument : identity.arguments) json["arguments"].push_back(text_to_json(argument));
  json["folder"] = text_to_json(identity.folder.string());
  json["size"] = {identity.size_px.x, identity.size_px.y};
  json["crop"] = rect_to_json(identity.crop);
  json["samples_per_pixel"] = identity.samples_per_pixel;
  json["planned_samples"] = identity.planned_samples;
  json["part"] = {identity.part.first, identity.part.end};
  json["metadata"] = text_to_json(identity.metadata);
  json["work"] = {{"render_s", work.render_s}, {"thread_s", work.thread_s}, {"runs", work.runs}};
  json["work"]["rays"] = counters_to_json(work.rays);
  if (work.training_paths) json["work"]["training_paths"] = *work.training_paths;
  if (work.light_paths) json["work"]["light_paths"] = *work.light_paths;
  if (work.photons) json["work"]["photons"] = *work.photons;
  if (work.direct_samples) json["work"]["direct_samples"] = *work.direct_samples;
  if (work.reflection_samples) json["work"]["reflection_samples"] = *work.reflection_samples;
  if (work.path_reuse) json["work"]["path_reuse"] = *work.path_reuse;
  if (const auto& rule = work.rate_rule)
    json["work"]["sample_rates"] = {{"scale", rule->scale}, {"floor", rule->floor}};
  json["aovs"] = Json::array();
  for (const AovInfo& info : kAovs)
    if (header.aovs.contains(info.aov)) json["aovs"].push_back(info.name);
  if (header.aovs.has_mattes()) {
    Json mattes = Json::array();
    for (const MatteInfo& info : kMattes)
      if (header.aovs.contains(info.matte)) mattes.push_back(info.name);
    json["mattes"] = {{"of", mattes}, {"terms", header.matte_terms}};
  }
  json["trims_outliers"] = header.trims_outliers;
  if (header.splat_area) json["splats"] = rect_to_json(*header.splat_area);
  for (const std::string& name : header.light_groups) json["light_groups"].push_back(text_to_json(name));
  json["adaptive"] = header.adaptive;
  json["coverage"] = {{"area", rect_to_json(area)}, {"runs", runs_to_json(header.summary.coverage)}};
  json["planes"] = Json::array();
  for (const StoredPlane& plane : planes_of(header, area))
    json["planes"].push_back({{"name", plane.name}, {"record_bytes", plane.record_bytes}, {"records", plane.records}});
  return json.dump();
}

Result<ParsedHeader> header_from_json(std::string_view json) {
  try {
    return parse(json);
  } catch (const Json::exception& error) {
    return Error{ErrorKind::input_output, error.what()};
  } catch (const Unsound& error) {
    return Error{ErrorKind::input_output, error.what()};
  }
}

Coverage coverage_of(const ParsedHeader& parsed) {
  Coverage coverage(parsed.area);
  size_t block = 0;
  for (const ParsedHeader::CoverageRun& run : parsed.runs)
    for (size_t i = 0; i < run.blocks; ++i, ++block) {
      for (const SampleRange& span : run.coverage.spans) coverage.add(block, span);
      if (run.coverage.stopped) coverage.set_stopped(block);
    }
  return coverage;
}

} // namespace kindling
