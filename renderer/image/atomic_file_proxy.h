// Lets OpenImageIO write to an AtomicFile.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/atomic_file.h"

#include <OpenImageIO/filesystem.h>

namespace kindling::image_detail {

// A failed write is not told to the library (libpng would print it): the file keeps the reason until commit().
class AtomicFileProxy final : public OIIO::Filesystem::IOProxy {
 public:
  explicit AtomicFileProxy(AtomicFile& file) : IOProxy("", Write), file_(file) {}

  const char* proxytype() const override { return "atomic"; }
  bool seek(int64_t offset) override {
    m_pos = offset;
    file_.seek(offset);
    return true;
  }
  size_t write(const void* data, size_t size) override {
    file_.write(data, size);
    m_pos += static_cast<int64_t>(size);
    return size;
  }

 private:
  AtomicFile& file_;
};

} // namespace kindling::image_detail
