// Memory, kernels and launches of an NVIDIA GPU.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/cuda_device.h"

#include "renderer/device/cuda/driver.h"
#include "renderer/device/cuda/gpu_kernels.h"
#include "renderer/device/cuda/kernel_cache.h"
#include "renderer/device/cuda/launch_clock.h"
#include "renderer/device/cuda/ptx_modules.h"

#include <array>
#include <cassert>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr unsigned kThreadsPerBlock = 128;
constexpr unsigned kArguments = 16;           // of launches that wait
constexpr int kOldestCapability = 70;         // 10 major + minor; the target of the PTX
constexpr uint64_t kMaxStackBytes = 12 << 10; // of a thread, by any kernel
// The last paths of a bounce keep few multiprocessors busy, for a smaller part of larger waves.
constexpr uint32_t kLargeWaveSize = 4 * kWaveSize;
constexpr uint64_t kBytesForLargeWaves = uint64_t{24} << 30;
constexpr uint64_t kRoundingBytes = 64 << 20; // allocations take whole pages of up to 2 MiB

std::string entry_of(Kernel kernel) { return std::string("kindling_") + kernel_name(kernel); }

Error failure(std::string message) { return {ErrorKind::render_failed, std::move(message)}; }

// A kernel that the driver has loaded.
struct LoadedKernel {
  cuda::Module module = nullptr;
  cuda::Function function = nullptr; // null: not loaded
};

class CudaDevice final : public Device {
 public:
  // `capability`: 10 major + minor. `notice` may be null.
  CudaDevice(cuda::Driver driver, cuda::DeviceNumber number, std::string name, int capability, DeviceNotice notice)
      : driver_(std::move(driver)), number_(number), name_(std::move(name)), capability_(capability),
        notice_(std::move(notice)) {}
  CudaDevice(const CudaDevice&) = delete;
  CudaDevice& operator=(const CudaDevice&) = delete;
  ~CudaDevice() override {
    if (context_ == nullptr) return;
    driver_.use_context(context_);
    clock_.reset();
    if (arguments_ != 0) driver_.release(arguments_);
    if (arguments_here_ != nullptr) driver_.release_host(arguments_here_);
    for (const LoadedKernel& kernel : kernels_)
      if (kernel.module != nullptr) driver_.unload_module(kernel.module);
    driver_.release_context(number_);
  }

