// Opens plugins, and adapts their tables of C functions to the interface of accelerators.
// SPDX-License-Identifier: Apache-2.0
#include "accel/plugin/load_plugin.h"

#include "accel/affine.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <utility>

namespace kindling::accel {
namespace {

static_assert(sizeof(KindlingRay) == sizeof(Ray) && offsetof(KindlingRay, t_min) == offsetof(Ray, t_min) &&
              offsetof(KindlingRay, direction) == offsetof(Ray, direction) &&
              offsetof(KindlingRay, t_max) == offsetof(Ray, t_max));
static_assert(sizeof(KindlingHit) == sizeof(Hit) && offsetof(KindlingHit, u) == offsetof(Hit, u) &&
              offsetof(KindlingHit, instance) == offsetof(Hit, instance) &&
              offsetof(KindlingHit, triangle) == offsetof(Hit, triangle));
static_assert(KINDLING_NO_HIT == kNoId);

const KindlingRay* as_plugin(const Ray* rays) { return reinterpret_cast<const KindlingRay*>(rays); }
KindlingHit* as_plugin(Hit* hits) { return reinterpret_cast<KindlingHit*>(hits); }

// Calls `work` and returns the text of an exception that leaves it; empty if none does.
template <typename Work>
std::string exception_of(const Work& work) {
  try {
    work();
  } catch (const std::exception& exception) {
    return std::string("a C++ exception left it: ") + exception.what();
  } catch (...) {
    return "a C++ exception left it";
  }
  return {};
}

// A text of a plugin, which may be null or very long, as one line.
std::string one_line(const char* text, size_t longest) {
  if (text == nullptr) return {};
  std::string line(text, strnlen(text, longest));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  return line;
}

// The scene as plugins see it. Not copied: `scene` points into it.
struct PluginScene {
  std::vector<KindlingMesh> meshes;
  std::vector<KindlingInstance> instances;
  KindlingScene scene{};

  explicit PluginScene(const BuildInput& input) {
    meshes.reserve(input.meshes.size());
    for (const TriangleMesh& mesh : input.meshes)
      meshes.push_back({reinterpret_cast<const float*>(mesh.positions.data()), mesh.indices.data(),
                        mesh.positions.size(), mesh.triangle_count()});
    instances.reserve(input.instances.size());
    for (size_t i = 0; i < input.instances.size(); ++i) {
      const Instance& instance = input.instances[i];
      const MeshGroup& group = input.groups[instance.group];
      KindlingInstance& out = instances.emplace_back();
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          out.object_to_world[row][column] = instance.object_to_world[column][row];
      out.first_mesh = group.first_mesh;
      out.mesh_count = group.mesh_count;
      out.is_identity = is_identity(instance.object_to_world) ? 1 : 0;
    }
    scene = {meshes.data(), instances.data(), meshes.size(), instances.size()};
  }
};

Imath::Box3f bounds_of(const BuildInput& input) {
  Imath::Box3f bounds;
  for (size_t i = 0; i < input.instances.size(); ++i) {
    const Instance& instance = input.instances[i];
    const MeshGroup& group = input.groups[instance.group];
    for (const TriangleMesh& mesh : input.meshes.subspan(group.first_mesh, group.mesh_count)) {
      Imath::Box3f box;
      for (const uint32_t index : mesh.indices) box.extendBy(mesh.positions[index]);
      bounds.extendBy(transform_bounds(instance.object_to_world, box));
    }
  }
  return bounds;
}

class Adapter final : public PluginAccelerator {
 public:
  Adapter(const KindlingAcceleratorTable& table, const BuildInput& input)
      : table_(table), input_(input), scene_(input) {}
  ~Adapter() override {
    if (accelerator_ != nullptr) exception_of([&] { table_.destroy(accelerator_); });
  }
  Adapter(const Adapter&) = delete;
  Adapter& operator=(const Adapter&) = delete;

  // Returns the reason if it fails.
  std::string build(const KindlingBuildSettings& settings) {
    std::array<char, 512> text{};
    const std::string thrown =
        exception_of([&] { accelerator_ = table_.build(&scene_.scene, &settings, text.data(), text.size()); });
    if (!thrown.empty()) return thrown;
    if (accelerator_ != nullptr) return {};
    const std::string reason = one_line(text.data(), text.size());
    return reason.empty() ? "it gave no reason" : reason;
  }

  [[nodiscard]] Hit intersect(const Ray& ray) const override {
    Hit hit;
    answer(table_.intersect, &ray, &hit, 1);
    return hit;
  }
  [[nodiscard]] bool occluded(const Ray& ray) const override {
    uint8_t blocked = 0;
    answer(table_.occluded, &ray, &blocked, 1);
    return blocked != 0;
  }
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(hits.size() == rays.size());
    answer(table_.intersect, rays.data(), hits.data(), rays.size());
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    assert(blocked.size() == rays.size());
    answer(table_.occluded, rays.data(), blocked.data(), rays.size());
  }
  [[nodiscard]] bool coherent_equals_single() const override { return false; } // it need not
  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    answer(table_.intersect_coherent, rays.data(), hits.data(), rays.size());
  }
  void occluded_coherent(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    answer(table_.occluded_coherent, rays.data(), blocked.data(), rays.size());
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_of(input_); }
  [[nodiscard]] Statistics statistics() const override {
    Statistics statistics;
    for (const KindlingInstance& instance : scene_.instances)
      for (uint32_t m = 0; m < instance.mesh_count; ++m)
        statistics.triangle_count += scene_.meshes[instance.first_mesh + m].triangle_count;
    for (const KindlingMesh& mesh : scene_.meshes) statistics.built_triangle_count += mesh.triangle_count;
    statistics.instance_count = scene_.instances.size();
    if (table_.statistics == nullptr) return statistics;
    KindlingStatistics known{};
    note(exception_of([&] { table_.statistics(accelerator_, &known); }));
    statistics.memory_bytes = known.memory_bytes;
    statistics.node_count = known.node_count;
    statistics.leaf_count = known.leaf_count;
    statistics.reference_count = known.reference_count;
    return statistics;
  }
  [[nodiscard]] std::string failure() const override {
    const std::lock_guard lock(mutex_);
    return failure_;
  }

