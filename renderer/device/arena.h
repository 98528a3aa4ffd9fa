// Copies the arrays of views to one block of a device's memory, and moves their spans there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/view_arrays.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// An array that several spans refer to is copied once. Elements may be views themselves, or spans.
class Arena {
 public:
  static constexpr size_t kAlignment = 128;

  // Counts bytes only. The spans are moved to addresses that mean nothing.
  Arena() = default;
  // `memory` is an address of the device, with room for what a counting arena has found.
  Arena(Device& device, std::byte* memory) : device_(&device), memory_(reinterpret_cast<uintptr_t>(memory)) {}

  template <typename T>
  void place(std::span<const T>& array) {
    static_assert(alignof(T) <= kAlignment && std::is_trivially_destructible_v<T>);
    if (array.empty()) {
      array = {};
      return;
    }
    const std::pair<const void*, size_t> key(array.data(), array.size_bytes());
    auto known = offsets_.find(key);
    if (known == offsets_.end()) {
      known = offsets_.emplace(key, reserve(array.size_bytes())).first;
      if constexpr (has_arrays<T>()) {
        std::vector<T> copies(array.begin(), array.end());
        for (T& copy : copies) place_inside(copy);
        write(known->second, std::as_bytes(std::span(copies)));
      } else {
        write(known->second, std::as_bytes(array));
      }
    }
    array = {reinterpret_cast<const T*>(address(known->second)), array.size()};
  }
  // Places all arrays of a view.
  template <typename View>
  void place_arrays(View& view) {
    for_each_array(view, [this](auto& array) { place(array); });
  }
  // Reserves room without writing it. Returns its offset, a multiple of kAlignment.
  size_t reserve(size_t bytes) {
    const size_t offset = (bytes_ + kAlignment - 1) / kAlignment * kAlignment;
    bytes_ = offset + bytes;
    return offset;
  }
  void write(size_t offset, std::span<const std::byte> bytes) {
    if (device_ != nullptr) device_->upload(bytes, reinterpret_cast<std::byte*>(address(offset)));
  }
  [[nodiscard]] uintptr_t address(size_t offset) const { return memory_ + offset; }
  [[nodiscard]] size_t bytes() const { return bytes_; }

 private:
  template <typename T>
  struct IsSpan : std::false_type {};
  template <typename T>
  struct IsSpan<std::span<const T>> : std::true_type {};
  struct Nothing {
    template <typename T>
    void operator()(std::span<const T>& /*array*/) const {}
  };
  template <typename T>
  static constexpr bool has_arrays() {
    return IsSpan<T>::value || requires(T & view) { for_each_array(view, Nothing()); };
  }
  template <typename T>
  void place_inside(T& element) {
    if constexpr (IsSpan<T>::value)
      place(element);
    else
      place_arrays(element);
  }

  Device* device_ = nullptr; // null: counts only
  uintptr_t memory_ = 0;
  size_t bytes_ = 0;
  std::map<std::pair<const void*, size_t>, size_t> offsets_; // by host address and bytes
};

} // namespace kindling
