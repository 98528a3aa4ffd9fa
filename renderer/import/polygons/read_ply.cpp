// Parses the header, and reads elements by its types.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/read_ply.h"

#include "renderer/import/polygons/text_scanner.h"
#include "renderer/texture/srgb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

namespace kindling::polygons {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers of big-endian files are turned around");

enum class Type : uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
struct TypeName {
  std::string_view name;
  Type type;
};
constexpr TypeName kTypes[] = {
    {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
    {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
    {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
    {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};
constexpr size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
constexpr size_t kMaxElements = 64, kMaxProperties = 256;

constexpr size_t size_of(Type type) { return kSizes[static_cast<size_t>(type)]; }
constexpr bool is_integer(Type type) { return type < Type::float32; }

struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type; // of a list
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Form { text, little_endian, big_endian };

struct Header {
  Form form = Form::text;
  std::vector<Element> elements;
};

Type parse_type(TextScanner& scanner) {
  const std::string_view word = scanner.word();
  for (const auto& [name, type] : kTypes)
    if (word == name) return type;
  gltf::fail(scanner.place(), fmt::format("type {}, expected char, uchar, short, ushort, int, uint, float or double",
                                          gltf::in_quotes(word)));
}

void parse_property(TextScanner& scanner, Header& header) {
  if (header.elements.empty()) gltf::fail(scanner.place(), "a property before any element");
  std::vector<Property>& properties = header.elements.back().properties;
  if (properties.size() >= kMaxProperties)
    gltf::fail(scanner.place(), fmt::format("more than {} properties of one element", kMaxProperties));
  Property& property = properties.emplace_back();
  TextScanner ahead = scanner;
  if (ahead.word() == "list") {
    (void)scanner.word();
    property.count_type = parse_type(scanner);
    if (!is_integer(*property.count_type)) gltf::fail(scanner.place(), "a list whose length is no integer");
  }
  property.type = parse_type(scanner);
  property.name = scanner.word();
}

Header parse_header(TextScanner& scanner) {
  Header header;
  if (!scanner.next_line() || scanner.word() != "ply") gltf::fail("line 1", "expected 'ply'");
  bool formatted = false;
  while (scanner.next_line()) {
    const std::string_view word = scanner.word();
    if (word == "end_header") {
      if (!formatted) gltf::fail(scanner.place(), "no line 'format'");
      return header;
    }
    if (word == "format") {
      const std::string_view form = scanner.word();
      formatted = true;
      if (form == "ascii")
        header.form = Form::text;
      else if (form == "binary_little_endian")
        header.form = Form::little_endian;
      else if (form == "binary_big_endian")
        header.form = Form::big_endian;
      else
        gltf::fail(scanner.place(), fmt::format("format {}, expected ascii, binary_little_endian or binary_big_endian",
                                                gltf::in_quotes(form)));
    } else if (word == "element") {
      if (header.elements.size() >= kMaxElements)
        gltf::fail(scanner.place(), fmt::format("more than {} elements", kMaxElements));
      Element& element = header.elements.emplace_back();
      element.name = scanner.word();
      const std::string_view count = scanner.word();
      const auto value = to_integer(count);
      if (!value || *value < 0)
        gltf::fail(scanner.place(), fmt::format("{}, expected a count", gltf::in_quotes(count)));
      element.count = static_cast<uint64_t>(*value);
    } else if (word == "property") {
      parse_property(scanner, header);
    } else if (!word.empty() && word != "comment" && word != "obj_info") {
      gltf::fail(scanner.place(), fmt::format("{}, expected element, property or end_header", gltf::in_quotes(word)));
    }
  }
  gltf::fail("", "the header has no end_header");
}

// Numbers of the body, one after the other.
class Body {
 public:
  Body(Form form, TextScanner scanner) : form_(form), scanner_(scanner), bytes_(scanner.rest()) {}

  [[nodiscard]] Form form() const { return form_; }
  [[nodiscard]] size_t bytes_left() const {
    return form_ == Form::text ? scanner_.line().size() + scanner_.rest().size() : bytes_.size();
  }

  double read(Type type, const Element& element, uint64_t index) {
    if (form_ == Form::text) {
      const std::string_view word = scanner_.word_of_any_line();
      if (word.empty()) ends(element, index);
      const auto value = to_number(word);
      if (!value)
        gltf::fail(scanner_.place(), fmt::format("{}, expected a number of {} {}", gltf::in_quotes(word),
                                                 gltf::in_quotes(element.name), index));
      return *value;
    }
    const size_t size = size_of(type);
    if (bytes_.size() < size) ends(element, index);
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), bytes_.data(), size);
    bytes_.remove_prefix(size);
    if (form_ == Form::big_endian) {
      std::reverse(raw.begin(), raw.end()); // all eight, for GCC warns where their number varies
      std::memmove(raw.data(), raw.data() + raw.size() - size, size);
    }
    switch (type) {
    case Type::int8: return as<int8_t>(raw);
    case Type::uint8: return as<uint8_t>(raw);
    case Type::int16: return as<int16_t>(raw);
    case Type::uint16: return as<uint16_t>(raw);
    case Type::int32: return as<int32_t>(raw);
    case Type::uint32: return as<uint32_t>(raw);
    case Type::float32: return static_cast<double>(as<float>(raw));
    case Type::float64: return as<double>(raw);
    }
    return 0.0;
  }

  // The length of a list, which fits into the rest of the file.
  size_t read_length(const Property& list, const Element& element, uint64_t index) {
    const double length = read(*list.count_type, element, index);
    const size_t bytes = form_ == Form::text ? 1 : size_of(list.type);
    if (!(length >= 0.0) || length != std::floor(length) ||
        length > static_cast<double>(bytes_left()) / static_cast<double>(bytes) + 1.0)
      gltf::fail(fmt::format("{} {}", gltf::in_quotes(element.name), index),
                 fmt::format("a list of {:g} numbers; the rest of the file has {} bytes", length, bytes_left()));
    return static_cast<size_t>(length);
  }

 private:
  template <typename Number>
  static Number as(const std::array<char, 8>& raw) {
    Number number;
    std::memcpy(&number, raw.data(), sizeof number);
    return number;
  }
  [[noreturn]] static void ends(const Element& element, uint64_t index) {
    gltf::fail("",
               fmt::format("the file ends within {} {} of {}", gltf::in_quotes(element.name), index, element.count));
  }

  Form form_;
  TextScanner scanner_;
  std::string_view bytes_;
};

// Refuses counts that the rest of the file cannot hold, before memory is allocated.
void check_count(const Element& element, const Body& body, PolygonBuilder& builder) {
  uint64_t bytes = 0;
  for (const Property& property : element.properties)
    bytes += body.form() == Form::text ? 1 : size_of(property.count_type.value_or(property.type));
  if (element.count > body.bytes_left() / std::max<uint64_t>(bytes, 1) + 1)
    gltf::fail("", fmt::format("declares {} of {}, at least {} bytes each; {} bytes are left", element.count,
                               gltf::in_quotes(element.name), bytes, body.bytes_left()));
  builder.charge(element.count * std::max<size_t>(element.properties.size() / 4, 1), gltf::in_quotes(element.name));
}

// The first property of one of these names that is no list.
std::optional<size_t> find(const Element& element, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    for (size_t p = 0; p < element.properties.size(); ++p)
      if (element.properties[p].name == name && !element.properties[p].count_type) return p;
  return std::nullopt;
}

void read_vertices(const Element& element, Body& body, PolygonBuilder& builder) {
  const auto x = find(element, {"x"}), y = find(element, {"y"}), z = find(element, {"z"});
  if (!x || !y || !z) gltf::fail("", "vertices without the properties x, y and z");
  const auto nx = find(element, {"nx"}), ny = find(element, {"ny"}), nz = find(element, {"nz"});
  const auto s = find(element, {"s", "u", "texture_u"}), t = find(element, {"t", "v", "texture_v"});
  const std::array color{find(element, {"red", "r"}), find(element, {"green", "g"}), find(element, {"blue", "b"})};
  const auto alpha = find(element, {"alpha", "a"});
  const bool colored = color[0] && color[1] && color[2];
  Primitive& primitive = builder.primitive();
  if (s && t) primitive.texcoords.emplace_back();
  std::vector<double> values(element.properties.size());
  for (uint64_t i = 0; i < element.count; ++i) {
    for (size_t p = 0; p < values.size(); ++p) {
      const Property& property = element.properties[p];
      if (!property.count_type) {
        values[p] = body.read(property.type, element, i);
        continue;
      }
      for (size_t n = body.read_length(property, element, i); n > 0; --n) (void)body.read(property.type, element, i);
    }
    const auto at = [&](const std::optional<size_t>& property) { return static_cast<float>(values[*property]); };
    builder.add_vertex({at(x), at(y), at(z)});
    if (nx && ny && nz) primitive.normals.emplace_back(at(nx), at(ny), at(nz));
    if (s && t) primitive.texcoords[0].emplace_back(at(s), 1.0f - at(t));
    if (!colored) continue;
    V4f rgba(1.0f);
    for (size_t k = 0; k < 3; ++k)
      rgba[static_cast<int>(k)] = is_integer(element.properties[*color[k]].type)
                                      ? static_cast<float>(decode_srgb(std::clamp(values[*color[k]] / 255.0, 0.0, 1.0)))
                                      : at(color[k]);
    if (alpha) rgba[3] = is_integer(element.properties[*alpha].type) ? at(alpha) / 255.0f : at(alpha);
    for (int k = 0; k < 4; ++k) rgba[k] = std::isfinite(rgba[k]) ? std::clamp(rgba[k], 0.0f, 1.0f) : 1.0f;
    primitive.colors.push_back(rgba);
  }
}

void read_faces(const Element& element, Body& body, PolygonBuilder& builder) {
  const auto is_corners = [](const Property& property) {
    return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  const auto corners = std::find_if(element.properties.begin(), element.properties.end(), is_corners);
  if (corners == element.properties.end() || !is_integer(corners->type))
    gltf::fail("", "faces without a list of integers vertex_indices");
  const size_t vertices = builder.primitive().positions.size();
  std::vector<uint32_t> polygon;
  for (uint64_t i = 0; i < element.count; ++i)
    for (const Property& property : element.properties) {
      if (!property.count_type) {
        (void)body.read(property.type, element, i);
        continue;
      }
      const bool wanted = &property == &*corners;
      if (wanted) polygon.clear();
      for (size_t n = body.read_length(property, element, i); n > 0; --n) {
        const double index = body.read(property.type, element, i);
        if (!wanted) continue;
        if (!(index >= 0.0 && index < static_cast<double>(vertices)) || index != std::floor(index))
          gltf::fail(fmt::format("face {}", i), fmt::format("index {:g}; there are {} vertices", index, vertices));
        polygon.push_back(static_cast<uint32_t>(index));
      }
      if (wanted) {
        builder.charge(polygon.size(), fmt::format("face {}", i));
        builder.add_polygon(polygon, fmt::format("face {}", i));
      }
    }
}

void skip(const Element& element, Body& body) {
  for (uint64_t i = 0; i < element.count; ++i)
    for (const Property& property : element.properties)
      for (size_t n = property.count_type ? body.read_length(property, element, i) : 1; n > 0; --n)
        (void)body.read(property.type, element, i);
}

} // namespace

void read_ply(gltf::Bytes file, PolygonBuilder& builder) {
  TextScanner scanner(gltf::as_text(file));
  const Header header = parse_header(scanner);
  Body body(header.form, scanner);
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    check_count(element, body, builder);
    if (element.name == "vertex" && !has_vertices) {
      read_vertices(element, body, builder);
      has_vertices = true;
    } else if (element.name == "face") {
      if (!has_vertices) gltf::fail("", "faces before the vertices");
      read_faces(element, body, builder);
    } else if (!element.properties.empty()) {
      skip(element, body);
    }
  }
}

} // namespace kindling::polygons