 private:
  using Intersect = int (*)(const KindlingAccelerator*, const KindlingRay*, KindlingHit*, size_t);
  using Occluded = int (*)(const KindlingAccelerator*, const KindlingRay*, uint8_t*, size_t);

  void answer(Intersect function, const Ray* rays, Hit* hits, size_t count) const {
    note(exception_of([&] { note(function(accelerator_, as_plugin(rays), as_plugin(hits), count)); }));
  }
  void answer(Occluded function, const Ray* rays, uint8_t* blocked, size_t count) const {
    note(exception_of([&] { note(function(accelerator_, as_plugin(rays), blocked, count)); }));
  }

  void note(int error) const {
    if (error == 0) [[likely]]
      return;
    const std::string text = table_.error_text != nullptr ? one_line(table_.error_text(error), 512) : std::string();
    note("error " + std::to_string(error) + (text.empty() ? "" : ": " + text));
  }
  void note(std::string failure) const {
    if (failure.empty()) [[likely]]
      return;
    const std::lock_guard lock(mutex_);
    if (failure_.empty()) failure_ = std::move(failure);
  }

  KindlingAcceleratorTable table_;
  BuildInput input_;
  PluginScene scene_;
  KindlingAccelerator* accelerator_ = nullptr;
  mutable std::mutex mutex_;
  mutable std::string failure_;
};

} // namespace

AcceleratorPlugin::AcceleratorPlugin(const KindlingAcceleratorTable& table)
    : table_(table), description_(one_line(table.description, 200)) {
  if (table_.intersect_coherent == nullptr) table_.intersect_coherent = table_.intersect;
  if (table_.occluded_coherent == nullptr) table_.occluded_coherent = table_.occluded;
}

std::unique_ptr<AcceleratorPlugin> AcceleratorPlugin::open(const std::filesystem::path& file, std::string& error) {
  // A name without a folder would be looked for in those of the system.
  void* library = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    error = std::string("cannot be opened: ") + (reason != nullptr ? reason : "no reason is known");
    return nullptr;
  }
  using EntryPoint = const KindlingAcceleratorTable* (*)(uint32_t);
  const auto entry = reinterpret_cast<EntryPoint>(dlsym(library, "kindling_accelerator_plugin"));
  if (entry == nullptr) {
    error = "exports no function kindling_accelerator_plugin(); it must be declared extern \"C\" and be visible";
    return nullptr;
  }
  const KindlingAcceleratorTable* table = nullptr;
  error = exception_of([&] { table = entry(KINDLING_ACCELERATOR_VERSION); });
  if (!error.empty()) return nullptr;
  const std::string known =
      "; this program knows versions 1 to " + std::to_string(KINDLING_ACCELERATOR_VERSION) + " of the interface";
  if (table == nullptr) {
    error = "returned no table of functions" + known;
    return nullptr;
  }
  if (table->version < 1 || table->version > KINDLING_ACCELERATOR_VERSION) {
    error = "follows version " + std::to_string(table->version) + known;
    return nullptr;
  }
  if (table->table_bytes < sizeof(KindlingAcceleratorTable)) {
    error = "has a table of " + std::to_string(table->table_bytes) + " bytes; version " +
            std::to_string(table->version) + " has " + std::to_string(sizeof(KindlingAcceleratorTable));
    return nullptr;
  }
  const std::pair<const char*, bool> needed[] = {{"build", table->build != nullptr},
                                                 {"destroy", table->destroy != nullptr},
                                                 {"intersect", table->intersect != nullptr},
                                                 {"occluded", table->occluded != nullptr}};
  for (const auto& [name, present] : needed)
    if (!present) {
      error = std::string("has no function ") + name + "() in its table";
      return nullptr;
    }
  return std::unique_ptr<AcceleratorPlugin>(new AcceleratorPlugin(*table));
}

PluginBuild AcceleratorPlugin::build(const BuildInput& input, int threads, const std::string& options) const {
  for (size_t i = 0; i < input.instances.size(); ++i)
    if (input.instances[i].motion != kNoId)
      return {nullptr, "instance " + std::to_string(i) + " moves, and plugins know no motion"};
  for (const TriangleMesh& mesh : input.meshes)
    if (!mesh.later_positions.empty()) return {nullptr, "a mesh deforms, and plugins know no motion"};
  auto adapter = std::make_unique<Adapter>(table_, input);
  std::string error = adapter->build({table_.version, static_cast<uint32_t>(std::max(threads, 1)), options.c_str()});
  if (!error.empty()) return {nullptr, std::move(error)};
  return {std::move(adapter), {}};
}

} // namespace kindling::accel
