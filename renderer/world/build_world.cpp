// Builds the World in order: textures, materials, geometry and instances, lights, accelerator.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/build_world.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/world/builtin_environment.h"
#include "renderer/world/emitter_budget.h"
#include "renderer/world/find_contacts.h"
#include "renderer/world/image_light_environment.h"
#include "renderer/world/light_groups/file_light_groups.h"
#include "renderer/world/opacity/build_opacity.h"
#include "renderer/world/persistent_meshes.h"
#include "renderer/world/prepare_geometry.h"
#include "renderer/world/prepare_material.h"
#include "renderer/world/punctual_lights.h"
#include "renderer/world/scene_changes.h"
#include "renderer/world/texture_table.h"
#include "renderer/world/world_changes.h"
#include "renderer/world/world_parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>
#include <vector>

namespace kindling {
class WorldBuilder {
 public:
  WorldBuilder(Scene& scene, PosedScene posed, const WorldOptions& options, WorldParts& parts,
               const CancelToken* cancel, ProgressListener* listener)
      : scene_(scene), posed_(std::move(posed)), options_(options), parts_(parts), cancel_(cancel), listener_(listener),
        world_(new World()) {}

  Result<std::unique_ptr<World>> build() {
    const auto start = std::chrono::steady_clock::now();
    BuildTimes& times = world_->statistics_.times;
    Stopwatch clock;
    scene_.materials.push_back(Material{.name = "default"}); // glTF's default material is last
    if (Result<void> prepared = prepare_materials(); !prepared) return prepared.error();
    times.textures = clock.lap();
    if (cancelled()) return cancelled_error();
    take_geometry();
    times.geometry = clock.lap();
    if (cancelled()) return cancelled_error();
    collect_lights();
    times.lights = clock.lap();
    scene_.materials.pop_back();
    if (!build_accelerator()) return cancelled_error();
    times.accelerator = clock.lap();
    finish_statistics();
    world_->statistics_.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(world_);
  }

  static void take_parts(World& world, WorldParts& parts) {
    parts.accelerators = world.accelerator_->take_structures();
    for (size_t i = 0; i < world.geometries_.size(); ++i)
      parts.geometries.put(parts.keys[i], std::move(world.geometries_[i]));
    parts.textures = std::move(world.textures_);
  }

 private:
  // Gives an array that is complete to the World.
  template <typename Vector>
  [[nodiscard]] std::span<const typename Vector::value_type> keep(Vector elements) {
    return world_->arrays_.keep(std::move(elements));
  }
  [[nodiscard]] bool cancelled() const { return cancel_ && cancel_->cancelled(); }
  static Error cancelled_error() { return {ErrorKind::render_failed, "cancelled while the scene was prepared"}; }

  // --- Textures and materials ---

  Result<void> prepare_materials() {
    std::vector<ShadingMaterial> materials;
    std::vector<LayerMaterial> layer_materials;
    std::vector<Medium> media;
    for (const Material& material : scene_.materials) {
      PreparedMaterial prepared = prepare_material(material, textures_);
      if (prepared.layers) {
        prepared.shading.layers = static_cast<int32_t>(layer_materials.size());
        world_->has_thin_walls |= prepared.shading.thin_wall;
        layer_materials.push_back(*prepared.layers);
        media.push_back(make_medium(material));
      }
      materials.push_back(prepared.shading);
      world_->material_names_.push_back(material.name);
    }
    world_->materials = keep(std::move(materials));
    world_->layer_materials = keep(std::move(layer_materials));
    world_->media = keep(std::move(media));
    if (!parts_.textures || parts_.texture_numbers != textures_.numbers()) {
      auto textures = textures_.build(options_.texture_memory, parts_.texture_bytes);
      if (!textures) return textures.error();
      parts_.textures = std::move(textures).value();
      parts_.texture_numbers = textures_.numbers();
    }
    world_->textures_ = *std::exchange(parts_.textures, std::nullopt);
    world_->textures = keep(std::vector<TextureView>(world_->textures_.begin(), world_->textures_.end()));
    world_->statistics_.texture_bytes = parts_.texture_bytes;
    world_->procedurals_ = textures_.take_procedurals();
    world_->procedurals.images = world_->textures;
    world_->procedurals.textures =
        keep(std::vector<ProceduralTextureView>(world_->procedurals_.begin(), world_->procedurals_.end()));
    if (!parts_.keep_scene)
      for (SceneTexture& texture : scene_.textures) texture.image.reset();
    return {};
  }

  // --- Geometry ---

