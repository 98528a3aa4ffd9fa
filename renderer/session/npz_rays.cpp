// Unpacks a zip archive of .npy arrays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/npz_rays.h"

#include "renderer/base/text.h"
#include "renderer/session/ray_file.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in the file");

// A fault of the file; the message lacks its name.
struct NpzFault {
  std::string message;
};

template <typename Number>
Number load(std::string_view bytes, size_t at) {
  if (at > bytes.size() || bytes.size() - at < sizeof(Number)) throw NpzFault{"ends within its archive's directory"};
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

std::string_view part(std::string_view bytes, uint64_t at, uint64_t size) {
  if (at > bytes.size() || size > bytes.size() - at) throw NpzFault{"ends within an array"};
  return bytes.substr(at, size);
}

std::string inflate_raw(std::string_view packed, uint64_t size) {
  constexpr uint64_t kLargestRatio = 1032; // of deflate
  if (size / kLargestRatio > packed.size()) throw NpzFault{"declares more bytes than its compressed data can hold"};
  std::string bytes(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw NpzFault{"cannot be decompressed"};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int status = inflate(&stream, Z_FINISH);
  const bool complete = status == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!complete) throw NpzFault{"has damaged compressed data"};
  return bytes;
}

// Bounds of the memory that a file may take: about 3 GB in all, most of it rays.
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;                        // and of its arrays, unpacked
constexpr uint64_t kMaxRays = uint64_t{1} << 24, kMaxNumbers = 3 * kMaxRays; // of an array

constexpr std::string_view kArrays[] = {"origins", "directions", "t_min", "t_max", "time"};

// An array in the directory of a zip archive.
struct Member {
  std::string name; // without ".npy"
  uint16_t method = 0;
  uint32_t crc = 0, packed_bytes = 0, bytes = 0, local = 0;
};

// The arrays of the name list above in the directory of a zip archive (APPNOTE.TXT 6.3.10).
std::vector<Member> find_members(std::string_view file) {
  constexpr size_t kEndBytes = 22, kEntryBytes = 46, kMaxEntries = 64;
  size_t end = std::string_view::npos;
  if (file.size() >= kEndBytes) end = file.rfind("PK\x05\x06", file.size() - kEndBytes);
  if (end == std::string_view::npos)
    throw NpzFault{"is no .npz file, or is cut off: it has no directory of a zip archive"};
  const auto count = load<uint16_t>(file, end + 10);
  size_t at = load<uint32_t>(file, end + 16);
  if (count > kMaxEntries) throw NpzFault{"has " + std::to_string(count) + " arrays; at most 64 are read"};
  std::vector<Member> members;
  uint64_t all_bytes = 0;
  for (uint16_t i = 0; i < count; ++i) {
    if (part(file, at, 4) != "PK\x01\x02") throw NpzFault{"has a damaged directory"};
    Member member;
    member.method = load<uint16_t>(file, at + 10);
    member.crc = load<uint32_t>(file, at + 16);
    member.packed_bytes = load<uint32_t>(file, at + 20);
    member.bytes = load<uint32_t>(file, at + 24);
    member.local = load<uint32_t>(file, at + 42);
    const auto name_bytes = load<uint16_t>(file, at + 28), extra_bytes = load<uint16_t>(file, at + 30),
               comment_bytes = load<uint16_t>(file, at + 32);
    member.name = part(file, at + kEntryBytes, name_bytes);
    at += kEntryBytes + size_t{name_bytes} + extra_bytes + comment_bytes;
    if (!member.name.ends_with(".npy")) continue;
    member.name.resize(member.name.size() - 4);
    if (std::find(std::begin(kArrays), std::end(kArrays), member.name) == std::end(kArrays)) continue;
    for (const Member& other : members)
      if (other.name == member.name) throw NpzFault{"has two arrays " + member.name};
    all_bytes += member.bytes;
    members.push_back(std::move(member));
  }
  if (all_bytes > kMaxFileBytes)
    throw NpzFault{"has arrays of " + std::to_string(all_bytes) + " bytes; at most " + std::to_string(kMaxFileBytes) +
                   " (1 GiB) are read: write fewer rays, or float32"};
  return members;
}

std::string unpack(std::string_view file, const Member& member) {
  constexpr size_t kLocalBytes = 30;
  if (part(file, member.local, 4) != "PK\x03\x04") throw NpzFault{"has a damaged array " + member.name};
  const size_t data = size_t{member.local} + kLocalBytes + load<uint16_t>(file, size_t{member.local} + 26) +
                      load<uint16_t>(file, size_t{member.local} + 28);
  const std::string_view stored = part(file, data, member.packed_bytes);
  if (member.method != 0 && member.method != 8)
    throw NpzFault{"has an array " + member.name + " of compression method " + std::to_string(member.method) +
                   "; 0 and 8 can be read"};
  std::string bytes = member.method == 0 ? std::string(stored) : inflate_raw(stored, member.bytes);
  if (bytes.size() != member.bytes ||
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())) != member.crc)
    throw NpzFault{"has a damaged array " + member.name};
  return bytes;
}

