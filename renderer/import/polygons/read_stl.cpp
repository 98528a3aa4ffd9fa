// Tells the two forms of STL apart, and reads either.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/read_stl.h"

#include "renderer/import/polygons/text_scanner.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>

namespace kindling::polygons {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in the file");

constexpr size_t kHeaderBytes = 84, kFacetBytes = 50;

uint64_t declared_bytes(gltf::Bytes file) {
  uint32_t count = 0;
  std::memcpy(&count, file.data() + 80, sizeof count);
  return kHeaderBytes + uint64_t{kFacetBytes} * count;
}

void read_binary(gltf::Bytes file, PolygonBuilder& builder) {
  const size_t count = (file.size() - kHeaderBytes) / kFacetBytes;
  builder.charge(4 * uint64_t{count}, "");
  for (size_t facet = 0; facet < count; ++facet) {
    std::array<float, 9> numbers{};
    std::memcpy(numbers.data(), file.data() + kHeaderBytes + facet * kFacetBytes + 12, sizeof numbers);
    std::array<uint32_t, 3> corners{};
    for (size_t c = 0; c < 3; ++c)
      corners[c] = builder.add_shared_vertex({numbers[3 * c], numbers[3 * c + 1], numbers[3 * c + 2]});
    builder.add_polygon(corners, "");
  }
}

std::string lower(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

void read_text(std::string_view text, PolygonBuilder& builder) {
  TextScanner scanner(text);
  builder.charge(text.size() / 16, ""); // a vertex has at least as many bytes
  std::vector<uint32_t> corners;
  bool in_loop = false;
  while (scanner.next_line()) {
    const std::string word = lower(scanner.word());
    if (word == "outer") {
      if (in_loop) gltf::fail(scanner.place(), "a loop within a loop; 'endloop' is expected before");
      in_loop = true;
      corners.clear();
    } else if (word == "vertex") {
      if (!in_loop) gltf::fail(scanner.place(), "a vertex outside of a loop; 'outer loop' is expected before");
      V3f position;
      for (int k = 0; k < 3; ++k) {
        const std::string_view number = scanner.word();
        const auto value = to_number(number);
        if (!value) gltf::fail(scanner.place(), fmt::format("{}, expected three numbers", gltf::in_quotes(number)));
        position[k] = static_cast<float>(*value);
      }
      corners.push_back(builder.add_shared_vertex(position));
    } else if (word == "endloop") {
      if (!in_loop) gltf::fail(scanner.place(), "'endloop' without a loop");
      in_loop = false;
      builder.add_polygon(corners, scanner.place());
    } else if (!word.empty() && word != "solid" && word != "facet" && word != "endfacet" && word != "endsolid" &&
               word != "color") {
      gltf::fail(scanner.place(), fmt::format("{}, expected facet, outer, vertex, endloop, endfacet or endsolid",
                                              gltf::in_quotes(word)));
    }
  }
  if (in_loop) gltf::fail(scanner.place(), "the file ends within a facet");
}

} // namespace

void read_stl(gltf::Bytes file, PolygonBuilder& builder) {
  const bool named_text = gltf::as_text(file).starts_with("solid");
  if (file.size() >= kHeaderBytes) {
    const uint64_t declared = declared_bytes(file);
    if (declared == file.size() || (!named_text && declared < file.size()))
      return read_binary(file.first(declared), builder);
    if (!named_text)
      gltf::fail("", fmt::format("{} bytes, but {} go with the {} facets that it declares", file.size(), declared,
                                 (declared - kHeaderBytes) / kFacetBytes));
  } else if (!named_text) {
    gltf::fail("", fmt::format("{} bytes; a binary STL file has at least {}, one of text begins with 'solid'",
                               file.size(), kHeaderBytes));
  }
  read_text(gltf::as_text(file), builder);
}

} // namespace kindling::polygons
