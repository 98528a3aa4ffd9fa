// Search for the module kindling_oiio and loading by dlopen().
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_loader.h"

#include "renderer/base/program_path.h"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include <dlfcn.h>

namespace kindling::image_detail {

namespace fs = std::filesystem;

namespace {

template <typename Function>
bool find(void* handle, const char* symbol, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(handle, symbol));
  return function != nullptr;
}

} // namespace

std::vector<fs::path> oiio_module_folders() {
  std::vector<fs::path> folders;
  if (const fs::path program = program_path(); !program.empty()) {
    folders.push_back(program.parent_path());
    folders.push_back((program.parent_path() / KINDLING_OIIO_FROM_PROGRAM).lexically_normal());
  }
  Dl_info info; // of the shared library that this is a part of, if it is one: Python's module
  if (dladdr(reinterpret_cast<void*>(&oiio_module_folders), &info) != 0 && info.dli_fname != nullptr)
    if (const fs::path library = info.dli_fname; library.extension() == ".so") folders.push_back(library.parent_path());
  folders.emplace_back(KINDLING_OIIO_INSTALL_FOLDER);
  folders.emplace_back(KINDLING_OIIO_BUILD_FOLDER);
  return folders;
}

Result<OiioModule> load_oiio_module(std::span<const fs::path> folders) {
  std::string searched;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / KINDLING_OIIO_FILE;
    std::error_code code;
    if (!fs::is_regular_file(file, code)) {
      searched += (searched.empty() ? "" : ", ") + folder.string();
      continue;
    }
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
      return Error{ErrorKind::input_output, fmt::format("the OpenImageIO module cannot be loaded: {}", dlerror())};
    }
    OiioModule module;
    if (!(find(handle, kOiioWriteTiledSymbol, module.write_tiled) &&
          find(handle, kOiioOpenCacheSymbol, module.open_cache) &&
          find(handle, kOiioCloseCacheSymbol, module.close_cache) &&
          find(handle, kOiioAddToCacheSymbol, module.add_to_cache) &&
          find(handle, kOiioFetchTexelsSymbol, module.fetch_texels))) {
      dlclose(handle);
      return Error{ErrorKind::input_output,
                   fmt::format("the OpenImageIO module {} is of another version of Kindling", file.string())};
    }
    return module;
  }
  return Error{ErrorKind::input_output,
               fmt::format("the OpenImageIO module {} was not found in {}", KINDLING_OIIO_FILE, searched)};
}

const Result<OiioModule>& oiio_module() {
  static const Result<OiioModule> loaded = load_oiio_module(oiio_module_folders());
  return loaded;
}

} // namespace kindling::image_detail
