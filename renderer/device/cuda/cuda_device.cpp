// Memory, kernels and launches of an NVIDIA GPU.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/cuda_device.h"

#include "renderer/device/cuda/driver.h"
#include "renderer/device/cuda/gpu_kernels.h"
#include "renderer/device/cuda/kernel_cache.h"

#include <array>
#include <cassert>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr unsigned kThreadsPerBlock = 128;
constexpr int kOldestCapability = 70; // 10 major + minor; the target of the PTX
constexpr size_t kArgumentBytes = 4096;

constexpr std::array<const char*, kKernelCount> kEntries{
#define KINDLING_ENTRY_NAME(name, argument) "kindling_" #name,
    KINDLING_KERNELS(KINDLING_ENTRY_NAME)
#undef KINDLING_ENTRY_NAME
};

Error failure(std::string message) { return {ErrorKind::render_failed, std::move(message)}; }

class CudaDevice final : public Device {
 public:
  CudaDevice(cuda::Driver driver, cuda::DeviceNumber number, std::string name)
      : driver_(std::move(driver)), number_(number), name_(std::move(name)) {}
  CudaDevice(const CudaDevice&) = delete;
  CudaDevice& operator=(const CudaDevice&) = delete;
  ~CudaDevice() override {
    if (context_ == nullptr) return;
    driver_.use_context(context_);
    if (argument_ != 0) driver_.release(argument_);
    if (module_ != nullptr) driver_.unload_module(module_);
    driver_.release_context(number_);
  }

  // `capability`: 10 major + minor. Throws DeviceError.
  void start(int capability);

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override;
  void release(std::byte* memory) noexcept override {
    driver_.use_context(context_);
    driver_.release(reinterpret_cast<cuda::Address>(memory)); // a lost device has lost it already
  }
  void upload(std::span<const std::byte> from, std::byte* to) override {
    if (from.empty()) return;
    use();
    check(driver_.upload(reinterpret_cast<cuda::Address>(to), from.data(), from.size()), "copying to it");
  }
  void download(const std::byte* from, std::span<std::byte> to) override {
    if (to.empty()) return;
    use();
    check(driver_.download(to.data(), reinterpret_cast<cuda::Address>(from), to.size()), "computing");
  }
  void clear(std::byte* memory, size_t bytes) override {
    if (bytes == 0) return;
    use();
    check(driver_.fill(reinterpret_cast<cuda::Address>(memory), 0, bytes), "clearing memory");
  }
  void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) override;
  [[nodiscard]] uint32_t wave_size() const override { return kWaveSize; }

 private:
  // Contexts belong to threads, and any thread may call.
  void use() { check(driver_.use_context(context_), "using it"); }
  void check(cuda::Status status, const char* doing) const {
    if (status != 0) throw DeviceError(name_ + ": " + doing + " failed: " + driver_.words_for(status));
  }
  void load_kernels(int capability);
  [[nodiscard]] std::vector<char> compile_kernels();

  cuda::Driver driver_;
  cuda::DeviceNumber number_;
  std::string name_;
  cuda::Context context_ = nullptr;
  cuda::Module module_ = nullptr;
  std::array<cuda::Function, kKernelCount> kernels_{};
  cuda::Address argument_ = 0; // kArgumentBytes of the GPU's memory
};

void CudaDevice::start(int capability) {
  check(driver_.retain_context(&context_, number_), "starting it");
  use();
  load_kernels(capability);
  check(driver_.allocate(&argument_, kArgumentBytes), "allocating memory");
}

// Returns the machine code for this GPU.
std::vector<char> CudaDevice::compile_kernels() {
  std::array<char, 1024> log{};
  std::array<int, 2> options{cuda::kJitErrorLog, cuda::kJitErrorLogBytes};
  std::array<void*, 2> values{log.data(), reinterpret_cast<void*>(log.size())};
  const std::string_view ptx = gpu_kernels();
  cuda::Link link = nullptr;
  check(driver_.begin_link(static_cast<unsigned>(options.size()), options.data(), values.data(), &link),
        "compiling the kernels");
  void* code = nullptr; // belongs to the link
  size_t bytes = 0;
  cuda::Status status = driver_.add_to_link(link, cuda::kPtxInput, const_cast<char*>(ptx.data()), ptx.size() + 1,
                                            "kernels.ptx", 0, nullptr, nullptr);
  if (status == 0) status = driver_.finish_link(link, &code, &bytes);
  std::vector<char> compiled;
  if (status == 0) compiled.assign(static_cast<const char*>(code), static_cast<const char*>(code) + bytes);
  driver_.end_link(link);
  if (status == 0) return compiled;
  std::string reason = driver_.words_for(status);
  if (log[0] != '\0') reason += ": " + std::string(log.data(), std::string_view(log.data()).find('\n'));
  throw DeviceError(name_ + ": compiling the kernels failed: " + reason);
}

