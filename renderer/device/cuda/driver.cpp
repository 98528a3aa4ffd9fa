// Opens NVIDIA's driver and looks its functions up.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/driver.h"

#include <dlfcn.h>

#include <cstdlib>

namespace kindling::cuda {
namespace {

// The kernels' PTX is of a version that drivers understand since this one: 1000 major + 10 minor of
// the CUDA release.
constexpr int kOldestDriver = 11000;

Error failure(std::string message) { return {ErrorKind::render_failed, std::move(message)}; }

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

} // namespace

std::string Driver::words_for(Status status) const {
  const char *name = nullptr, *text = nullptr;
  if (error_name(status, &name) != 0 || name == nullptr) return "error " + std::to_string(status);
  if (error_text(status, &text) != 0 || text == nullptr) return name;
  return std::string(text) + " (" + name + ")";
}

Result<Driver> open_driver() {
  const char* const chosen = std::getenv("KINDLING_CUDA_DRIVER");
  const std::string path = chosen != nullptr && *chosen != '\0' ? chosen : "libcuda.so.1";
  Driver driver;
  // It remains loaded: the driver has threads and functions for the end of the process.
  driver.library.reset(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE), [](void* library) {
    if (library != nullptr) dlclose(library);
  });
  if (driver.library == nullptr)
    return failure("no GPU: NVIDIA's driver cannot be opened (" + std::string(dlerror()) + "); use --device cpu");
  const char* missing = nullptr;
  const auto look_up = [&](auto& member, const char* name) {
    member = reinterpret_cast<std::remove_reference_t<decltype(member)>>(dlsym(driver.library.get(), name));
    if (member == nullptr && missing == nullptr) missing = name;
  };
#define KINDLING_CUDA_LOOK_UP(member, name, parameters) look_up(driver.member, name);
  KINDLING_CUDA_FUNCTIONS(KINDLING_CUDA_LOOK_UP)
#undef KINDLING_CUDA_LOOK_UP
  if (missing != nullptr)
    return failure("no GPU: " + path + " lacks the function " + missing +
                   "; install a newer driver, or use --device cpu");
  if (const Status status = driver.init(0); status != 0)
    return failure("no GPU: NVIDIA's driver does not start: " + driver.words_for(status) + "; use --device cpu");
  int version = 0;
  if (const Status status = driver.driver_version(&version); status != 0)
    return failure("no GPU: NVIDIA's driver does not tell its version: " + driver.words_for(status));
  if (version < kOldestDriver)
    return failure("no GPU: NVIDIA's driver supports CUDA " + version_text(version) + "; at least " +
                   version_text(kOldestDriver) + " is needed; install a newer driver, or use --device cpu");
  return driver;
}

} // namespace kindling::cuda