  void take_geometry() {
    world_->file_light_groups_ = find_file_light_groups(scene_);
    const SceneChanges changes = posed_.animated ? SceneChanges(scene_) : SceneChanges();
    PreparedGeometry prepared = prepare_geometry(scene_, posed_, &parts_);
    world_->geometries_ = std::move(prepared.geometries);
    world_->geometries = keep(std::vector<GeometryView>(world_->geometries_.begin(), world_->geometries_.end()));
    instances_ = std::move(prepared.instances);
    std::vector<std::span<const M44f>> motions;
    for (std::vector<M44f>& keys : prepared.motions) motions.push_back(keep(std::move(keys)));
    world_->motions = keep(std::move(motions));
    groups_ = std::move(prepared.groups);
    world_->bounds = prepared.bounds.isEmpty() ? Box3f(V3f(-0.5f), V3f(0.5f)) : prepared.bounds;

    find_opacity();
    for (const GeometryView& geometry : world_->geometries)
      accel_meshes_.push_back(
          {geometry.positions, geometry.indices, world_->covers[accel_meshes_.size()] != 0, geometry.later_positions});
    mark_persistent({world_->geometries_, prepared.nodes, instances_, groups_}, changes,
                    min_persistent_triangles(options_.min_persistent_triangles, options_.image_samples), accel_meshes_);
    world_->baked_nodes_ = std::move(prepared.nodes);
    world_->instance_nodes_ = std::move(prepared.instance_nodes);
    for (const WorldInstance& instance : instances_) world_->has_motion |= instance.moving;
    for (const PosedLight& light : posed_.lights) world_->has_motion |= !light.later_transforms.empty();
  }

  void find_opacity() {
    const OpacityInput input{world_->geometries, world_->materials, world_->textures, world_->procedurals.textures};
    world_->covers = keep(find_covering_meshes(input));
    OpacityMicromaps maps = make_opacity_micromaps(input, world_->covers);
    world_->opacity = {keep(std::move(maps.first)), keep(std::move(maps.entries)), keep(std::move(maps.words))};
  }

