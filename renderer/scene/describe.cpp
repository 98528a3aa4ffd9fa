// Counts the contents of scenes and poses.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/describe.h"

#include <unordered_set>

namespace kindling {
namespace {

template <typename T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

uint64_t geometry_bytes(const Primitive& primitive) {
  uint64_t bytes = bytes_of(primitive.indices) + bytes_of(primitive.positions) + bytes_of(primitive.normals) +
                   bytes_of(primitive.tangents) + bytes_of(primitive.colors) + bytes_of(primitive.joints) +
                   bytes_of(primitive.weights) + bytes_of(primitive.stroke_offsets);
  for (const auto& set : primitive.texcoords) bytes += bytes_of(set);
  for (const MorphTarget& target : primitive.targets) {
    bytes += bytes_of(target.positions) + bytes_of(target.normals) + bytes_of(target.tangents);
  }
  return bytes;
}

void count_animations(const Scene& scene, SceneStatistics& out) {
  out.animations = scene.animations.size();
  for (const Animation& animation : scene.animations) {
    out.animation_channels += animation.channels.size();
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.times_s.empty()) continue;
      const double first = channel.times_s.front();
      const double last = channel.times_s.back();
      out.first_key_s = std::min(out.first_key_s.value_or(first), first);
      out.last_key_s = std::max(out.last_key_s.value_or(last), last);
    }
  }
}

} // namespace

SceneStatistics describe(const Scene& scene) {
  SceneStatistics out;
  out.scenes = scene.scenes.size();
  out.nodes = scene.nodes.size();
  out.meshes = scene.meshes.size();
  for (const Mesh& mesh : scene.meshes) {
    out.primitives += mesh.primitives.size();
    for (const Primitive& primitive : mesh.primitives) {
      out.triangles += primitive.triangle_count();
      out.vertices += primitive.positions.size();
      out.geometry_bytes += geometry_bytes(primitive);
      out.morph_targets += primitive.targets.size();
    }
  }
  out.materials = scene.materials.size();
  out.textures = scene.textures.size();
  std::unordered_set<const Image*> images;
  for (const SceneTexture& texture : scene.textures) {
    if (!texture.image) {
      ++out.unreadable_textures;
    } else if (images.insert(texture.image.get()).second) {
      out.texture_bytes += texture.image->byte_count();
    }
  }
  out.images = images.size();
  out.skins = scene.skins.size();
  for (const Skin& skin : scene.skins) out.joints += skin.joints.size();
  count_animations(scene, out);
  out.cameras = scene.cameras.size();
  out.lights = scene.lights.size();
  out.variants = scene.variants.size();
  return out;
}

PosedStatistics describe(const Scene& scene, const PosedScene& posed) {
  PosedStatistics out;
  out.mesh_instances = posed.meshes.size();
  std::unordered_set<int> distinct;
  for (const PosedMesh& mesh : posed.meshes) {
    distinct.insert(mesh.mesh);
    out.deformed_meshes += mesh.deformed.empty() ? 0 : 1;
    for (const Primitive& primitive : scene.meshes[static_cast<size_t>(mesh.mesh)].primitives) {
      out.triangles += primitive.triangle_count();
    }
    for (const PosedMesh::Deformed& deformed : mesh.deformed) {
      out.deformed_bytes += bytes_of(deformed.positions) + bytes_of(deformed.normals) + bytes_of(deformed.tangents);
    }
  }
  out.distinct_meshes = distinct.size();
  out.cameras = posed.cameras.size();
  out.lights = posed.lights.size();
  return out;
}

std::string_view name_of(AlphaMode mode) {
  switch (mode) {
  case AlphaMode::opaque: return "OPAQUE";
  case AlphaMode::mask: return "MASK";
  case AlphaMode::blend: return "BLEND";
  }
  return "";
}

std::string_view name_of(SceneCamera::Kind kind) {
  return kind == SceneCamera::Kind::perspective ? "perspective" : "orthographic";
}

std::string_view name_of(PunctualLight::Kind kind) {
  switch (kind) {
  case PunctualLight::Kind::directional: return "directional";
  case PunctualLight::Kind::point: return "point";
  case PunctualLight::Kind::spot: return "spot";
  }
  return "";
}

std::string_view name_of(Interpolation interpolation) {
  switch (interpolation) {
  case Interpolation::step: return "STEP";
  case Interpolation::linear: return "LINEAR";
  case Interpolation::cubic_spline: return "CUBICSPLINE";
  }
  return "";
}

} // namespace kindling
