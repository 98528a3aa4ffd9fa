// Checks all primitives in order, then reads them in parallel.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/meshes.h"

#include "renderer/import/materials/variant_mappings.h"
#include "renderer/import/meshes/check_primitive.h"
#include "renderer/import/meshes/outlines.h"
#include "renderer/import/meshes/primitive.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <exception>
#include <optional>

namespace kindling::gltf {
namespace {

struct Job {
  explicit Job(bool strict) : warnings(strict) {}
  size_t mesh = 0;
  size_t primitive = 0;
  std::vector<VariantMaterial> variant_materials;
  std::optional<Primitive> result;
  Warnings warnings;
  std::exception_ptr failure;
};

void check_targets(const Document& document, size_t mesh, Warnings& warnings) {
  const tinygltf::Mesh& core = document.core.meshes[mesh];
  for (size_t p = 1; p < core.primitives.size(); ++p) {
    if (core.primitives[p].targets.size() == core.primitives[0].targets.size()) continue;
    warnings.repair("targets", fmt::format("/meshes/{}/primitives/{}/targets", mesh, p),
                    fmt::format("{} morph targets, the first primitive has {}", core.primitives[p].targets.size(),
                                core.primitives[0].targets.size()),
                    "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT", "each uses its own");
  }
  const size_t targets = morph_target_count(document, mesh);
  if (!core.weights.empty() && core.weights.size() != targets) {
    warnings.repair("mesh weights", fmt::format("/meshes/{}/weights", mesh),
                    fmt::format("{} weights, the mesh has {} morph targets", core.weights.size(), targets),
                    "MESH_INVALID_WEIGHTS_COUNT", "missing ones are 0, others are ignored");
  }
}

// Returns the material of a primitive, then those of its variants.
std::vector<const Material*> materials_of(const Document& document, const Scene& scene, const Job& job) {
  std::vector<const Material*> materials;
  const int own = document.core.meshes[job.mesh].primitives[job.primitive].material;
  if (own >= 0) materials.push_back(&scene.materials[static_cast<size_t>(own)]);
  for (const VariantMaterial& choice : job.variant_materials)
    materials.push_back(&scene.materials[static_cast<size_t>(choice.material)]);
  return materials;
}

} // namespace

size_t morph_target_count(const Document& document, size_t mesh) {
  const tinygltf::Mesh& core = document.core.meshes[mesh];
  size_t targets = 0;
  for (const tinygltf::Primitive& primitive : core.primitives) targets = std::max(targets, primitive.targets.size());
  return targets;
}

namespace {

std::vector<bool> used_meshes(const Document& document) {
  std::vector<bool> used(document.core.meshes.size(), false);
  for (const tinygltf::Node& node : document.core.nodes)
    if (node.mesh >= 0) used[static_cast<size_t>(node.mesh)] = true;
  return used;
}

} // namespace

void import_meshes(Document& document, Scene& scene, Warnings& warnings, WorkTime& tangents) {
  ElementBudget budget(document);
  std::vector<Job> jobs;
  const std::vector<tinygltf::Mesh>& meshes = document.core.meshes;
  const std::vector<bool> used = used_meshes(document);
  const auto skip_unused = [&](size_t mesh, const ImportFailure& fault) {
    if (used[mesh]) throw fault;
    warnings.repair("mesh", fault, "the primitive is not used");
  };
  for (size_t m = 0; m < meshes.size(); ++m) {
    Mesh mesh;
    mesh.name = meshes[m].name;
    for (const double weight : meshes[m].weights) mesh.weights.push_back(static_cast<float>(weight));
    scene.meshes.push_back(std::move(mesh));
    check_targets(document, m, warnings);
    scene.meshes.back().weights.resize(morph_target_count(document, m), 0.0f);
    for (size_t p = 0; p < meshes[m].primitives.size(); ++p) {
      try {
        check_primitive(document, m, p, budget, warnings);
      } catch (const BudgetFailure&) {
        throw;
      } catch (const ImportFailure& fault) {
        skip_unused(m, fault);
        continue;
      }
      Job job(warnings.strict());
      job.mesh = m;
      job.primitive = p;
      job.variant_materials = read_variant_mappings(document, m, p, scene.variants.size(), warnings);
      jobs.push_back(std::move(job));
    }
  }

  const auto for_each_job = [&](const auto& work) {
    tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) {
      try {
        work(jobs[i]);
      } catch (...) {
        jobs[i].failure = std::current_exception();
      }
    });
  };
  for_each_job([&](Job& job) {
    job.result = read_primitive(document, job.mesh, job.primitive, materials_of(document, scene, job), job.warnings);
  });
  const Stopwatch tangents_clock;
  for_each_job([&](Job& job) {
    if (job.result)
      make_missing_tangents(job.mesh, job.primitive, materials_of(document, scene, job), *job.result, job.warnings);
  });
  tangents = tangents_clock.elapsed();
  std::vector<std::vector<int>> modes(meshes.size()); // of the primitives that were read
  for (Job& job : jobs) {
    warnings.append(job.warnings);
    if (job.failure) {
      try {
        std::rethrow_exception(job.failure); // the first in the order of the file
      } catch (const ImportFailure& fault) {
        skip_unused(job.mesh, fault);
      }
    }
    if (!job.result) continue;
    job.result->variant_materials = std::move(job.variant_materials);
    scene.meshes[job.mesh].primitives.push_back(std::move(*job.result));
    modes[job.mesh].push_back(meshes[job.mesh].primitives[job.primitive].mode);
  }
  for (size_t m = 0; m < meshes.size(); ++m) mark_outlines(scene.meshes[m].primitives, modes[m]);
}

} // namespace kindling::gltf
