// Writes KTX2 files, and makes random blocks.
// SPDX-License-Identifier: Apache-2.0
#include "tests/image/ktx2_files.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace kindling::test {

FileBytes write_ktx2(const Ktx2File& file) {
  std::vector<uint8_t> bytes = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
  const auto put = [&](uint64_t value, int size = 4) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
  };
  constexpr uint32_t kDescriptor = 104, kDescriptorBytes = 28;
  const std::string entry = "KTXswizzle" + std::string(1, '\0') + file.swizzle + '\0';
  const auto entry_bytes = static_cast<uint32_t>(file.swizzle.empty() ? 0 : 4 + entry.size());
  for (const uint32_t value : {file.vk_format, 1U, file.width, file.height, 0U, 0U, 1U, 1U, file.scheme, kDescriptor,
                               kDescriptorBytes, kDescriptor + kDescriptorBytes, entry_bytes}) {
    put(value);
  }
  for (int i = 0; i < 2; ++i) put(0, 8); // no supercompression data
  put(kDescriptor + kDescriptorBytes + entry_bytes, 8);
  put(file.level.size(), 8);
  put(file.inflated, 8);
  for (const uint32_t word : {kDescriptorBytes, 0U, 2U | 24U << 16, 1U, 0U, 0U, 0U}) put(word); // basic, no samples
  if (entry_bytes > 0) {
    put(entry.size());
    bytes.insert(bytes.end(), entry.begin(), entry.end());
  }
  bytes.insert(bytes.end(), file.level.begin(), file.level.end());
  FileBytes result(bytes.size());
  std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

std::vector<uint8_t> random_blocks(uint32_t vk_format, size_t block_bytes, size_t count) {
  std::vector<uint8_t> bytes(count * block_bytes);
  uint64_t state = vk_format;
  for (size_t i = 0; i < bytes.size(); i += 8) {
    state += 0x9e3779b97f4a7c15;
    uint64_t z = state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    z ^= z >> 31;
    std::memcpy(bytes.data() + i, &z, sizeof z);
  }
  constexpr std::array<uint8_t, 16> kBc6hCodes = {0, 1, 2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15, 19, 31};
  for (size_t i = 0; i < count; ++i) {
    uint8_t* block = bytes.data() + i * block_bytes;
    if (vk_format == 143 || vk_format == 144) {
      const uint8_t code = kBc6hCodes[i % 16];
      block[0] = static_cast<uint8_t>((block[0] & (code < 2 ? 0xfc : 0xe0)) | code);
    } else if (vk_format == 145) {
      const size_t mode = i % 9; // 8 is reserved
      block[0] = static_cast<uint8_t>((block[0] >> (mode + 1) << (mode + 1)) | 1 << mode);
    } else if (vk_format >= kFirstAstc && i % 32 == 0) { // one color
      block[0] = 0xfc;
      block[1] = static_cast<uint8_t>((block[1] & 2) | 0xfd);
      std::fill(block + 2, block + 8, uint8_t{0xff});
    }
  }
  return bytes;
}

} // namespace kindling::test
