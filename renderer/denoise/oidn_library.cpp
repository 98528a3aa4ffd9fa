// Search for Open Image Denoise and loading by dlopen().
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/oidn_library.h"

#include "renderer/base/program_path.h"
#include "renderer/denoise/denoiser.h"

#include <fmt/format.h>

#include <cstdlib>
#include <system_error>
#include <type_traits>
#include <vector>

#include <dlfcn.h>

namespace kindling::oidn {
namespace {

namespace fs = std::filesystem;

Error failure(const std::string& sentence) {
  return {ErrorKind::render_failed,
          fmt::format("--denoise: {}; {} installs it, or set KINDLING_OIDN to the library's folder", sentence,
                      denoiser_install_command())};
}

// Returns a path beside the installed program; empty if the system does not name the program.
fs::path beside_program(const char* relative) {
  const fs::path program = program_path();
  return program.empty() ? fs::path() : (program.parent_path() / relative).lexically_normal();
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

// Returns files to try, best first. The last one has no folder: the system searches for it.
std::vector<fs::path> candidates() {
  if (const fs::path chosen = variable("KINDLING_OIDN"); !chosen.empty()) {
    std::error_code code;
    if (!fs::is_directory(chosen, code)) return {chosen};
    const fs::path beside = chosen / kFile;
    return {fs::exists(beside, code) ? beside : chosen / "lib" / kFile};
  }
  std::vector<fs::path> files;
  fs::path data = variable("XDG_DATA_HOME");
  if (const std::string home = variable("HOME"); data.empty() && !home.empty()) data = fs::path(home) / ".local/share";
  if (data.is_absolute()) files.push_back(data / "kindling/oidn/lib" / kFile);
  std::error_code code;
  if (const fs::path folder = beside_program(KINDLING_LIBRARY_FROM_PROGRAM); !folder.empty())
    files.push_back(folder / kFile);
  std::erase_if(files, [&](const fs::path& file) { return !fs::exists(file, code); });
  files.emplace_back(kFile);
  return files;
}

} // namespace

Result<Library> open_library() {
  std::string reason;
  Library library;
  for (const fs::path& file : candidates()) {
    library.handle.reset(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL), [](void* handle) {
      if (handle != nullptr) dlclose(handle);
    });
    library.file = file.string();
    if (library.handle != nullptr) break;
    if (reason.empty()) reason = dlerror();
  }
  if (library.handle == nullptr) return failure(fmt::format("Open Image Denoise cannot be opened ({})", reason));
  const char* missing = nullptr;
  const auto look_up = [&](auto& member, const char* name) {
    member = reinterpret_cast<std::remove_reference_t<decltype(member)>>(dlsym(library.handle.get(), name));
    if (member == nullptr && missing == nullptr) missing = name;
  };
#define KINDLING_OIDN_LOOK_UP(result, member, name, parameters) look_up(library.member, name);
  KINDLING_OIDN_FUNCTIONS(KINDLING_OIDN_LOOK_UP)
#undef KINDLING_OIDN_LOOK_UP
  if (missing != nullptr) return failure(fmt::format("{} lacks the function {}", library.file, missing));
  return library;
}

} // namespace kindling::oidn

namespace kindling {

std::string denoiser_install_command() {
  const std::filesystem::path script = oidn::beside_program(KINDLING_DATA_FROM_PROGRAM) / "get_oidn.sh";
  std::error_code code;
  return std::filesystem::exists(script, code) ? script.string() : "cmake/get_oidn.sh";
}

} // namespace kindling
