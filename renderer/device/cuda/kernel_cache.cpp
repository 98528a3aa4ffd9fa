// Names, reads and writes files of compiled kernels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/kernel_cache.h"

#include "renderer/image/atomic_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>

namespace kindling {
namespace {

namespace fs = std::filesystem;

// The "XDG Base Directory Specification": paths that are not absolute are ignored.
fs::path cache_folder() {
  const char* const chosen = std::getenv("XDG_CACHE_HOME");
  if (chosen != nullptr && *chosen == '/') return chosen;
  const char* const home = std::getenv("HOME");
  return home != nullptr && *home == '/' ? fs::path(home) / ".cache" : fs::path();
}

// FNV-1a.
uint64_t hash_of(std::string_view text) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

void remove_oldest(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".cubin") files.emplace_back(entry.last_write_time(ignored), entry.path());
  std::sort(files.begin(), files.end());
  for (size_t i = 0; i + kMaxCachedKernels < files.size(); ++i) fs::remove(files[i].second, ignored);
}

} // namespace

uint64_t kernel_cache_key(std::string_view ptx) { return hash_of(ptx); }

fs::path kernel_cache_file(uint64_t key, std::string_view entry, int capability, int driver_version) {
  const fs::path folder = cache_folder();
  if (folder.empty()) return {};
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "sm_%d-cuda_%d-%016llx-", capability, driver_version,
                static_cast<unsigned long long>(key));
  return folder / "kindling" / "kernels" / (name.data() + std::string(entry) + ".cubin");
}

std::vector<char> read_cached_kernels(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (file.empty() || !stream) return {};
  std::vector<char> code{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  uint64_t checksum = 0;
  if (code.size() < sizeof(checksum)) return {};
  std::memcpy(&checksum, code.data() + code.size() - sizeof(checksum), sizeof(checksum));
  code.resize(code.size() - sizeof(checksum));
  if (checksum != hash_of({code.data(), code.size()})) code.clear();
  return code;
}

void cache_kernels(const fs::path& file, std::span<const char> code) {
  if (file.empty()) return;
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  if (failed) return;
  Result<AtomicFile> written = AtomicFile::create(file);
  if (!written) return;
  const uint64_t checksum = hash_of({code.data(), code.size()});
  written.value().write(code.data(), code.size());
  written.value().write(&checksum, sizeof(checksum));
  if (written.value().commit().ok()) remove_oldest(file.parent_path());
}

} // namespace kindling