  // Throws DeviceError.
  void start();

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override;
  void release(std::byte* memory) noexcept override {
    driver_.use_context(context_);
    driver_.release(reinterpret_cast<cuda::Address>(memory)); // a lost device has lost it already
  }
  // The driver takes the stacks of all threads in flight at the first launch.
  [[nodiscard]] uint64_t free_bytes() const override {
    use();
    size_t free_bytes = 0, total_bytes = 0;
    check(driver_.memory(&free_bytes, &total_bytes), "asking for its memory");
    int processors = 0, threads = 0;
    check(driver_.device_attribute(&processors, cuda::kProcessors, number_), "asking for its processors");
    check(driver_.device_attribute(&threads, cuda::kThreadsPerProcessor, number_), "asking for its threads");
    const uint64_t taken =
        static_cast<uint64_t>(processors) * static_cast<uint64_t>(threads) * kMaxStackBytes + kRoundingBytes;
    return free_bytes > taken ? free_bytes - taken : 0;
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
    clock_->collect(); // all launches have ended
    next_argument_ = 0;
  }
  void clear(std::byte* memory, size_t bytes) override {
    if (bytes == 0) return;
    use();
    check(driver_.fill(reinterpret_cast<cuda::Address>(memory), 0, bytes), "clearing memory");
  }
  // Copies to other memory go through some of the driver's. Failures cost that alone.
  void lock(std::span<std::byte> memory) noexcept override {
    driver_.use_context(context_);
    driver_.lock_memory(memory.data(), memory.size(), 0);
  }
  void unlock(std::span<std::byte> memory) noexcept override {
    driver_.use_context(context_);
    driver_.unlock_memory(memory.data());
  }
  void prepare(std::span<const Kernel> kernels) override;
  void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) override;
  [[nodiscard]] KernelUses kernel_uses() const override { return clock_->uses(); }
  [[nodiscard]] uint32_t wave_size() const override { return wave_size_; }

 private:
  // Contexts belong to threads, and any thread may call.
  void use() const { check(driver_.use_context(context_), "using it"); }
  void check(cuda::Status status, const char* doing) const {
    if (status != 0) throw DeviceError(name_ + ": " + doing + " failed: " + driver_.words_for(status));
  }
  [[nodiscard]] bool load(Kernel kernel, const std::vector<char>& code);
  [[nodiscard]] std::vector<char> compile(const std::string& ptx) const;

  cuda::Driver driver_;
  cuda::DeviceNumber number_;
  std::string name_;
  int capability_;
  DeviceNotice notice_;
  int driver_version_ = 0;
  uint32_t wave_size_ = kWaveSize;
  cuda::Context context_ = nullptr;
  std::array<LoadedKernel, kKernelCount> kernels_;
  // Arguments of launches, on the GPU and in locked memory here: a copy from other memory would
  // wait for the launch before.
  cuda::Address arguments_ = 0;
  void* arguments_here_ = nullptr;
  unsigned next_argument_ = 0; // those before belong to launches that may not have ended
  std::unique_ptr<cuda::LaunchClock> clock_;
};

void CudaDevice::start() {
  check(driver_.driver_version(&driver_version_), "asking for its driver's version");
  check(driver_.retain_context(&context_, number_), "starting it");
  use();
  check(driver_.allocate(&arguments_, kArguments * kMaxArgumentBytes), "allocating memory");
  check(driver_.allocate_host(&arguments_here_, kArguments * kMaxArgumentBytes), "allocating memory");
  clock_ = std::make_unique<cuda::LaunchClock>(driver_);
  size_t free_bytes = 0, total_bytes = 0;
  check(driver_.memory(&free_bytes, &total_bytes), "asking for its memory");
  if (free_bytes >= kBytesForLargeWaves) wave_size_ = kLargeWaveSize;
}

// Returns the machine code for this GPU. Any thread may call it.
std::vector<char> CudaDevice::compile(const std::string& ptx) const {
  use();
  // The driver keeps the addresses of these until the link ends, and writes to them.
  std::array<char, 1024> log{};
  std::array<int, 3> options{cuda::kJitErrorLog, cuda::kJitErrorLogBytes, cuda::kJitMaxRegisters};
  std::array<void*, 3> values{log.data(), reinterpret_cast<void*>(log.size()),
                              reinterpret_cast<void*>(uintptr_t{max_registers(ptx)})};
  cuda::Link link = nullptr;
  check(driver_.begin_link(static_cast<unsigned>(options.size()), options.data(), values.data(), &link),
        "compiling the kernels");
  void* code = nullptr; // belongs to the link
  size_t bytes = 0;
  cuda::Status status = driver_.add_to_link(link, cuda::kPtxInput, const_cast<char*>(ptx.c_str()), ptx.size() + 1,
                                            "kernels.ptx", 0, nullptr, nullptr);
  if (status == 0) status = driver_.finish_link(link, &code, &bytes);
  std::vector<char> compiled;
  if (status == 0) compiled.assign(static_cast<const char*>(code), static_cast<const char*>(code) + bytes);
  driver_.end_link(link);
  if (status == 0) return compiled;
  std::string reason = driver_.words_for(status);
  const std::string_view text(log.data(), strnlen(log.data(), log.size()));
  if (!text.empty()) reason += ": " + std::string(text.substr(0, text.find('\n')));
  throw DeviceError(name_ + ": compiling the kernels failed: " + reason);
}

