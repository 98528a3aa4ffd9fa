// Makes identities of renders, compares them, and words the refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_identity.h"

#include "renderer/base/text.h"
#include "renderer/import/files/file_bytes.h"
#include "renderer/session/program_identity.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <set>
#include <span>

namespace kindling {

namespace fs = std::filesystem;

namespace {

using SettingsJson = nlohmann::json;

std::string value_text(const SettingsJson& object, const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end()) return "nothing";
  if (found->is_null()) return "none";
  return found->is_string() ? found->get<std::string>()
                            : found->dump(-1, ' ', false, SettingsJson::error_handler_t::replace);
}

void compare_settings(const std::string& in_a, const std::string& in_b, std::vector<ImageDifference>& differences) {
  if (in_a == in_b) return;
  const SettingsJson a = SettingsJson::parse(in_a, nullptr, false), b = SettingsJson::parse(in_b, nullptr, false);
  const size_t before = differences.size();
  if (a.is_object() && b.is_object()) {
    std::set<std::string> keys;
    for (const SettingsJson& object : {a, b})
      for (const auto& [key, value] : object.items()) keys.insert(key);
    for (const std::string& key : keys)
      if (!a.contains(key) || !b.contains(key) || a[key] != b[key])
        differences.push_back({key, value_text(a, key), value_text(b, key)});
  }
  if (differences.size() == before) differences.push_back({"settings", in_a, in_b}); // not JSON, or other spelling
}

std::string rect_text(const PixelRect& rect) {
  return fmt::format("{},{},{},{}", rect.min.x, rect.min.y, rect.max.x, rect.max.y);
}

bool is_whole(const AccumulationIdentity& identity) {
  return identity.part == SampleRange{0, identity.samples_per_pixel};
}

// Returns "--seed: 0 in the file, 2 here; --fov: ...", at most three of them. Program and scene
// have messages of their own.
std::string describe_settings(const std::vector<ImageDifference>& differences) {
  constexpr size_t kMax = 3;
  std::string text;
  size_t count = 0;
  for (const auto& [what, there, here] : differences) {
    if (what == kProgramDiffers || what == kSceneDiffers || ++count > kMax) continue;
    text += fmt::format("{}{}: {} in the file, {} here", count > 1 ? "; " : "", what, there, here);
  }
  if (count > kMax) text += fmt::format("; and {} more", count - kMax);
  return printable(text);
}

} // namespace

AccumulationIdentity make_identity(const WorldSettings& world, const ImageSettings& image,
                                   const ResolvedImage& resolved, uint64_t scene_hash) {
  AccumulationIdentity identity;
  identity.program = program_identity();
  identity.image = pixel_settings(world, image, resolved);
  const std::array<uint64_t, 2> hashes{scene_hash, resolved.environment_hash};
  identity.scene_hash =
      resolved.environment_hash == 0 ? scene_hash : gltf::hash_bytes(std::as_bytes(std::span(hashes)));
  std::error_code ignored;
  identity.folder = fs::current_path(ignored);
  identity.size_px = resolved.size_px;
  identity.crop = image.crop.value_or(PixelRect{V2i(0, 0), resolved.size_px});
  identity.samples_per_pixel = image.samples_per_pixel();
  identity.planned_samples = image.planned_samples();
  identity.part = {0, identity.samples_per_pixel};
  return identity;
}

std::vector<ImageDifference> image_differences(const AccumulationIdentity& a, const AccumulationIdentity& b) {
  std::vector<ImageDifference> differences;
  const auto compare = [&differences](std::string_view what, const std::string& in_a, const std::string& in_b) {
    if (in_a != in_b) differences.push_back({std::string(what), in_a, in_b});
  };
  compare(kProgramDiffers, a.program, b.program);
  compare(kSceneDiffers, fmt::format("{:016x}", a.scene_hash), fmt::format("{:016x}", b.scene_hash));
  const size_t before = differences.size();
  compare_settings(a.image, b.image, differences);
  if (differences.size() > before) return differences; // the members below are among the settings too
  compare("size", fmt::format("{}x{}", a.size_px.x, a.size_px.y), fmt::format("{}x{}", b.size_px.x, b.size_px.y));
  compare("crop", rect_text(a.crop), rect_text(b.crop));
  // The final number of samples may differ; the pattern that further samples continue may not.
  compare("planned samples per pixel", fmt::format("{}", a.planned_samples), fmt::format("{}", b.planned_samples));
  return differences;
}

Result<void> check_same_render(const AccumulationIdentity& file, const fs::path& path,
                               const AccumulationIdentity& now) {
  const auto refuse = [&](const std::string& why) { return usage_error(fmt::format("{}: {}", path.string(), why)); };
  if (file.program != now.program)
    return refuse(fmt::format("was written by {}, this is {}; resume it with the program that wrote it, or start over "
                              "with --force",
                              printable(file.program), now.program));
  if (const std::string what = describe_settings(image_differences(file, now)); !what.empty())
    return refuse(fmt::format("belongs to another render ({}); use the same settings, or another file name{}", what,
                              file.planned_samples != now.planned_samples
                                  ? fmt::format(" (to add samples: kindling resume {} --spp N)", path.string())
                                  : ""));
  if (file.scene_hash != now.scene_hash)
    return refuse(fmt::format("the scene has changed since the render was started (hash {:016x} then, {:016x} now); "
                              "restore its files, or use another file name",
                              file.scene_hash, now.scene_hash));
  if (!(is_whole(file) && is_whole(now)) && !(file.part == now.part))
    return refuse(fmt::format("holds samples {} to {} of each pixel, but {} to {} are requested; use another file name",
                              file.part.first, file.part.end - 1, now.part.first, now.part.end - 1));
  return {};
}

} // namespace kindling