void CudaDevice::load_kernels(int capability) {
  int version = 0;
  check(driver_.driver_version(&version), "asking for its driver's version");
  const std::filesystem::path file = kernel_cache_file(gpu_kernels(), capability, version);
  std::vector<char> code = read_cached_kernels(file);
  if (code.empty() || driver_.load_module(&module_, code.data()) != 0) { // a damaged file is replaced
    code = compile_kernels();
    check(driver_.load_module(&module_, code.data()), "loading the kernels");
    cache_kernels(file, code);
  }
  for (size_t i = 0; i < kKernelCount; ++i) check(driver_.function(&kernels_[i], module_, kEntries[i]), kEntries[i]);
}

std::byte* CudaDevice::allocate(size_t bytes) {
  use();
  cuda::Address address = 0;
  const cuda::Status status = driver_.allocate(&address, bytes);
  if (status == 0) return reinterpret_cast<std::byte*>(address);
  size_t free_bytes = 0, total_bytes = 0;
  std::string room;
  if (driver_.memory(&free_bytes, &total_bytes) == 0)
    room = " (" + std::to_string(free_bytes >> 20) + " of its " + std::to_string(total_bytes >> 20) + " MiB are free)";
  throw DeviceError(name_ + ": no room for " + std::to_string(bytes >> 20) + " MiB" + room + ": " +
                    driver_.words_for(status) + "; use --device cpu");
}

void CudaDevice::launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) {
  if (count == 0) return;
  assert(argument.size() <= kArgumentBytes);
  use();
  check(driver_.upload(argument_, argument.data(), argument.size()), "computing");
  std::array<void*, 2> parameters{&argument_, &count};
  const unsigned blocks = (count + kThreadsPerBlock - 1) / kThreadsPerBlock;
  check(driver_.launch(kernels_[static_cast<size_t>(kernel)], blocks, 1, 1, kThreadsPerBlock, 1, 1, 0, nullptr,
                       parameters.data(), nullptr),
        "starting a kernel");
}

} // namespace

bool has_gpu_kernels() { return !gpu_kernels().empty(); }

Result<std::unique_ptr<Device>> open_cuda_device() {
  if (!has_gpu_kernels())
    return failure(
        "no GPU: this program was built without kernels for GPUs; build it where clang++-19 is installed, or "
        "use --device cpu");
  Result<cuda::Driver> opened = cuda::open_driver();
  if (!opened) return opened.error();
  const cuda::Driver& driver = opened.value();
  int count = 0;
  if (const cuda::Status status = driver.device_count(&count); status != 0)
    return failure("no GPU: NVIDIA's driver does not count them: " + driver.words_for(status));
  std::string refused;
  for (int ordinal = 0; ordinal < count; ++ordinal) {
    cuda::DeviceNumber number = 0;
    std::array<char, 256> name{};
    int major = 0, minor = 0;
    if (driver.device(&number, ordinal) != 0 ||
        driver.device_name(name.data(), static_cast<int>(name.size()), number) != 0 ||
        driver.device_attribute(&major, cuda::kMajorCapability, number) != 0 ||
        driver.device_attribute(&minor, cuda::kMinorCapability, number) != 0)
      continue;
    if (10 * major + minor < kOldestCapability) {
      refused = std::string(" (") + name.data() + " has compute capability " + std::to_string(major) + "." +
                std::to_string(minor) + "; at least 7.0 is needed)";
      continue;
    }
    auto device = std::make_unique<CudaDevice>(driver, number, name.data());
    try {
      device->start(10 * major + minor);
    } catch (const DeviceError& error) {
      return failure(error.what());
    }
    return std::unique_ptr<Device>(std::move(device));
  }
  return failure("no GPU: NVIDIA's driver knows none that can render" + refused + "; use --device cpu");
}

} // namespace kindling
