// A device: a processor that runs kernels over many paths, in a memory of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/device/kernels/kernel_list.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace kindling {

// The number of paths that are followed together.
inline constexpr uint32_t kWaveSize = 1U << 20;

// Receives a line about what will take long.
using DeviceNotice = std::function<void(const std::string&)>;

// Thrown where a device does not do what it is asked for: no memory, or it is lost. The message is
// one line.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The launches of a kernel.
struct KernelUse {
  uint64_t launches = 0, threads = 0; // those of all launches together
  double seconds = 0.0;               // of the launches that have ended
};
using KernelUses = std::array<KernelUse, kKernelCount>;

// Work is done in the order of the calls. One thread at a time may call a device.
class Device {
 public:
  virtual ~Device() = default;

  // For messages: "host", or the name of a GPU.
  [[nodiscard]] virtual std::string name() const = 0;

  // Returns an address in the device's memory, aligned to 256 bytes, that release() takes back. Its
  // bytes are not initialized. Throws DeviceError if there is no room.
  [[nodiscard]] virtual std::byte* allocate(size_t bytes) = 0;
  virtual void release(std::byte* memory) noexcept = 0;
  // Returns how much allocate() can give out, less what launches take.
  [[nodiscard]] virtual uint64_t free_bytes() const { return ~uint64_t{0}; }
  virtual void upload(std::span<const std::byte> from, std::byte* to) = 0;
  virtual void download(const std::byte* from, std::span<std::byte> to) = 0;
  virtual void clear(std::byte* memory, size_t bytes) = 0; // to zero bits

  // Announces copies to and from this memory of the processor. A device may keep it in place, which
  // makes them faster. unlock() must be called before the memory is freed.
  virtual void lock(std::span<std::byte> /*memory*/) noexcept {}
  virtual void unlock(std::span<std::byte> /*memory*/) noexcept {}

  // Makes kernels ready, which may take long the first time; launch() does it where this was not
  // called. Throws DeviceError.
  virtual void prepare(std::span<const Kernel> /*kernels*/) {}

  // Runs a kernel for the numbers in [0, count), in any order. `argument` is of the kernel's type
  // (kernel_list.h); pointers in it are addresses of this device.
  virtual void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) = 0;

  // Launches so far. Those after the last download may be without their time.
  [[nodiscard]] virtual KernelUses kernel_uses() const { return {}; }

  // The number of paths that a wave should have.
  [[nodiscard]] virtual uint32_t wave_size() const = 0;
};

// An array in the memory of the processor that a device copies to. It must not outlive the device.
template <typename T>
class HostArray {
 public:
  HostArray() = default;
  HostArray(const HostArray&) = delete;
  HostArray& operator=(const HostArray&) = delete;
  ~HostArray() { unlock(); }

  // Makes it `size` elements long; their values are lost if there was less room.
  void resize(Device& device, size_t size) {
    size_ = size;
    if (size <= room_.size()) return;
    unlock();
    room_ = std::vector<T>(size);
    device_ = &device;
    device.lock(bytes());
  }
  [[nodiscard]] std::span<T> span() { return std::span(room_).first(size_); }

 private:
  [[nodiscard]] std::span<std::byte> bytes() { return std::as_writable_bytes(std::span(room_)); }
  void unlock() {
    if (device_ != nullptr) device_->unlock(bytes());
  }

  Device* device_ = nullptr;
  std::vector<T> room_;
  size_t size_ = 0;
};

// An array in the memory of a device.
template <typename T>
class DeviceArray {
 public:
  DeviceArray() = default;
  DeviceArray(Device& device, size_t size) : device_(&device), size_(size) {
    if (size > 0) data_ = reinterpret_cast<T*>(device.allocate(size * sizeof(T)));
  }
  DeviceArray(DeviceArray&& other) noexcept
      : device_(other.device_), data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  DeviceArray& operator=(DeviceArray other) noexcept {
    std::swap(device_, other.device_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~DeviceArray() {
    if (data_ != nullptr) device_->release(reinterpret_cast<std::byte*>(data_));
  }

  // Makes room for at least `size` elements, whose values are lost if there was less.
  void grow(Device& device, size_t size) {
    if (size <= size_) return;
    *this = DeviceArray(); // two at a time would take more memory
    *this = DeviceArray(device, size);
  }
  [[nodiscard]] T* data() const { return data_; } // an address of the device
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] std::span<T> span() const { return {data_, size_}; }
  // The first elements, as many as the span has, or `count`.
  void upload(std::span<const T> from) const {
    assert(from.size() <= size_);
    if (!from.empty()) device_->upload(std::as_bytes(from), bytes());
  }
  void download(std::span<T> to) const {
    assert(to.size() <= size_);
    if (!to.empty()) device_->download(bytes(), std::as_writable_bytes(to));
  }
  void clear(size_t count) const {
    assert(count <= size_);
    if (count > 0) device_->clear(bytes(), count * sizeof(T));
  }

 private:
  [[nodiscard]] std::byte* bytes() const { return reinterpret_cast<std::byte*>(data_); }

  Device* device_ = nullptr;
  T* data_ = nullptr;
  size_t size_ = 0;
};

} // namespace kindling
