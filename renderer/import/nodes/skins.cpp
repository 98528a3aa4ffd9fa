// Reads skins and their inverse bind matrices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/accessor.h"
#include "renderer/import/nodes/nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace kindling::gltf {

namespace {

Skin read_skin(const Document& document, size_t index, ElementBudget& budget, Warnings& warnings) {
  const tinygltf::Skin& core = document.core.skins[index];
  const std::string pointer = fmt::format("/skins/{}", index);
  Skin skin;
  skin.name = core.name;
  skin.joints = core.joints;
  std::vector<int> sorted = skin.joints;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
    warnings.repair("joints", pointer + "/joints", "a node is listed twice", "DUPLICATE_ELEMENTS",
                    "both joints follow it");
  }
  constexpr uint64_t kElementsPerJoint = sizeof(M44f) / 16 + 1;
  budget.charge(skin.joints.size() * kElementsPerJoint, pointer + "/joints");
  skin.inverse_bind_matrices.resize(skin.joints.size());
  if (core.inverseBindMatrices >= 0) {
    const std::string place = pointer + "/inverseBindMatrices";
    const AccessorView view = view_accessor(document, core.inverseBindMatrices, place);
    require_format(view, {.components = 16}, place, "inverse bind matrices", "SKIN_IBM_INVALID_FORMAT");
    if (view.count < skin.joints.size()) {
      fail(place, fmt::format("{} matrices for {} joints", view.count, skin.joints.size()),
           "INVALID_IBM_ACCESSOR_COUNT");
    }
    budget.charge(view.count * 16, place);
    std::vector<float> values(view.count * 16);
    read_floats(view, {}, values.data(), 16);
    if (!all_finite(values)) fail(place, "a value that is not finite", "ACCESSOR_INVALID_FLOAT");
    bool affine = true;
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      M44f& matrix = skin.inverse_bind_matrices[j];
      std::memcpy(&matrix.x[0][0], values.data() + j * 16, sizeof(float) * 16);
      for (int row = 0; row < 4; ++row) {
        affine &= matrix[row][3] == (row == 3 ? 1.0f : 0.0f);
        matrix[row][3] = row == 3 ? 1.0f : 0.0f;
      }
    }
    if (!affine)
      warnings.add("ibm", place, "the last row of a matrix is not (0, 0, 0, 1) and is set to that",
                   "ACCESSOR_INVALID_IBM");
  }
  return skin;
}

bool is_used(const Document& document, size_t skin) {
  return std::any_of(document.core.nodes.begin(), document.core.nodes.end(),
                     [&](const tinygltf::Node& node) { return node.mesh >= 0 && node.skin == static_cast<int>(skin); });
}

} // namespace

void import_skins(Document& document, Scene& scene, Warnings& warnings) {
  ElementBudget budget(document);
  for (size_t i = 0; i < document.core.skins.size(); ++i) {
    try {
      scene.skins.push_back(read_skin(document, i, budget, warnings));
    } catch (const BudgetFailure&) {
      throw;
    } catch (const ImportFailure& fault) {
      if (is_used(document, i)) throw;
      warnings.repair("skin", fault, "the skin is not used");
      scene.skins.emplace_back();
      for (tinygltf::Node& node : document.core.nodes)
        if (node.skin == static_cast<int>(i)) node.skin = kNone;
    }
  }
}

} // namespace kindling::gltf
