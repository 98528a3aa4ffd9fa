// EXR files in memory, for OpenEXR's readers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/decoders.h"

#include <OpenEXR/IexBaseExc.h>
#include <OpenEXR/ImfIO.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace kindling::image_detail {

inline constexpr char kStreamName[] = "memory"; // appears in the library's messages; without_name() removes it

class MemoryStream final : public OPENEXR_IMF_NAMESPACE::IStream {
 public:
  explicit MemoryStream(Bytes bytes) : IStream(kStreamName), bytes_(bytes) {}

  bool read(char out[], int count) override {
    const size_t left = bytes_.size() - offset_;
    if (count < 0 || static_cast<size_t>(count) > left) throw IEX_NAMESPACE::InputExc("the file ends early");
    std::memcpy(out, bytes_.data() + offset_, static_cast<size_t>(count));
    offset_ += static_cast<size_t>(count);
    return offset_ < bytes_.size();
  }
  uint64_t tellg() override { return offset_; }
  void seekg(uint64_t offset) override { offset_ = std::min<uint64_t>(offset, bytes_.size()); }

 private:
  Bytes bytes_;
  size_t offset_ = 0;
};

// Returns the last part of a message such as
// "Error reading pixel data from image file "memory". the file ends early".
inline std::string without_name(const char* message) {
  std::string_view text(message);
  constexpr std::string_view kNamed = "\"memory\". ";
  if (const size_t at = text.find(kNamed); at != std::string_view::npos && at + kNamed.size() < text.size()) {
    text.remove_prefix(at + kNamed.size());
  }
  return std::string(text);
}

} // namespace kindling::image_detail
