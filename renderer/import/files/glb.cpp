// Parses and validates the chunks of a .glb.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/glb.h"

#include "renderer/import/files/other_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace kindling::gltf {
namespace {

constexpr size_t kHeaderBytes = 12;
constexpr size_t kChunkHeaderBytes = 8;
constexpr uint32_t kJson = 0x4e4f534aU;
constexpr uint32_t kBin = 0x004e4942U;

uint32_t read_u32(Bytes bytes, size_t at) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

} // namespace

bool is_glb(Bytes file) { return file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0; }

GlbChunks split_glb(Bytes file, const std::filesystem::path& path, Warnings& warnings) {
  if (file.size() < kHeaderBytes) {
    fail("", fmt::format("{} bytes, a .glb starts with a header of 12", file.size()), "GLB_UNEXPECTED_END_OF_HEADER");
  }
  if (!is_glb(file)) fail("", "does not start with the bytes 'glTF' of a .glb", "GLB_INVALID_MAGIC");
  if (const uint32_t version = read_u32(file, 4); version != 2) {
    if (version == 1) {
      fail("", fmt::format("container version 1, expected 2; convert it with {}", converter_of_version_1(path)),
           "GLB_INVALID_VERSION");
    }
    fail("", fmt::format("container version {}, expected 2", version), "GLB_INVALID_VERSION");
  }
  size_t declared = read_u32(file, 8);
  if (declared < kHeaderBytes + kChunkHeaderBytes) {
    fail("", fmt::format("declares a length of {} bytes, a .glb has at least 20", declared), "GLB_LENGTH_TOO_SMALL");
  }
  if (declared > file.size()) {
    const std::string fault = fmt::format("declares {} bytes but has {}: truncated", declared, file.size());
    if (file.size() < kHeaderBytes + kChunkHeaderBytes) fail("", fault, "GLB_LENGTH_MISMATCH");
    warnings.repair("glb length", "", fault, "GLB_LENGTH_MISMATCH", "these are read");
    declared = file.size();
  }
  if (declared < file.size()) {
    warnings.add("glb_extra", "", fmt::format("{} bytes after the end of the .glb are ignored", file.size() - declared),
                 "GLB_EXTRA_DATA");
  }

  GlbChunks chunks;
  size_t at = kHeaderBytes;
  for (int number = 0; at < declared; ++number) {
    if (declared - at < kChunkHeaderBytes) {
      const std::string fault = fmt::format("{} bytes left, a chunk header has 8", declared - at);
      constexpr const char* kCode = "GLB_UNEXPECTED_END_OF_CHUNK_HEADER";
      if (number == 0) fail("", fault, kCode);
      warnings.repair("chunk header", "", fault, kCode, "they are ignored");
      break;
    }
    size_t length = read_u32(file, at);
    const uint32_t type = read_u32(file, at + 4);
    at += kChunkHeaderBytes;
    if (length > declared - at) {
      const std::string fault = fmt::format("chunk {} declares {} bytes, {} are left", number, length, declared - at);
      const size_t left = file.size() - at; // the header may declare too little
      if (number == 0 && length > left) fail("", fault, "GLB_CHUNK_TOO_BIG");
      warnings.repair("chunk length", "", fault, "GLB_CHUNK_TOO_BIG", "what the file has is read");
      length = std::min(length, left);
    }
    const Bytes content = file.subspan(at, length);
    at += length;
    if (number == 0) {
      if (type != kJson) fail("", "the first chunk is not of type JSON", "GLB_UNEXPECTED_FIRST_CHUNK");
      if (length == 0) fail("", "the JSON chunk is empty", "GLB_EMPTY_CHUNK");
      chunks.json = content;
    } else if (type == kJson || (type == kBin && chunks.bin)) {
      fail("", fmt::format("chunk {} repeats the type of another chunk", number), "GLB_DUPLICATE_CHUNK");
    } else if (type == kBin) {
      if (number != 1) {
        warnings.repair("BIN place", "", fmt::format("the BIN chunk has number {}, expected 1", number),
                        "GLB_UNEXPECTED_BIN_CHUNK", "it is read");
      }
      chunks.bin = content;
    } else {
      warnings.add("glb_chunk", "", fmt::format("a chunk of unknown type 0x{:08x} is ignored", type),
                   "GLB_UNKNOWN_CHUNK_TYPE");
    }
  }
  return chunks;
}

} // namespace kindling::gltf
