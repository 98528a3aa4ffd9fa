// Creates, maps and unmaps shared memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace kindling::app {

namespace {

Error no_memory(size_t bytes) {
  return {ErrorKind::render_failed,
          "cannot share " + std::to_string(bytes) + " bytes with the process of a plugin: " + std::strerror(errno)};
}

} // namespace

Result<SharedMemory> SharedMemory::create(size_t bytes) {
  const size_t size = std::max<size_t>(bytes, 1);
  const int first = memfd_create("kindling-shootout", MFD_CLOEXEC);
  const int descriptor = first < 0 ? -1 : fcntl(first, F_DUPFD_CLOEXEC, kLowestDescriptor);
  if (first >= 0) close(first);
  if (descriptor < 0) return no_memory(size);
  void* data = MAP_FAILED;
  // Reserved now: a page that cannot be had later would end the process.
  if (const int error = posix_fallocate(descriptor, 0, static_cast<off_t>(size)); error != 0)
    errno = error;
  else
    data = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (data == MAP_FAILED) {
    Error error = no_memory(size);
    close(descriptor);
    return error;
  }
  return SharedMemory(descriptor, static_cast<std::byte*>(data), size);
}

Result<SharedMemory> SharedMemory::open(int descriptor, bool writable) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size <= 0)
    return Error{ErrorKind::render_failed, "descriptor " + std::to_string(descriptor) + " is no shared memory"};
  const auto size = static_cast<size_t>(status.st_size);
  void* data = mmap(nullptr, size, PROT_READ | (writable ? PROT_WRITE : 0), MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (data == MAP_FAILED) return no_memory(size);
  return SharedMemory(descriptor, static_cast<std::byte*>(data), size);
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

SharedMemory& SharedMemory::operator=(SharedMemory&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) munmap(data_, size_);
  if (descriptor_ >= 0) close(descriptor_);
}

} // namespace kindling::app
