// Writes ray sets, and checks every number while reading them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/ray_file.h"

#include "renderer/image/atomic_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

namespace kindling {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr char kMagic[8] = {'K', 'N', 'D', 'L', 'R', 'A', 'Y', 'S'};
constexpr uint32_t kMaxSets = 64;
constexpr uint32_t kLargestGroup = 1U << 16;

struct FileHeader {
  char magic[8];
  uint32_t version;
  uint32_t set_count;
  uint64_t geometry_hash;
  int32_t width;
  int32_t height;
};
static_assert(sizeof(FileHeader) == 32);

struct SetHeader {
  char name[32]; // zero-terminated
  uint32_t query;
  uint32_t coherent_group;
  uint64_t ray_count;
};
static_assert(sizeof(SetHeader) == 48);

bool is_name(const char (&name)[32]) {
  const auto* end = static_cast<const char*>(std::memchr(name, '\0', sizeof name));
  return end != nullptr && end != name &&
         std::all_of(name, end, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

class RayFileReader {
 public:
  explicit RayFileReader(const std::filesystem::path& path) : path_(path) {}

  Result<RayRecording> read() {
    std::error_code code; // a pipe would block
    if (std::filesystem::is_directory(path_, code)) return refuse("is a folder; a ray file is needed");
    if (std::filesystem::exists(path_, code) && !std::filesystem::is_regular_file(path_, code))
      return refuse("is not a regular file");
    stream_.open(path_, std::ios::binary | std::ios::ate);
    const std::streamoff end = stream_ ? static_cast<std::streamoff>(stream_.tellg()) : -1;
    if (end < 0) return refuse("cannot be read");
    bytes_ = static_cast<uint64_t>(end);
    stream_.seekg(0);

    FileHeader header;
    if (!take(&header, sizeof header) || std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
      return refuse("is no ray file; one begins with a header of 32 bytes and the letters KNDLRAYS");
    if (header.version != kRayFileVersion)
      return refuse("has version " + std::to_string(header.version) + "; version " + std::to_string(kRayFileVersion) +
                    " can be read");
    if (header.set_count < 1 || header.set_count > kMaxSets)
      return refuse("has " + std::to_string(header.set_count) + " sets of rays; 1 to " + std::to_string(kMaxSets) +
                    " are allowed");
    std::vector<SetHeader> sets(header.set_count);
    if (!take(sets.data(), sets.size() * sizeof(SetHeader))) return refuse("ends within its table of sets");
    uint64_t expected = sizeof header + sets.size() * sizeof(SetHeader);
    for (size_t s = 0; s < sets.size(); ++s) {
      if (Result<void> checked = check(sets[s], s); !checked.ok()) return checked.error();
      expected += sets[s].ray_count * sizeof(accel::Ray);
    }
    if (expected != bytes_)
      return refuse("has " + std::to_string(bytes_) + " bytes; " + std::to_string(expected) + " go with its header");

    RayRecording recording{header.geometry_hash, V2i(header.width, header.height), {}};
    for (const SetHeader& set : sets) {
      RaySet& out = recording.sets.emplace_back(RaySet{set.name, static_cast<RayQuery>(set.query), set.coherent_group,
                                                       std::vector<accel::Ray>(set.ray_count)});
      if (!take(out.rays.data(), out.rays.size() * sizeof(accel::Ray))) return refuse("cannot be read to its end");
      const auto bad = std::find_if_not(out.rays.begin(), out.rays.end(), is_valid_ray);
      if (bad != out.rays.end())
        return refuse("ray " + std::to_string(bad - out.rays.begin()) + " of set '" + out.name +
                      "' is none: origin and direction must be finite, the direction not zero, its ends numbers");
    }
    return recording;
  }

 private:
  [[nodiscard]] Error refuse(const std::string& what) const {
    return {ErrorKind::input_output, path_.string() + ": " + what};
  }

  bool take(void* target, size_t size) {
    stream_.read(static_cast<char*>(target), static_cast<std::streamsize>(size));
    return static_cast<size_t>(stream_.gcount()) == size;
  }

  // Checked before memory is allocated.
  [[nodiscard]] Result<void> check(const SetHeader& set, size_t number) const {
    const std::string place = "set " + std::to_string(number) + ": ";
    if (!is_name(set.name)) return refuse(place + "its name is not 1 to 31 of a-z, 0-9 and '-'");
    if (set.query > static_cast<uint32_t>(RayQuery::any_hit))
      return refuse(place + "query " + std::to_string(set.query) + "; use 0 (nearest hit) or 1 (any hit)");
    if (set.coherent_group > kLargestGroup)
      return refuse(place + "groups of " + std::to_string(set.coherent_group) + " rays; at most " +
                    std::to_string(kLargestGroup) + " are allowed");
    if (set.ray_count > bytes_ / sizeof(accel::Ray))
      return refuse(place + std::to_string(set.ray_count) + " rays are more than the file can hold");
    return {};
  }

  const std::filesystem::path& path_;
  std::ifstream stream_;
  uint64_t bytes_ = 0;
};

} // namespace

bool is_valid_ray(const accel::Ray& ray) {
  for (int k = 0; k < 3; ++k)
    if (!std::isfinite(ray.origin[k]) || !std::isfinite(ray.direction[k])) return false;
  return ray.direction != Imath::V3f(0.0f) && !std::isnan(ray.t_min) && !std::isnan(ray.t_max);
}

Result<void> write_ray_file(const std::filesystem::path& path, const RayRecording& recording) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file.ok()) return file.error();
  FileHeader header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kRayFileVersion;
  header.set_count = static_cast<uint32_t>(recording.sets.size());
  header.geometry_hash = recording.geometry_hash;
  header.width = recording.size_px.x;
  header.height = recording.size_px.y;
  file.value().write(&header, sizeof header);
  for (const RaySet& set : recording.sets) {
    SetHeader set_header{};
    std::memcpy(set_header.name, set.name.data(), std::min(set.name.size(), sizeof set_header.name - 1));
    set_header.query = static_cast<uint32_t>(set.query);
    set_header.coherent_group = set.coherent_group;
    set_header.ray_count = set.rays.size();
    file.value().write(&set_header, sizeof set_header);
  }
  for (const RaySet& set : recording.sets) file.value().write(set.rays.data(), set.rays.size() * sizeof(accel::Ray));
  return file.value().commit();
}

Result<RayRecording> read_ray_file(const std::filesystem::path& path) { return RayFileReader(path).read(); }

} // namespace kindling
