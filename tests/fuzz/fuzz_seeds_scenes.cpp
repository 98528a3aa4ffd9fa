// fuzz_seeds_scenes FOLDER: writes seeds of compressed geometry, and of files with faults.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/meshopt_fixtures.h"
#include "tests/import/slips.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

using namespace kindling::test;

namespace {

std::filesystem::path out;

void write(const char* kind, std::string_view bytes) {
  static int number = 0;
  std::filesystem::create_directories(out / kind);
  std::ofstream(out / kind / std::to_string(number++), std::ios::binary) << bytes;
}

constexpr int kSide = 5; // vertices along the side of a grid

struct DracoChoice {
  bool sequential;
  int attributes; // positions, normals, texture coordinates, joints
  int bits;       // of quantization; 0: none
  int speed;
};

// The first byte is that of fuzz_draco.cpp.
std::string draco_grid(const DracoChoice& choice) {
  constexpr uint32_t kVertices = kSide * kSide;
  draco::Mesh mesh;
  mesh.set_num_points(kVertices);
  constexpr draco::GeometryAttribute::Type kTypes[] = {
      draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL, draco::GeometryAttribute::TEX_COORD,
      draco::GeometryAttribute::GENERIC};
  constexpr int8_t kComponents[] = {3, 3, 2, 4};
  for (int a = 0; a < choice.attributes; ++a) {
    const bool joints = a == 3;
    const int8_t components = kComponents[a];
    draco::GeometryAttribute attribute;
    attribute.Init(kTypes[a], nullptr, static_cast<uint8_t>(components), joints ? draco::DT_UINT16 : draco::DT_FLOAT32,
                   false, (joints ? 2 : 4) * int64_t{components}, 0);
    const int id = mesh.AddAttribute(attribute, true, kVertices);
    for (uint32_t i = 0; i < kVertices; ++i) {
      const auto x = static_cast<float>(i % kSide), y = static_cast<float>(i / kSide);
      const float values[] = {a == 1 ? 0.0f : x, a == 1 ? 0.6f : y, a == 1 ? 0.8f : x * y / 9.0f};
      const uint16_t integers[] = {static_cast<uint16_t>(i), 1, 0, 3};
      mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                            joints ? static_cast<const void*>(integers) : values);
    }
  }
  for (uint32_t y = 0; y + 1 < kSide; ++y)
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = y * kSide + x;
      mesh.AddFace({draco::PointIndex(a), draco::PointIndex(a + 1), draco::PointIndex(a + kSide)});
      mesh.AddFace({draco::PointIndex(a + 1), draco::PointIndex(a + kSide + 1), draco::PointIndex(a + kSide)});
    }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(choice.sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(choice.speed, choice.speed);
  if (choice.bits > 0)
    for (int a = 0; a < 3; ++a) encoder.SetAttributeQuantization(kTypes[a], choice.bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return static_cast<char>((choice.attributes - 1) << 2) + std::string(buffer.data(), buffer.size());
}

void write_draco() {
  for (const bool sequential : {false, true})
    for (int attributes = 1; attributes <= 4; ++attributes)
      for (const int bits : {0, 11})
        for (const int speed : {0, 5, 10})
          if (const std::string data = draco_grid({sequential, attributes, bits, speed}); !data.empty())
            write("draco", data);
}

// The first eight bytes are those of fuzz_meshopt.cpp.
void write_meshopt(int extension, int mode, int filter, size_t stride, size_t count, std::string_view stream) {
  const char choices[] = {static_cast<char>(extension),
                          static_cast<char>(mode),
                          static_cast<char>(filter),
                          static_cast<char>(stride),
                          static_cast<char>(count),
                          static_cast<char>(count >> 8U),
                          0,
                          0};
  write("meshopt", std::string(choices, sizeof choices).append(stream));
}

void write_streams() {
  constexpr size_t kVertices = kSide * kSide;
  std::vector<unsigned> indices;
  for (unsigned i = 0; i + kSide + 1 < kVertices; ++i)
    if (i % kSide + 1 < kSide) indices.insert(indices.end(), {i, i + 1, i + kSide, i + 1, i + kSide + 1, i + kSide});
  std::vector<unsigned char> bytes(4096);
  const auto text = [&](size_t size) {
    return std::string(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  };
  for (const size_t stride : {size_t{4}, size_t{8}, size_t{12}, size_t{16}, size_t{64}}) {
    std::vector<unsigned char> values(kVertices * stride);
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<unsigned char>(i / stride * (i % stride + 1));
    const std::string stream =
        text(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values.data(), kVertices, stride));
    for (int filter = 0; filter < 4; ++filter) write_meshopt(0, 0, filter, stride, kVertices, stream);
  }
  for (const int version : {0, 1}) {
    meshopt_encodeIndexVersion(version);
    const std::string triangles =
        text(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
    const std::string sequence =
        text(meshopt_encodeIndexSequence(bytes.data(), bytes.size(), indices.data(), indices.size()));
    for (const size_t stride : {size_t{2}, size_t{4}}) {
      write_meshopt(0, 1, 0, stride, indices.size(), triangles);
      write_meshopt(1, 2, 0, stride, indices.size(), sequence);
    }
  }
  for (const MeshoptFixture& fixture : meshopt_fixtures())
    write_meshopt(1, 0, std::string_view(fixture.filter) == "COLOR" ? 4 : 0, fixture.stride, fixture.count,
                  from_base64(fixture.encoded));
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds_scenes FOLDER\n");
    return 2;
  }
  out = argv[1];
  write_draco();
  write_streams();
  write("gltf", sound_file().gltf());
  write("glb", sound_file().glb());
  for (const Slip& slip : slips()) write("gltf", with_slip(slip).gltf());
  for (const DataSlip& slip : data_slips()) {
    GltfBuilder builder = sound_file();
    slip.change(builder);
    write("glb", builder.glb());
  }
  for (const ContainerSlip& slip : container_slips()) {
    std::string bytes = sound_file().glb();
    slip.change(bytes);
    write("glb", bytes);
  }
  return 0;
}