struct Array {
  std::vector<uint64_t> shape;
  std::vector<float> values; // row by row
};

// The text behind "'key':" in the header of an array.
std::string_view value_of(std::string_view header, std::string_view key, const std::string& name) {
  const size_t at = header.find("'" + std::string(key) + "'");
  const size_t colon = at == std::string_view::npos ? at : header.find(':', at);
  if (colon == std::string_view::npos) throw NpzFault{"array " + name + " has no '" + std::string(key) + "'"};
  header.remove_prefix(colon + 1);
  header.remove_prefix(std::min(header.find_first_not_of(' '), header.size()));
  return header;
}

std::string shape_text(const std::vector<uint64_t>& shape) {
  std::string text = "(";
  for (const uint64_t& size : shape)
    text += std::to_string(size) + (shape.size() == 1 ? "," : &size == &shape.back() ? "" : ", ");
  return text + ")";
}

// The format .npy, versions 1 to 3 (numpy.lib.format).
Array parse_array(const std::string& name, std::string_view bytes) {
  if (bytes.size() < 12 || !bytes.starts_with("\x93NUMPY")) throw NpzFault{"array " + name + " is no .npy array"};
  const bool wide = bytes[6] > 1;
  const size_t header_bytes = wide ? load<uint32_t>(bytes, 8) : load<uint16_t>(bytes, 8), begin = wide ? 12 : 10;
  const std::string_view header = part(bytes, begin, header_bytes);
  std::string_view data = bytes.substr(begin + header_bytes);
  const std::string_view type = value_of(header, "descr", name).substr(0, 5);
  const bool is_double = type == "'<f8'" || type == "'>f8'", turned = type.size() > 1 && type[1] == '>';
  if (!is_double && type != "'<f4'" && type != "'>f4'")
    throw NpzFault{"array " + name + " has the type " + printable(type) + "; float32 and float64 can be read"};
  const bool by_columns = value_of(header, "fortran_order", name).starts_with("True");
  Array array;
  std::string_view shape = value_of(header, "shape", name);
  shape = shape.substr(0, shape.find(')'));
  uint64_t count = 1;
  for (size_t i = 0; i < shape.size();) {
    if (shape[i] < '0' || shape[i] > '9') {
      if (std::string_view("(, ").find(shape[i]) == std::string_view::npos)
        throw NpzFault{"array " + name + " has a damaged shape"};
      ++i;
      continue;
    }
    if (array.shape.size() == 2) throw NpzFault{"array " + name + " has more than two dimensions"};
    uint64_t size = 0;
    for (; i < shape.size() && shape[i] >= '0' && shape[i] <= '9'; ++i)
      size = std::min<uint64_t>(size * 10 + static_cast<uint64_t>(shape[i] - '0'), kMaxNumbers + 1);
    array.shape.push_back(size);
    if (count > kMaxNumbers / std::max<uint64_t>(size, 1))
      throw NpzFault{"array " + name + " is too large; at most " + std::to_string(kMaxRays) + " rays are read"};
    count *= size;
  }
  const size_t element = is_double ? 8 : 4;
  if (count > data.size() / element || data.size() != count * element)
    throw NpzFault{"array " + name + " of shape " + shape_text(array.shape) + " has " + std::to_string(data.size()) +
                   " bytes"};
  array.values.resize(count);
  const uint64_t rows = array.shape.empty() ? 1 : array.shape[0], columns = rows > 0 ? count / rows : 0;
  for (uint64_t i = 0; i < count; ++i) {
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), data.data() + i * element, element);
    if (turned) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(element));
    const uint64_t to = by_columns && array.shape.size() == 2 ? i % rows * columns + i / rows : i;
    if (is_double) {
      double value;
      std::memcpy(&value, raw.data(), sizeof value);
      array.values[to] = static_cast<float>(value);
    } else {
      std::memcpy(&array.values[to], raw.data(), sizeof(float));
    }
  }
  return array;
}

