// A stand-in for Open Image Denoise: filters that are simple sums, and a log of their parameters.
//
// A color becomes color / 2 + albedo / 4 + normal / 8, any other image half of itself. FAKE_OIDN in
// the environment names what fails, as words separated by spaces: new=CODE no device, execute=CODE
// an error of each filter; signal=1 an interrupt in the middle of each filter.
// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

namespace {

struct Device {
  int threads = 0;
};

struct Filter {
  std::map<std::string, float*> images;
  std::map<std::string, int> parameters;
  size_t floats = 0;
  bool (*progress)(void*, double) = nullptr;
  void* user = nullptr;
};

std::string log_of_filters;
int error = 0;
int alive = 0; // devices and filters

int setting(std::string_view name) {
  const char* const text = std::getenv("FAKE_OIDN");
  std::istringstream words(text != nullptr ? text : "");
  for (std::string word; words >> word;) {
    const size_t equals = word.find('=');
    if (equals != std::string::npos && std::string_view(word).substr(0, equals) == name)
      return std::atoi(word.c_str() + equals + 1);
  }
  return 0;
}

} // namespace

extern "C" {

// What the filters were given, a line for each run, since the last call.
const char* fake_oidn_log() {
  static std::string log;
  log = log_of_filters;
  log_of_filters.clear();
  return log.c_str();
}
int fake_oidn_alive() { return alive; }

void* oidnNewDevice(int type) {
  error = type == 1 ? setting("new") : 2;
  if (error != 0) return nullptr;
  ++alive;
  return new Device;
}
void oidnSetDeviceInt(Device* device, const char* name, int value) {
  if (std::string_view(name) == "numThreads") device->threads = value;
}
int oidnGetDeviceInt(Device*, const char* name) {
  const std::string_view wanted(name);
  return wanted == "versionMajor" ? 2 : wanted == "versionMinor" ? 99 : 7;
}
void oidnCommitDevice(Device*) {}
int oidnGetDeviceError(Device*, const char** message) {
  const int last = error;
  error = 0;
  *message = last != 0 ? "a reason" : nullptr;
  return last;
}
void oidnReleaseDevice(Device* device) {
  --alive;
  delete device;
}
void* oidnNewFilter(Device*, const char* type) {
  if (std::string_view(type) != "RT") return nullptr;
  ++alive;
  return new Filter;
}
void oidnSetSharedFilterImage(Filter* filter, const char* name, void* data, int format, size_t width, size_t height,
                              size_t, size_t, size_t) {
  if (format != 3) error = 2;
  filter->images[name] = static_cast<float*>(data);
  filter->floats = 3 * width * height;
}
void oidnSetFilterBool(Filter* filter, const char* name, bool value) { filter->parameters[name] = value ? 1 : 0; }
void oidnSetFilterInt(Filter* filter, const char* name, int value) { filter->parameters[name] = value; }
void oidnSetFilterProgressMonitorFunction(Filter* filter, bool (*progress)(void*, double), void* user) {
  filter->progress = progress;
  filter->user = user;
}
void oidnCommitFilter(Filter*) {}
void oidnExecuteFilter(Filter* filter) {
  for (const auto& [name, data] : filter->images) log_of_filters += name + " ";
  for (const auto& [name, value] : filter->parameters) log_of_filters += name + "=" + std::to_string(value) + " ";
  log_of_filters += "\n";
  if (error = setting("execute"); error != 0) return;
  if (setting("signal") != 0) raise(SIGINT); // its handler has run when this returns
  for (const double fraction : {0.5, 1.0})
    if (filter->progress != nullptr && !filter->progress(filter->user, fraction)) {
      error = 6;
      return;
    }
  const auto image = [&](const char* name) {
    const auto found = filter->images.find(name);
    return found == filter->images.end() ? nullptr : found->second;
  };
  const float *color = image("color"), *albedo = image("albedo"), *normal = image("normal");
  float* const output = image("output");
  for (size_t i = 0; i < filter->floats; ++i) {
    if (color == nullptr)
      output[i] = 0.5f * (albedo != nullptr ? albedo : normal)[i];
    else
      output[i] = 0.5f * color[i] + (albedo != nullptr ? 0.25f * albedo[i] : 0.0f) +
                  (normal != nullptr ? 0.125f * normal[i] : 0.0f);
  }
}
void oidnReleaseFilter(Filter* filter) {
  --alive;
  delete filter;
}
}
