// Mutations of the chunks of a .glb (glTF 2.0, section 4).
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutators/mutate_glb.h"

#include "tests/fuzz/mutators/mutate_json.h"

#include <cstring>

namespace kindling::fuzz {
namespace {

constexpr size_t kHeader = 12, kChunkHeader = 8;

uint32_t number_at(std::string_view bytes, size_t at) {
  uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

void append_number(std::string& bytes, size_t number) {
  const auto word = static_cast<uint32_t>(number);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

void append_chunk(std::string& file, std::string_view type, std::string_view content, char padding) {
  const size_t padded = (content.size() + 3) / 4 * 4;
  append_number(file, padded);
  file.append(type).append(content).append(padded - content.size(), padding);
}

} // namespace

std::string mutate_glb(std::string_view file, size_t max_size, Random& random) {
  constexpr size_t kOverhead = kHeader + 2 * kChunkHeader + 8;
  if (random.one_in(16) || file.size() < kHeader + kChunkHeader || !file.starts_with("glTF") || max_size < kOverhead)
    return mutate_bytes(file, max_size);
  const size_t json_size = number_at(file, kHeader);
  const std::string_view chunks = file.substr(kHeader + kChunkHeader);
  if (json_size > chunks.size()) return mutate_bytes(file, max_size);
  std::string json(chunks.substr(0, json_size));
  const std::string_view rest = chunks.substr(json_size);
  std::string bin(rest.size() > kChunkHeader ? rest.substr(kChunkHeader) : std::string_view());
  const size_t room = max_size - kOverhead;
  if (bin.empty() || random.below(4) != 0)
    json = mutate_json(json, room > bin.size() ? room - bin.size() : 1, random);
  else
    bin = mutate_bytes(bin, room > json.size() ? room - json.size() : 1);
  std::string body;
  append_chunk(body, "JSON", json, ' ');
  if (!bin.empty()) append_chunk(body, std::string_view("BIN\0", 4), bin, '\0');
  std::string result = "glTF";
  append_number(result, 2);
  append_number(result, kHeader + body.size());
  result += body;
  return result.size() <= max_size ? result : mutate_bytes(file, max_size);
}

} // namespace kindling::fuzz