using Arrays = std::map<std::string, Array, std::less<>>;

// Unpacks one array after the other, so that the bytes of only one are held beside the file's.
Arrays parse_arrays(std::string_view file) {
  Arrays arrays;
  for (const Member& member : find_members(file))
    arrays.emplace(member.name, parse_array(member.name, unpack(file, member)));
  return arrays;
}

RayRecording make_rays(const Arrays& arrays) {
  const auto find = [&](const std::string& name) {
    const auto found = arrays.find(name);
    return found == arrays.end() ? nullptr : &found->second;
  };
  const auto vectors = [&](const std::string& name) -> const Array& {
    const Array* array = find(name);
    if (array == nullptr)
      throw NpzFault{"has no array '" + name + "'; origins and directions of shape (N, 3) are needed"};
    if (array->shape.size() != 2 || array->shape[1] != 3)
      throw NpzFault{"array " + name + " has the shape " + shape_text(array->shape) + ", expected (N, 3)"};
    return *array;
  };
  const Array &origins = vectors("origins"), &directions = vectors("directions");
  const uint64_t count = origins.shape[0];
  if (directions.shape[0] != count)
    throw NpzFault{"has " + std::to_string(count) + " origins and " + std::to_string(directions.shape[0]) +
                   " directions"};
  if (count == 0) throw NpzFault{"has no rays"};
  const auto numbers = [&](const std::string& name, float otherwise) {
    const Array* array = find(name);
    if (array == nullptr) return std::vector<float>(count, otherwise);
    if (array->shape.empty()) return std::vector<float>(count, array->values[0]);
    if (array->shape.size() != 1 || array->shape[0] != count)
      throw NpzFault{"array " + name + " has the shape " + shape_text(array->shape) + ", expected (" +
                     std::to_string(count) + ",)"};
    return array->values;
  };
  const std::vector<float> t_min = numbers("t_min", 0.0f),
                           t_max = numbers("t_max", std::numeric_limits<float>::infinity()),
                           time = numbers("time", 0.0f);
  RaySet rays{"nearest", RayQuery::nearest, 0, std::vector<accel::Ray>(count)};
  for (uint64_t i = 0; i < count; ++i) {
    accel::Ray& ray = rays.rays[i];
    const float *o = &origins.values[3 * i], *d = &directions.values[3 * i];
    ray = {.origin = {o[0], o[1], o[2]}, .t_min = t_min[i], .direction = {d[0], d[1], d[2]}, .t_max = t_max[i]};
    ray.time = time[i];
    ray.index = static_cast<uint32_t>(i);
    if (!is_valid_ray(ray))
      throw NpzFault{"ray " + std::to_string(i) +
                     " is none: origin and direction must be finite, the direction not zero, its ends numbers"};
  }
  RayRecording recording;
  recording.sets.push_back(rays);
  rays.name = "any-hit";
  rays.query = RayQuery::any_hit;
  recording.sets.push_back(std::move(rays));
  return recording;
}

} // namespace

Result<RayRecording> read_npz_rays(const std::filesystem::path& path) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorKind::input_output, path.string() + ": " + what};
  };
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return refuse("is no file that can be read"); // a pipe would block
  const uint64_t size = std::filesystem::file_size(path, code);
  std::ifstream stream(path, std::ios::binary);
  if (code || !stream) return refuse("cannot be read");
  if (size > kMaxFileBytes)
    return refuse("has " + std::to_string(size) + " bytes; at most " + std::to_string(kMaxFileBytes) +
                  " (1 GiB) are read: write fewer rays, or float32");
  std::string file(size, '\0');
  stream.read(file.data(), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(stream.gcount()) != size) return refuse("cannot be read to its end");
  try {
    const Arrays arrays = parse_arrays(file);
    file = std::string(); // freed before the rays are made
    return make_rays(arrays);
  } catch (const NpzFault& fault) {
    return refuse(fault.message);
  }
}

} // namespace kindling
