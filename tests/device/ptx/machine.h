// A thread of the machine that PTX is for: special registers, and memory in its address spaces.
//
// Generic and global addresses are those of the host. Local addresses count from the thread's own
// memory, as a GPU's do, so one that is used in another space without cvta is an error here too.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/device/ptx/registers.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <vector>

namespace ptx {

inline constexpr size_t kLocalBytes = 16 << 10; // of a thread

// Memory that kernels may read and write.
struct Region {
  u64 begin = 0;
  u64 bytes = 0;
  [[nodiscard]] bool contains(u64 address, u64 size) const {
    return address - begin < bytes && bytes - (address - begin) >= size;
  }
};

// A function by its name in PTX, with the number of instructions of each of its blocks: all of a
// block are executed, or none. For each block, the one where all ways from it meet again: its
// immediate post-dominator, or the number of blocks if that is the function's end.
struct Function {
  const char* name = nullptr;
  const u32* blocks = nullptr;
  const u32* meetings = nullptr;
};
// A line of its text, counted from the function's first one.
struct Place {
  const Function* function = nullptr;
  u32 line = 0;
};
// A block that a thread has executed.
struct Step {
  const Function* function = nullptr;
  u32 block = 0;
  u32 depth = 0; // of calls
};

enum Access { kLoad, kStore, kAtomic };
struct Bytes {
  u64 loaded = 0, stored = 0;
};
struct Traffic {
  Bytes global, local;
  void add(const Traffic& other) {
    global.loaded += other.global.loaded;
    global.stored += other.global.stored;
    local.loaded += other.local.loaded;
    local.stored += other.local.stored;
  }
};

class Thread {
 public:
  // `regions` in the order of their addresses, which outlive the thread.
  explicit Thread(const std::vector<Region>& regions) : regions_(&regions) {}

  u32 tid_x = 0, ntid_x = 1, ctaid_x = 0, nctaid_x = 1;
  u32 lanemask_lt = 0; // each thread is alone in its warp, lane 0

  // Begins a function that has `bytes` of local memory, which have no values yet. Returns their
  // address.
  u64 enter(u32 bytes, u32 align) {
    const u64 begin = (used_ + align - 1) / align * align;
    used_ = begin + bytes;
    if (used_ > kLocalBytes) fault("a stack of " + std::to_string(used_) + " bytes");
    std::memset(&local_[begin], 0xfe, bytes);
    return begin;
  }
  [[nodiscard]] u64 used() const { return used_; }
  void leave(u64 used) { used_ = used; }

  // The host's address of `bytes` at an address, which is a multiple of them (PTX ISA 6.4.1:
  // misaligned accesses have no defined result; GPUs end the launch).
  char* generic(Access access, u64 address, u32 bytes, Place place) {
    if (address - window() < kLocalBytes) return local(access, address - window(), bytes, place);
    return global(access, address, bytes, place);
  }
  char* global(Access access, u64 address, u32 bytes, Place place) {
    if (address % bytes != 0) refuse("misaligned address", address, place);
    if (!last_.contains(address, bytes)) search(address, bytes, place);
    count(access, bytes, traffic.global);
    return reinterpret_cast<char*>(address);
  }
  char* local(Access access, u64 address, u32 bytes, Place place) {
    if (address % bytes != 0) refuse("misaligned local address", address, place);
    if (address >= used_ || used_ - address < bytes) refuse("local address", address, place);
    count(access, bytes, traffic.local);
    return &local_[address];
  }
  // PTX ISA 9.7.9.20.
  [[nodiscard]] u64 cvta_local(u64 address) const { return window() + address; }
  [[nodiscard]] u64 cvta_to_local(u64 address) const { return address - window(); }
  [[nodiscard]] u64 cvta_global(u64 address) const { return address; }
  [[nodiscard]] u64 cvta_to_global(u64 address) const { return address; }

  // What the thread did, if the translated code is compiled with PTX_COUNT.
  std::vector<Step> steps;
  u32 depth = 0;
  Traffic traffic;

 private:
  static void count([[maybe_unused]] Access access, [[maybe_unused]] u32 bytes, [[maybe_unused]] Bytes& counted) {
#ifdef PTX_COUNT
    if (access != kStore) counted.loaded += bytes;
    if (access != kLoad) counted.stored += bytes;
#endif
  }
  [[nodiscard]] u64 window() const { return reinterpret_cast<u64>(local_.data()); }
  void search(u64 address, u32 bytes, Place place);
  [[noreturn]] static void refuse(const char* what, u64 address, Place place);

  const std::vector<Region>* regions_;
  Region last_;
  u64 used_ = 0;
  alignas(16) std::array<char, kLocalBytes> local_;
};

template <typename T>
[[gnu::always_inline]] inline T get(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}
template <typename T>
[[gnu::always_inline]] inline void put(char* to, T value) {
  std::memcpy(to, &value, sizeof(T));
}
// Volatile accesses, and atomic operations without words for their order, are relaxed (PTX ISA 8.4,
// 9.7.13.5).
template <typename T>
T get_volatile(const char* from) {
  return __atomic_load_n(reinterpret_cast<const T*>(from), __ATOMIC_RELAXED);
}
template <typename T>
void put_volatile(char* to, T value) {
  __atomic_store_n(reinterpret_cast<T*>(to), value, __ATOMIC_RELAXED);
}
template <typename T>
T atom_add(char* at, T value) {
  return __atomic_fetch_add(reinterpret_cast<T*>(at), value, __ATOMIC_RELAXED);
}
template <typename T>
T atom_or(char* at, T value) {
  return __atomic_fetch_or(reinterpret_cast<T*>(at), value, __ATOMIC_RELAXED);
}
template <typename T>
T atom_cas(char* at, T expected, T value) {
  __atomic_compare_exchange_n(reinterpret_cast<T*>(at), &expected, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
  return expected;
}

#ifdef PTX_COUNT
#define STEP(block) t.steps.push_back({&function, block, t.depth})
#define CALL(function, ...) (++t.depth, function(__VA_ARGS__), --t.depth)
#else
#define STEP(block)
#define CALL(function, ...) function(__VA_ARGS__)
#endif

// An entry point with its parameters, as many bytes each as their types have.
struct Entry {
  const char* name = nullptr;
  u32 max_threads = 1024; // of a block
  void (*run)(Thread& thread, char* parameter0, char* parameter1) = nullptr;
};

} // namespace ptx
