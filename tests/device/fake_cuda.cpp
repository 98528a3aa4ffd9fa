// A stand-in for NVIDIA's driver: memory of the host, and kernels that a test program runs.
//
// FAKE_CUDA in the environment names what fails, as words separated by spaces:
//   init=CODE         the driver does not start
//   version=10020     the version of CUDA that it supports
//   devices=0         the number of GPUs
//   unavailable=N     the first N of them, which other processes have for themselves
//   capability=60     of the GPU
//   memory=BYTES      that can be allocated in all
//   compile=CODE      the kernels do not compile
//   lost=N            the GPU is lost at the launch after N others, and stays lost
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

namespace {

constexpr int kInvalidValue = 1, kOutOfMemory = 2, kUnavailable = 46, kNoContext = 201, kNotFound = 500, kLost = 719;
constexpr std::string_view kCode = "machine code of the fake GPU:"; // then the names of the kernels

long setting(std::string_view name, long otherwise) {
  const char* const text = std::getenv("FAKE_CUDA");
  std::istringstream words(text != nullptr ? text : "");
  for (std::string word; words >> word;) {
    const size_t equals = word.find('=');
    if (equals != std::string::npos && std::string_view(word).substr(0, equals) == name)
      return std::atol(word.c_str() + equals + 1);
  }
  return otherwise;
}

std::map<void*, size_t> allocated;
size_t allocated_bytes = 0;
long launches = 0;
bool lost = false;
int context = 0;
thread_local void* current = nullptr; // context of the thread
std::atomic<long> compilations = 0;

struct Link {
  char* log = nullptr;
  size_t log_bytes = 0;
  void** log_length = nullptr; // in the caller's array of values, which the driver writes to
  std::string code;
};
struct Module {
  std::map<std::string, std::string> kernels; // the address of a name is the function
};
std::atomic<long> links_and_modules = 0; // that exist

int when_alive(int status) { return current == nullptr ? kNoContext : lost ? kLost : status; }

} // namespace

