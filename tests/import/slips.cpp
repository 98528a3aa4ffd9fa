// The sound file, and JSON changes of it.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/slips.h"

namespace kindling::test {

GltfBuilder sound_file() {
  GltfBuilder b;
  b.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
  b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3");
  b.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
  b.accessor<float>(std::vector<float>(12, 1.0f), kFloat, "VEC4");
  b.accessor<uint16_t>({0, 1, 2}, kUnsignedShort, "SCALAR");
  b.accessor<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, kUnsignedByte, "VEC4");
  b.accessor<float>({.5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4");
  std::vector<float> matrices(32, 0.0f);
  for (size_t i = 0; i < 8; ++i) matrices[i / 4 * 16 + i % 4 * 5] = 1.0f;
  b.accessor(matrices, kFloat, "MAT4");
  b.accessor<float>({0, 1}, kFloat, "SCALAR");
  b.accessor<float>({0, 0, 0, 0.1f, 0, 0}, kFloat, "VEC3");
  b.accessor<float>({0, 1}, kFloat, "SCALAR");
  b.accessor<float>({0, 0, 0, 1, 0, 0, 1, 0}, kFloat, "VEC4");
  b.accessor<float>({0, 0, 0.1f, 0, 0, 0, 0, 0, 0}, kFloat, "VEC3");
  b.push("images", {{"bufferView", b.view(from_base64(kPngBase64))}, {"mimeType", "image/png"}});
  const json rest = json::parse(R"({
    "extensionsUsed": ["KHR_lights_punctual"],
    "scene": 0,
    "scenes": [{"nodes": [0, 1, 2, 3, 4, 6, 7, 8, 9]}],
    "nodes": [
      {"mesh": 0, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
      {"camera": 0, "translation": [0.4, 0.3, 2]},
      {"translation": [0, 0, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
      {"mesh": 1, "skin": 0},
      {"children": [5], "translation": [0.3, 0, 0]}, {},
      {"mesh": 2, "weights": [0.5], "translation": [-0.2, 0, -0.1]},
      {"translation": [1, 1, 3], "extensions": {"KHR_lights_punctual": {"light": 1}}},
      {"camera": 1, "translation": [0, 0, 2]},
      {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5, 0, 1]}],
    "meshes": [
      {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3}, "indices": 4,
                       "material": 0}]},
      {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "JOINTS_0": 5, "WEIGHTS_0": 6}, "material": 1}]},
      {"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 12}], "material": 2}],
       "weights": [0.2]}],
    "materials": [
      {"name": "first", "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true, "emissiveFactor": [0.1, 0.1, 0.1],
       "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": {"index": 0, "texCoord": 0},
                                "metallicFactor": 0.1, "roughnessFactor": 0.5}},
      {"extensions": {
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.2},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.2, "clearcoatRoughnessFactor": 0.1},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.1},
        "KHR_materials_dispersion": {"dispersion": 0.1},
        "KHR_materials_emissive_strength": {"emissiveStrength": 1},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_iridescence": {"iridescenceFactor": 0.2, "iridescenceIor": 1.3},
        "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.1, 0.1], "sheenRoughnessFactor": 0.3},
        "KHR_materials_specular": {"specularFactor": 0.9, "specularColorFactor": [1, 1, 1]},
        "KHR_materials_transmission": {"transmissionFactor": 0.1},
        "KHR_materials_volume": {"thicknessFactor": 0, "attenuationDistance": 2, "attenuationColor": [1, 1, 1]}}},
      {"extensions": {"KHR_materials_pbrSpecularGlossiness": {
         "diffuseFactor": [1, 1, 1, 1], "specularFactor": [0.1, 0.1, 0.1], "glossinessFactor": 0.5}}}],
    "textures": [{"source": 0, "sampler": 0}],
    "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 33071}],
    "skins": [{"joints": [4, 5], "inverseBindMatrices": 7, "skeleton": 4}],
    "cameras": [
      {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 100, "aspectRatio": 1}},
      {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 100}}],
    "extensions": {"KHR_lights_punctual": {"lights": [
      {"type": "spot", "color": [1, 1, 1], "intensity": 20, "range": 50,
       "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
      {"type": "point", "intensity": 10}]}},
    "animations": [{
      "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
                   {"sampler": 1, "target": {"node": 6, "path": "weights"}},
                   {"sampler": 2, "target": {"node": 4, "path": "rotation"}}],
      "samplers": [{"input": 8, "output": 9, "interpolation": "LINEAR"}, {"input": 8, "output": 10},
                   {"input": 8, "output": 11, "interpolation": "STEP"}]}]})");
  b.root.update(rest);
  return b;
}

GltfBuilder with_slip(const Slip& slip) {
  GltfBuilder builder = sound_file();
  // The buffer is part of the JSON, so that it can be changed too.
  builder.root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", data_uri(builder.bin)}}});
  const json::json_pointer pointer{std::string(slip.pointer)};
  if (!slip.value.empty()) {
    builder.root[pointer] = json::parse(slip.value);
  } else if (json& parent = builder.root[pointer.parent_pointer()]; parent.is_array()) {
    parent.erase(std::stoul(pointer.back()));
  } else {
    parent.erase(pointer.back());
  }
  return builder;
}

} // namespace kindling::test