// False if the driver refuses the code.
bool CudaDevice::load(Kernel kernel, const std::vector<char>& code) {
  LoadedKernel& loaded = kernels_[static_cast<size_t>(kernel)];
  if (code.empty() || driver_.load_module(&loaded.module, code.data()) != 0) {
    loaded.module = nullptr;
    return false;
  }
  const std::string entry = entry_of(kernel);
  check(driver_.function(&loaded.function, loaded.module, entry.c_str()), entry.c_str());
  return true;
}

void CudaDevice::prepare(std::span<const Kernel> kernels) {
  use();
  struct Missing {
    Kernel kernel = Kernel::begin_path;
    std::string ptx;
    std::filesystem::path file; // in the cache
    std::vector<char> code;
    std::exception_ptr failure;
  };
  static const uint64_t key = kernel_cache_key(gpu_kernels());
  std::vector<Missing> missing;
  for (const Kernel kernel : kernels) {
    if (kernels_[static_cast<size_t>(kernel)].function != nullptr) continue;
    const std::string entry = entry_of(kernel);
    std::filesystem::path file = kernel_cache_file(key, entry, capability_, driver_version_);
    // A damaged file is replaced.
    if (!load(kernel, read_cached_kernels(file)))
      missing.push_back({kernel, ptx_of_entry(gpu_kernels(), entry), std::move(file), {}, {}});
  }
  if (missing.empty()) return;
  if (notice_)
    notice_(name_ + ": its driver compiles " + std::to_string(missing.size()) +
            (missing.size() == 1 ? " kernel" : " kernels") +
            " once, which can take minutes; the cache of the user keeps what it makes");
  std::vector<std::thread> threads;
  for (Missing& one : missing)
    threads.emplace_back([this, &one] {
      try {
        one.code = compile(one.ptx);
        cache_kernels(one.file, one.code); // at once: the others may take minutes
      } catch (...) {
        one.failure = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const Missing& one : missing) {
    if (one.failure) std::rethrow_exception(one.failure);
    if (!load(one.kernel, one.code)) throw DeviceError(name_ + ": loading the kernels failed");
  }
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
  assert(argument.size() <= kMaxArgumentBytes);
  const cuda::Function& function = kernels_[static_cast<size_t>(kernel)].function;
  if (function == nullptr) prepare(std::span(&kernel, 1));
  use();
  if (next_argument_ == kArguments) {
    check(driver_.wait(), "computing");
    next_argument_ = 0;
  }
  const size_t place = kMaxArgumentBytes * next_argument_++;
  std::byte* const here = static_cast<std::byte*>(arguments_here_) + place;
  std::memcpy(here, argument.data(), argument.size());
  cuda::Address there = arguments_ + place;
  check(driver_.upload_later(there, here, argument.size(), nullptr), "computing");
  std::array<void*, 2> parameters{&there, &count};
  const unsigned blocks = count / kThreadsPerBlock + (count % kThreadsPerBlock > 0 ? 1 : 0);
  clock_->begin();
  check(driver_.launch(function, blocks, 1, 1, kThreadsPerBlock, 1, 1, 0, nullptr, parameters.data(), nullptr),
        "starting a kernel");
  clock_->end(kernel, count);
}

} // namespace

bool has_gpu_kernels() { return !gpu_kernels().empty(); }

Result<std::unique_ptr<Device>> open_cuda_device(const DeviceNotice& notice) {
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
    auto device = std::make_unique<CudaDevice>(driver, number, name.data(), 10 * major + minor, notice);
    try {
      device->start();
    } catch (const DeviceError& error) { // another process may have it for itself
      refused = std::string(" (") + error.what() + ")";
      continue;
    }
    return std::unique_ptr<Device>(std::move(device));
  }
  return failure("no GPU: NVIDIA's driver knows none that can render" + refused + "; use --device cpu");
}

} // namespace kindling