extern "C" {

// Set by a test program, or by the library that has this file: runs kernel `name` for the numbers
// in [0, count), and returns the status of its launch. Without it kernels do nothing.
int (*fake_cuda_run)(const char* name, const void* argument, unsigned count, unsigned threads_per_block) = nullptr;
// Visits all memory that is allocated.
void fake_cuda_visit(void (*visit)(void* context, const void* address, size_t bytes), void* context) {
  for (const auto& [address, bytes] : allocated) visit(context, address, bytes);
}
// The number of allocations, links and modules that were not released.
size_t fake_cuda_allocations() { return allocated.size() + static_cast<size_t>(links_and_modules); }
// How often kernels were compiled.
long fake_cuda_compilations() { return compilations; }

int cuInit(unsigned) {
  launches = 0;
  lost = false;
  return static_cast<int>(setting("init", 0));
}
int cuDriverGetVersion(int* version) {
  *version = static_cast<int>(setting("version", 13000));
  return 0;
}
int cuDeviceGetCount(int* count) {
  *count = static_cast<int>(setting("devices", 1));
  return 0;
}
int cuDeviceGet(int* device, int ordinal) {
  *device = ordinal;
  return 0;
}
int cuDeviceGetName(char* name, int bytes, int) {
  std::snprintf(name, static_cast<size_t>(bytes), "Fake GPU");
  return 0;
}
int cuDeviceGetAttribute(int* value, int attribute, int) {
  const long capability = setting("capability", 90);
  *value = static_cast<int>(attribute == 75 ? capability / 10 : capability % 10);
  return 0;
}
int cuDevicePrimaryCtxRetain(void** retained, int device) {
  if (device < setting("unavailable", 0)) return kUnavailable;
  *retained = &context;
  return 0;
}
int cuDevicePrimaryCtxRelease_v2(int) { return 0; }
int cuCtxSetCurrent(void* used) {
  current = used;
  return 0;
}
int cuMemGetInfo_v2(size_t* free_bytes, size_t* total_bytes) {
  *total_bytes = static_cast<size_t>(setting("memory", 1L << 40));
  *free_bytes = *total_bytes - allocated_bytes;
  return when_alive(0);
}
int cuMemAlloc_v2(unsigned long long* address, size_t bytes) {
  if (const int status = when_alive(0); status != 0) return status;
  if (allocated_bytes + bytes > static_cast<size_t>(setting("memory", 1L << 40))) return kOutOfMemory;
  void* const memory = std::aligned_alloc(256, (bytes + 255) / 256 * 256);
  if (memory == nullptr) return kOutOfMemory;
  std::memset(memory, 0xa5, std::min<size_t>(bytes, 1 << 20)); // whatever was there before
  allocated[memory] = bytes;
  allocated_bytes += bytes;
  *address = reinterpret_cast<unsigned long long>(memory);
  return 0;
}
int cuMemFree_v2(unsigned long long address) {
  void* const memory = reinterpret_cast<void*>(address);
  const auto found = allocated.find(memory);
  if (found == allocated.end()) return kNotFound;
  allocated_bytes -= found->second;
  allocated.erase(found);
  std::free(memory);
  return when_alive(0);
}
int cuMemcpyHtoD_v2(unsigned long long to, const void* from, size_t bytes) {
  if (const int status = when_alive(0); status != 0) return status;
  std::memcpy(reinterpret_cast<void*>(to), from, bytes);
  return 0;
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, size_t bytes) {
  if (const int status = when_alive(0); status != 0) return status;
  std::memcpy(to, reinterpret_cast<const void*>(from), bytes);
  return 0;
}
int cuMemsetD8_v2(unsigned long long to, unsigned char value, size_t bytes) {
  if (const int status = when_alive(0); status != 0) return status;
  std::memset(reinterpret_cast<void*>(to), value, bytes);
  return 0;
}
int cuMemHostRegister_v2(void*, size_t, unsigned) {
  ++links_and_modules;
  return when_alive(0);
}
int cuMemHostUnregister(void*) {
  --links_and_modules;
  return when_alive(0);
}
int cuMemAllocHost_v2(void** memory, size_t bytes) {
  *memory = std::malloc(bytes);
  ++links_and_modules;
  return when_alive(0);
}
int cuMemFreeHost(void* memory) {
  std::free(memory);
  --links_and_modules;
  return when_alive(0);
}
int cuMemcpyHtoDAsync_v2(unsigned long long to, const void* from, size_t bytes, void*) {
  return cuMemcpyHtoD_v2(to, from, bytes);
}
int cuCtxSynchronize() { return when_alive(0); }
int cuLinkCreate_v2(unsigned options, const int* names, void** values, void** link) {
  if (const int status = when_alive(0); status != 0) return status;
  auto* const made = new Link;
  ++links_and_modules;
  for (unsigned i = 0; i < options; ++i) {
    if (names[i] == 5) made->log = static_cast<char*>(values[i]);
    if (names[i] == 6) made->log_bytes = reinterpret_cast<size_t>(*(made->log_length = &values[i]));
  }
  *link = made;
  return 0;
}
int cuLinkAddData_v2(void* to, int type, void* ptx, size_t bytes, const char*, unsigned, int*, void**) {
  auto& link = *static_cast<Link*>(to);
  ++compilations;
  const long status = setting("compile", 0);
  // A full log has no zero at its end.
  if (status != 0) std::fill_n(link.log, link.log_bytes, 'x');
  if (status != 0) std::memcpy(link.log, "line 7: unknown instruction\nmore", 32);
  const std::string_view text(static_cast<const char*>(ptx), bytes);
  if (type != 1 || text.empty() || text.back() != '\0' || text.find(".version") == std::string_view::npos)
    return kInvalidValue;
  link.code = kCode;
  constexpr std::string_view kEntry = ".visible .entry ";
  for (size_t at = text.find(kEntry); at != std::string_view::npos; at = text.find(kEntry, at + 1)) {
    const size_t begin = at + kEntry.size();
    link.code += ' ';
    link.code += text.substr(begin, text.find('(', begin) - begin);
  }
  return static_cast<int>(status);
}
int cuLinkComplete(void* link, void** made, size_t* bytes) {
  std::string& code = static_cast<Link*>(link)->code;
  *made = code.data();
  *bytes = code.size() + 1;
  return 0;
}
int cuLinkDestroy(void* link) {
  std::string& code = static_cast<Link*>(link)->code;
  code.assign(code.size(), '?'); // it is gone
  if (void** const length = static_cast<Link*>(link)->log_length; length != nullptr)
    *length = reinterpret_cast<void*>(size_t{0});
  delete static_cast<Link*>(link);
  --links_and_modules;
  return 0;
}
int cuModuleLoadData(void** loaded, const void* image) {
  if (const int status = when_alive(0); status != 0) return status;
  const std::string_view code(static_cast<const char*>(image));
  if (!code.starts_with(kCode)) return 200;
  auto* const module = new Module;
  ++links_and_modules;
  std::istringstream names(std::string(code.substr(kCode.size())));
  for (std::string name; names >> name;) module->kernels.emplace(name, name);
  *loaded = module;
  return 0;
}
int cuModuleUnload(void* module) {
  delete static_cast<Module*>(module);
  --links_and_modules;
  return when_alive(0);
}
int cuModuleGetFunction(void** function, void* module, const char* name) {
  auto& kernels = static_cast<Module*>(module)->kernels;
  const auto found = kernels.find(name);
  if (found == kernels.end()) return kNotFound;
  *function = &found->second;
  return 0;
}
int cuLaunchKernel(void* function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x,
                   unsigned block_y, unsigned block_z, unsigned, void*, void** parameters, void**) {
  if (current == nullptr) return kNoContext;
  const unsigned long long threads = 1ULL * grid_x * block_x, count = *static_cast<unsigned*>(parameters[1]);
  if (threads < count || threads - count >= block_x || block_x > 1024 || grid_y * grid_z * block_y * block_z != 1)
    return kInvalidValue;
  if (launches++ >= setting("lost", 1L << 40)) lost = true;
  if (lost) return kLost;
  if (fake_cuda_run == nullptr) return 0;
  const auto argument = *static_cast<unsigned long long*>(parameters[0]);
  const int status = fake_cuda_run(static_cast<std::string*>(function)->c_str(),
                                   reinterpret_cast<const void*>(argument), static_cast<unsigned>(count), block_x);
  lost = status != 0;
  return status;
}
// An event has the number of launches before it; each takes a millisecond.
int cuEventCreate(void** event, unsigned) {
  *event = new long(0);
  ++links_and_modules;
  return 0;
}
int cuEventRecord(void* event, void*) {
  *static_cast<long*>(event) = launches;
  return 0;
}
int cuEventElapsedTime(float* milliseconds, void* begin, void* end) {
  *milliseconds = static_cast<float>(*static_cast<long*>(end) - *static_cast<long*>(begin));
  return when_alive(0);
}
int cuEventDestroy_v2(void* event) {
  delete static_cast<long*>(event);
  --links_and_modules;
  return 0;
}
int cuGetErrorName(int status, const char** name) {
  *name = status == kOutOfMemory   ? "CUDA_ERROR_OUT_OF_MEMORY"
          : status == kUnavailable ? "CUDA_ERROR_DEVICE_UNAVAILABLE"
          : status == kLost        ? "CUDA_ERROR_LAUNCH_FAILED"
                                   : "CUDA_ERROR";
  return 0;
}
int cuGetErrorString(int status, const char** text) {
  *text = status == kOutOfMemory ? "out of memory" : status == kLost ? "unspecified launch failure" : "a failure";
  return 0;
}

} // extern "C"
