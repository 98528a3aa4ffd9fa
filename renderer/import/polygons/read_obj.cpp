// Reads OBJ line by line, and makes one vertex of each combination of indices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/read_obj.h"

#include "renderer/import/polygons/text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

namespace kindling::polygons {

namespace {

constexpr uint32_t kAbsent = 0xffffffffU;

// Indices from 0 into positions, texture coordinates and normals.
using Corner = std::array<uint32_t, 3>;

struct CornerHash {
  size_t operator()(const Corner& corner) const {
    uint64_t hash = 0;
    for (const uint32_t index : corner) hash = (hash ^ index) * 0x9e3779b97f4a7c15ULL + (hash >> 29);
    return hash;
  }
};

class ObjReader {
 public:
  ObjReader(std::string_view text, gltf::Warnings& warnings, PolygonBuilder& builder)
      : scanner_(text), warnings_(warnings), builder_(builder) {
    builder_.charge(text.size() / 4, ""); // a corner has at least as many bytes
  }

  void read() {
    while (scanner_.next_line()) {
      if (scanner_.line().ends_with('\\')) gltf::fail(scanner_.place(), "a line that continues in the next one");
      const std::string_view word = scanner_.word();
      if (word == "v")
        positions_.push_back(read_numbers<V3f>(3));
      else if (word == "vn")
        normals_.push_back(read_numbers<V3f>(3));
      else if (word == "vt")
        texcoords_.push_back(read_numbers<V2f>(2));
      else if (word == "f")
        read_face();
    }
    make_vertices();
  }

 private:
  template <typename Vector>
  Vector read_numbers(int count) {
    Vector values(0.0f);
    for (int k = 0; k < count; ++k) {
      const std::string_view word = scanner_.word();
      if (word.empty() && count == 2 && k == 1) break; // a texture of one dimension
      const auto value = to_number(word);
      if (!value) gltf::fail(scanner_.place(), fmt::format("{}, expected {} numbers", gltf::in_quotes(word), count));
      values[k] = static_cast<float>(*value);
    }
    return values;
  }

  // "3", "-1": from 1, or from the end.
  [[nodiscard]] uint32_t read_index(std::string_view text, size_t size, const char* of_what) const {
    const auto index = to_integer(text);
    if (!index) gltf::fail(scanner_.place(), fmt::format("{}, expected an index", gltf::in_quotes(text)));
    const auto count = static_cast<int64_t>(size);
    if (*index == 0 || *index > count || *index < -count)
      gltf::fail(scanner_.place(), fmt::format("index {}; there are {} {} so far", *index, size, of_what));
    return static_cast<uint32_t>(*index > 0 ? *index - 1 : count + *index);
  }

  // "1", "1/2", "1//3" or "1/2/3".
  Corner read_corner(std::string_view word) const {
    std::array<std::string_view, 3> parts;
    size_t count = 0;
    for (std::string_view rest = word;;) {
      if (count == 3) gltf::fail(scanner_.place(), fmt::format("{}, expected v/vt/vn", gltf::in_quotes(word)));
      const size_t slash = rest.find('/');
      parts[count++] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    return {read_index(parts[0], positions_.size(), "vertices"),
            parts[1].empty() ? kAbsent : read_index(parts[1], texcoords_.size(), "texture coordinates"),
            parts[2].empty() ? kAbsent : read_index(parts[2], normals_.size(), "normals")};
  }

  void read_face() {
    const size_t first = corners_.size();
    for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
      if (word.starts_with('#')) break;
      corners_.push_back(read_corner(word));
    }
    faces_.push_back({first, corners_.size() - first, scanner_.line_number()});
  }

  void make_vertices() {
    Primitive& primitive = builder_.primitive();
    const auto all_have = [&](size_t part) {
      return !corners_.empty() && std::all_of(corners_.begin(), corners_.end(),
                                              [part](const Corner& corner) { return corner[part] != kAbsent; });
    };
    const bool texcoords = all_have(1), normals = all_have(2);
    if (!normals && !normals_.empty()) warnings_.add("normals", "", "not every corner has a normal: faces are flat");
    if (texcoords) primitive.texcoords.emplace_back();
    std::unordered_map<Corner, uint32_t, CornerHash> vertices;
    std::vector<uint32_t> polygon;
    for (const Face& face : faces_) {
      polygon.clear();
      for (size_t i = face.first; i < face.first + face.count; ++i) {
        const Corner corner{corners_[i][0], texcoords ? corners_[i][1] : kAbsent, normals ? corners_[i][2] : kAbsent};
        const auto [found, is_new] = vertices.try_emplace(corner, 0);
        if (is_new) {
          found->second = builder_.add_vertex(positions_[corner[0]]);
          // The image's first row is at the top in glTF, at the bottom in OBJ.
          if (texcoords) primitive.texcoords[0].emplace_back(texcoords_[corner[1]].x, 1.0f - texcoords_[corner[1]].y);
          if (normals) primitive.normals.push_back(normals_[corner[2]]);
        }
        polygon.push_back(found->second);
      }
      builder_.add_polygon(polygon, fmt::format("line {}", face.line));
    }
  }

  struct Face {
    size_t first, count, line;
  };

  TextScanner scanner_;
  gltf::Warnings& warnings_;
  PolygonBuilder& builder_;
  std::vector<V3f> positions_;
  std::vector<V3f> normals_;
  std::vector<V2f> texcoords_;
  std::vector<Corner> corners_;
  std::vector<Face> faces_;
};

} // namespace

void read_obj(gltf::Bytes file, gltf::Warnings& warnings, PolygonBuilder& builder) {
  ObjReader(gltf::as_text(file), warnings, builder).read();
}

} // namespace kindling::polygons
