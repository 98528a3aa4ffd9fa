// Signatures and extensions of scene formats other than glTF.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/other_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace kindling::gltf {

namespace {

constexpr std::string_view kBlender = "Blender (File > Export > glTF 2.0)";

struct OtherFormat {
  std::string_view extension; // ".obj"
  std::string_view signature; // first bytes; empty: the extension alone tells
  std::string_view name;
  std::string_view converter; // {} is the file's stem; empty: read by this program under its extension
};

constexpr OtherFormat kOtherFormats[] = {
    {".usda", "#usda", "a USD file", kBlender},
    {".usdc", "PXR-USDC", "a USD file", kBlender},
    {".usd", "", "a USD file", kBlender},
    {".usdz", "", "a USDZ archive", kBlender},
    {".fbx", "Kaydara FBX Binary", "an FBX file", "FBX2glTF: FBX2glTF --binary {0}.fbx"},
    {".blend", "BLENDER", "a Blender file", kBlender},
    {".dae", "", "a COLLADA file", "assimp: assimp export {0}.dae {0}.glb"},
    {".3ds", "", "a 3DS file", "assimp: assimp export {0}.3ds {0}.glb"},
    {".stl", "solid ", "an STL file", ""},
    {".ply", "ply", "a PLY file", ""},
    {".abc", "Ogawa", "an Alembic file", kBlender},
    {".vrml", "#VRML", "a VRML file", kBlender},
    {".wrl", "#VRML", "a VRML file", kBlender},
    {".x3d", "", "an X3D file", kBlender},
    {".off", "OFF", "an OFF file", "assimp: assimp export {0}.off {0}.glb"},
    {".b3dm", "b3dm", "a tile of 3D Tiles",
     "3d-tiles-tools (npm): npx 3d-tiles-tools b3dmToGlb -i {0}.b3dm -o {0}.glb"},
    {".i3dm", "i3dm", "a tile of 3D Tiles",
     "3d-tiles-tools (npm): npx 3d-tiles-tools i3dmToGlb -i {0}.i3dm -o {0}.glb"},
    {".spz", "", "a file of Gaussian splats", kSplatConverter},
    {".splat", "", "a file of Gaussian splats", kSplatConverter},
    {".ksplat", "", "a file of Gaussian splats", kSplatConverter},
    {".sog", "", "a file of Gaussian splats", kSplatConverter},
    {".zip", "PK\x03\x04", "a zip archive", "unzip: unzip {0}.zip"},
    {".gz", "\x1f\x8b", "a compressed file", "gunzip"},
};

} // namespace

std::string describe_other_format(Bytes file, const std::filesystem::path& path) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), std::min<size_t>(file.size(), 64));
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  if (text.starts_with('{')) return {};
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const OtherFormat& format : kOtherFormats) {
    const bool signed_so = !format.signature.empty() && text.starts_with(format.signature);
    if (!signed_so && extension != format.extension) continue;
    if (format.converter.empty())
      return fmt::format("{}, not glTF; rename it to {}{}", format.name, path.stem().string(), format.extension);
    return fmt::format("{}, not glTF; convert it with {}", format.name,
                       fmt::format(fmt::runtime(format.converter), path.stem().string()));
  }
  return {};
}

std::string converter_of_version_1(const std::filesystem::path& path) {
  return fmt::format("gltf-pipeline (npm): gltf-pipeline -i {} -o {}_2.glb", path.filename().string(),
                     path.stem().string());
}

} // namespace kindling::gltf
