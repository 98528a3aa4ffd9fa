// Loads the module kindling_http by dlopen(), from the folders where the program's modules are.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_loader.h"
#include "renderer/view/http_server.h"

#include <fmt/format.h>

#include <system_error>

#include <dlfcn.h>

namespace kindling {

Result<std::unique_ptr<HttpServer>> make_http_server(const HttpLimits& limits) {
  const auto failed = [](const std::string& why) { return Error{ErrorKind::render_failed, why}; };
  std::string searched;
  for (const std::filesystem::path& folder : image_detail::oiio_module_folders()) {
    const std::filesystem::path file = folder / KINDLING_HTTP_FILE;
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code)) {
      searched += (searched.empty() ? "" : ", ") + folder.string();
      continue;
    }
    void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) return failed(fmt::format("the module of the web server cannot be loaded: {}", dlerror()));
    auto* const make = reinterpret_cast<MakeHttpServer*>(dlsym(handle, kMakeHttpServerSymbol));
    if (!make) return failed(fmt::format("the module {} is of another version of Kindling", file.string()));
    return std::unique_ptr<HttpServer>(make(limits));
  }
  return failed(fmt::format("this Kindling was built without a web server: the module {} was not found in {}; install "
                            "libcpp-httplib-dev and build again",
                            KINDLING_HTTP_FILE, searched));
}

} // namespace kindling