  // --- Lights ---
  void collect_emissive_triangles(LightSetInput& input) {
    std::map<uint32_t, uint32_t> emission_of_material;
    std::vector<uint32_t> first_emissive;
    bool any_textured = false;
    const std::vector<uint8_t> emissive = find_emissive_groups();
    std::vector<WorldInstance*> order; // moving ones come last in a LightSet
    for (const bool moving : {false, true})
      for (WorldInstance& instance : instances_)
        if (emissive[instance.group] != 0 && instance.moving == moving) order.push_back(&instance);
    std::vector<EmissiveMeshJob> jobs;
    size_t count = 0;
    for (WorldInstance* pointer : order) {
      WorldInstance& instance = *pointer;
      const accel::MeshGroup& group = groups_[instance.group];
      instance.emissive = true;
      instance.emissive_begin = static_cast<uint32_t>(first_emissive.size());
      for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
        if (!is_sampled_emitter(m)) {
          first_emissive.push_back(accel::kNoId);
          continue;
        }
        first_emissive.push_back(static_cast<uint32_t>(count));
        const GeometryView& geometry = world_->geometries[m];
        const ShadingMaterial& material = world_->materials[geometry.material];
        const auto [entry, inserted] =
            emission_of_material.try_emplace(geometry.material, static_cast<uint32_t>(input.emissions.size()));
        if (inserted)
          input.emissions.push_back({material.emission_factor,
                                     material.emission.present()
                                         ? &world_->textures[static_cast<size_t>(material.emission.texture)]
                                         : nullptr,
                                     material.double_sided});
        if (inserted && material.layers != kNone) {
          const LayerMaterial& layers = world_->layer_materials[static_cast<size_t>(material.layers)];
          input.emissions.back().clearcoat = layers.clearcoat_factor;
          input.emissions.back().coated_back = !layers.volume;
        }
        any_textured |= material.emission.present();
        if (instance.moving)
          for (size_t i = 0; i < geometry.indices.size(); i += 3) append_keys(input, geometry, instance, i);
        jobs.push_back({&geometry, &material, static_cast<size_t>(pointer - instances_.data()), count, entry->second});
        const auto triangles = static_cast<uint32_t>(geometry.indices.size() / 3);
        input.meshes.push_back({static_cast<uint32_t>(count), triangles, world_->material_names_[geometry.material],
                                world_->node_of(m, static_cast<uint32_t>(jobs.back().instance)), geometry.material});
        count += triangles;
      }
    }
    world_->first_emissive = keep(std::move(first_emissive));
    world_->instances = keep(std::move(instances_)); // which are complete now
    world_->procedurals.instances = world_->instances;
    input.triangles.resize(count);
    input.triangle_uvs.resize(3 * count);
    tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) { set_emissive(input, jobs[i]); });
    if (!any_textured) input.triangle_uvs.clear();
    world_->statistics_.emissive_triangle_count = input.triangles.size();
  }

  // Returns flags by group: 1 if its emitters are sampled.
  [[nodiscard]] std::vector<uint8_t> find_emissive_groups() {
    std::vector<Emitters> emitters(groups_.size());
    for (const WorldInstance& instance : instances_) ++emitters[instance.group].instances;
    for (size_t g = 0; g < groups_.size(); ++g)
      for (uint32_t m = groups_[g].first_mesh; m < groups_[g].first_mesh + groups_[g].mesh_count; ++m) {
        if (!is_sampled_emitter(m)) continue;
        emitters[g].triangles += world_->geometries[m].indices.size() / 3;
        has_lamp_ |= emitters[g].instances > 0 && is_lamp(scene_.materials[world_->geometries[m].material]);
      }
    SampledEmitters sampled = choose_sampled_emitters(emitters);
    if (sampled.left_out > 0 && listener_)
      listener_->on_warning(scene_.source + ": " + std::to_string(sampled.left_out) +
                            " emissive triangles of instances exceed the emitter budget and are left to BSDF sampling");
    return std::move(sampled.groups);
  }

  // Partly transparent emitters are left to BSDF sampling: their coverage belongs to the ray, not
  // to the light. So are those below a textured coat, which light samples do not look up, and those
  // with procedural emission, whose mean is unknown.
  [[nodiscard]] bool is_sampled_emitter(uint32_t mesh) const {
    const ShadingMaterial& material = world_->materials[world_->geometries[mesh].material];
    const LayerMaterial* layers =
        material.layers == kNone ? nullptr : &world_->layer_materials[static_cast<size_t>(material.layers)];
    const bool patchy_coat = layers != nullptr && layers->clearcoat_factor > 0.0f && layers->clearcoat.present();
    if (world_->geometries[mesh].stroke == Stroke::unlit) return false; // emits more than its emission
    return material.emissive && world_->covers[mesh] != 0 && !patchy_coat && !material.emission.is_procedural();
  }

  struct EmissiveMeshJob {
    const GeometryView* geometry;
    const ShadingMaterial* material;
    size_t instance;
    size_t first; // of its triangles
    uint32_t emission;
  };
  void set_emissive(LightSetInput& input, const EmissiveMeshJob& job) const {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, job.geometry->indices.size() / 3, 4096),
                      [&](const tbb::blocked_range<size_t>& range) {
                        for (size_t i = range.begin(); i != range.end(); ++i) set_emissive(input, job, i);
                      });
  }
  void set_emissive(LightSetInput& input, const EmissiveMeshJob& job, size_t index) const {
    const WorldInstance& instance = world_->instances[job.instance];
    const GeometryView& geometry = *job.geometry;
    const TextureBinding& emission = job.material->emission;
    EmissiveTriangle& triangle = input.triangles[job.first + index];
    V2f* const uvs = &input.triangle_uvs[3 * (job.first + index)];
    V3f* corners[3] = {&triangle.p0, &triangle.p1, &triangle.p2};
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t vertex = geometry.indices[3 * index + c];
      *corners[c] = transform_point(instance.object_to_world, geometry.positions[vertex]);
      const uint8_t offset = geometry.texcoord_offset[emission.texcoord];
      V2f uv(0.0f);
      if (emission.present() && offset != Geometry::kAbsent) {
        const float* record = geometry.record(vertex);
        uv = V2f(record[offset], record[offset + 1]);
      }
      uvs[c] = emission.apply(uv);
    }
    // Front faces are wound counterclockwise in world space. Barycentrics change with the order,
    // but emission at a hit is read through the surface, and the LightSet only uses its own.
    if (instance.mirrored) {
      std::swap(triangle.p1, triangle.p2);
      std::swap(uvs[1], uvs[2]);
    }
    triangle.emission = job.emission;
  }

  // Appends the corners of the triangle at the keys after the opening of the shutter.
  void append_keys(LightSetInput& input, const GeometryView& geometry, const WorldInstance& instance,
                   size_t first_index) const {
    const auto first = static_cast<uint32_t>(input.later_corners.size());
    const auto add = [&](const M44f& object_to_world, std::span<const V3f> positions) {
      std::array<V3f, 3>& corners = input.later_corners.emplace_back();
      for (size_t c = 0; c < 3; ++c)
        corners[c] = transform_point(object_to_world, positions[geometry.indices[first_index + c]]);
      if (instance.mirrored) std::swap(corners[1], corners[2]);
    };
    if (instance.motion != accel::kNoId) {
      const std::span<const M44f> keys = world_->motions[instance.motion];
      for (size_t key = 1; key < keys.size(); ++key) add(keys[key], geometry.positions);
    } else {
      for (const std::span<const V3f> key : geometry.later_positions) add(instance.object_to_world, key);
    }
    input.moving.push_back({first, static_cast<uint32_t>(input.later_corners.size()) - first});
  }

  void collect_lights() {
    LightSetInput input;
    collect_emissive_triangles(input);
    add_punctual_lights(scene_, posed_.lights, input);
    input.environment = options_.environment;
    if (!input.environment && options_.studio == Studio::on) input.environment = builtin_environment();
    if (!input.environment && posed_.image_light != kNone)
      input.environment = image_light_environment(scene_.image_lights[static_cast<size_t>(posed_.image_light)]);
    if (!input.environment && posed_.lights.empty() && options_.studio == Studio::automatic) {
      world_->lit_by_emission_alone_ = has_lamp_;
      if (!has_lamp_) {
        input.environment = builtin_environment();
        if (listener_)
          listener_->on_warning(scene_.source +
                                ": no lights and no --env: lit by the built-in neutral studio (off with --studio off)");
      }
    }
    input.scene_center = world_->bounds.center();
    input.scene_radius_m = std::max(world_->bounds.size().length() * 0.5f, 1e-6f);
    world_->light_set_ = std::make_unique<LightSet>(std::move(input));
    world_->lights = static_cast<const LightSetView&>(*world_->light_set_);
    add_groups_of_lights(scene_, posed_, *world_->light_set_, world_->file_light_groups_);
  }

  // --- Accelerator ---

  [[nodiscard]] bool build_accelerator() {
    world_->abandon_ = options_.abandon;
    world_->accel_meshes_ = std::move(accel_meshes_);
    world_->accel_groups_ = std::move(groups_);
    world_->contacts_ = find_contacts(
        {world_->geometries_, world_->accel_groups_, world_->instances, world_->motions, world_->bounds}, cancel_);
    if (world_->contacts_) world_->contacts = static_cast<const ContactsView&>(*world_->contacts_);
    if (cancelled()) return false;
    return WorldChanges::build_accelerator(*world_, options_, std::move(parts_.accelerators), cancel_, listener_);
  }

  void finish_statistics() {
    WorldStatistics& statistics = world_->statistics_;
    MotionStatistics& motion = statistics.motion;
    for (const Geometry& geometry : world_->geometries_) {
      statistics.geometry_bytes += geometry.memory_bytes();
      if (geometry.later_positions.empty()) continue;
      ++motion.deforming_mesh_count;
      motion.max_keys = std::max(motion.max_keys, geometry.later_positions.size() + 1);
      motion.key_bytes += geometry.key_bytes;
    }
    for (const std::span<const M44f> keys : world_->motions) {
      ++motion.moving_instance_count;
      motion.max_keys = std::max(motion.max_keys, keys.size());
      motion.key_bytes += keys.size_bytes();
    }
    statistics.geometry_bytes += world_->opacity.bytes();
    statistics.light_bytes = world_->light_set_->memory_bytes();
    statistics.accelerator = world_->accelerator_->statistics();
    constexpr size_t kCacheBytes = 256 * 1024; // smaller data stays in the second-level cache
    world_->exceeds_caches = statistics.geometry_bytes + statistics.texture_bytes > kCacheBytes;
  }

  Scene& scene_;
  PosedScene posed_;
  const WorldOptions& options_;
  WorldParts& parts_;
  const CancelToken* cancel_;
  ProgressListener* listener_;
  std::unique_ptr<World> world_;
  TextureTable textures_{scene_.textures, scene_.procedurals};
  bool has_lamp_ = false;
  std::vector<WorldInstance> instances_; // until they are complete
  std::vector<accel::TriangleMesh> accel_meshes_;
  std::vector<accel::MeshGroup> groups_;
};

Result<std::unique_ptr<const World>> build_world(Scene scene, PosedScene posed, const WorldOptions& options,
                                                 const CancelToken* cancel, ProgressListener* listener) {
  WorldParts parts;
  Result<std::unique_ptr<World>> world =
      build_world_of_parts(scene, std::move(posed), options, parts, cancel, listener);
  if (!world.ok()) return world.error();
  return std::unique_ptr<const World>(std::move(world).value());
}

Result<std::unique_ptr<World>> build_world_of_parts(Scene& scene, PosedScene posed, const WorldOptions& options,
                                                    WorldParts& parts, const CancelToken* cancel,
                                                    ProgressListener* listener) {
  const StandardArithmetic standard_arithmetic; // of the threads that this one starts, too
  return WorldBuilder(scene, std::move(posed), options, parts, cancel, listener).build();
}

void take_parts(std::unique_ptr<World> world, WorldParts& parts) { WorldBuilder::take_parts(*world, parts); }

bool is_lamp(const Material& material) {
  return !material.unlit && !is_black(material.emissive_factor * material.emissive_strength) &&
         (!material.emissive_texture.present() || material.emissive_strength > 1.0f);
}

} // namespace kindling
