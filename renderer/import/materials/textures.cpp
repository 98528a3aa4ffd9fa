// Samplers; loading, deduplication and decoding of images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/textures.h"

#include "renderer/image/decode_image.h"
#include "renderer/import/files/uri.h"
#include "renderer/import/json/extensions.h"
#include "renderer/scene/material_slots.h"
#include "renderer/texture/texture_memory.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>

namespace kindling::gltf {
namespace {

using nlohmann::json;

TextureWrap to_wrap(int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::clamp_to_edge;
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureWrap::mirrored_repeat;
  return TextureWrap::repeat;
}

// Returns the images of a texture by preference: those of extensions, then the plain source.
std::vector<int> images_of(const Document& document, size_t texture) {
  const json& object = (*document.json)["textures"][texture];
  std::vector<int> images;
  const auto add = [&](int image) {
    if (image >= 0 && std::find(images.begin(), images.end(), image) == images.end()) images.push_back(image);
  };
  for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp"}) {
    if (const json* extension = find_extension(object, name))
      add(static_cast<int>(integer_or(*extension, "source", kNone)));
  }
  add(document.core.textures[texture].source);
  return images;
}

// One image of the file: encoded bytes and decoded result.
struct ImageFile {
  int image = kNone; // index into the file's images
  std::string name;
  OwnedBytes owned; // unless the bytes are part of a buffer
  Bytes bytes;
  ImageUse use = ImageUse::any;
  std::string error; // not empty: unreadable
  uint64_t hash = 0;
  size_t same_as = 0; // the first image with these bytes and this use: itself or an earlier one
  std::shared_ptr<const Image> decoded;
};

std::string short_name(const json& image, int index) {
  const auto uri = image.find("uri");
  if (uri != image.end() && !is_data_uri(uri->get_ref<const std::string&>()))
    return percent_decode(uri->get_ref<const std::string&>());
  const auto name = image.find("name");
  if (name != image.end()) return name->get<std::string>();
  return fmt::format("image {}", index);
}

void fetch(const Document& document, ImageFile& file) {
  const json& image = (*document.json)["images"][static_cast<size_t>(file.image)];
  const auto view = image.find("bufferView");
  const auto uri = image.find("uri");
  if (view != image.end()) {
    file.bytes = document.views[view->get<size_t>()].bytes;
    if (file.bytes.empty()) file.error = fmt::format("bufferView {} has no data", view->get<size_t>());
    return;
  }
  if (uri == image.end()) {
    file.error = "neither uri nor bufferView";
    return;
  }
  const auto& text = uri->get_ref<const std::string&>();
  Result<OwnedBytes> bytes = Error{};
  if (is_data_uri(text)) {
    bytes = decode_data_uri(text);
  } else {
    const auto path = resolve_uri(document.path.parent_path(), text);
    bytes = path ? read_file(path.value(), document.limits.max_file_bytes) : Result<OwnedBytes>(path.error());
  }
  if (!bytes) {
    file.error = fmt::format("{}: {}", in_quotes(file.name), bytes.error().message);
    return;
  }
  file.owned = std::move(bytes).value();
  file.bytes = file.owned.span();
}

void check_image_objects(const Document& document, Warnings& warnings) {
  const auto images = document.json->find("images");
  if (images == document.json->end()) return;
  for (size_t i = 0; i < images->size(); ++i) {
    const bool has_uri = (*images)[i].contains("uri");
    if (has_uri != (*images)[i].contains("bufferView")) continue;
    warnings.repair(has_uri ? "two sources" : "no source of an image", fmt::format("/images/{}", i),
                    has_uri ? "both uri and bufferView, expected one of them"
                            : "neither uri nor bufferView, expected one of them",
                    "ONE_OF_MISMATCH", has_uri ? "the bufferView is used" : "the image is unreadable");
  }
}

// Returns for each texture whether a material refers to it.
std::vector<bool> used_textures(const Scene& scene) {
  std::vector<bool> used(scene.textures.size(), false);
  for (const Material& material : scene.materials) {
    for (const TextureSlot* slot : texture_slots(material)) {
      if (slot->texture != kNone) used[static_cast<size_t>(slot->texture)] = true;
    }
  }
  for (const ProceduralGraph& graph : scene.procedurals)
    for (const ProceduralNode& node : graph.nodes)
      for (const ProceduralInput& input : node.inputs)
        if (input.texture >= 0) used[static_cast<size_t>(input.texture)] = true;
  return used;
}

// Returns the images of textures that a material uses as normal maps.
std::set<int> normal_maps(const Document& document, const Scene& scene) {
  std::set<int> images;
  for (const Material& material : scene.materials)
    for (const TextureSlot* slot : {&material.normal_texture, &material.clearcoat_normal_texture})
      if (slot->texture != kNone)
        for (const int image : images_of(document, static_cast<size_t>(slot->texture))) images.insert(image);
  return images;
}

// Finds images with equal bytes and equal use.
void find_equal(std::vector<ImageFile>& files) {
  std::multimap<std::tuple<uint64_t, size_t, ImageUse>, size_t> seen;
  for (size_t i = 0; i < files.size(); ++i) {
    ImageFile& file = files[i];
    file.same_as = i;
    if (!file.error.empty()) continue;
    const std::tuple key(file.hash, file.bytes.size(), file.use);
    const auto [first, last] = seen.equal_range(key);
    const auto same = std::find_if(first, last, [&](const auto& other) {
      const Bytes bytes = files[other.second].bytes;
      return bytes.empty() || std::memcmp(bytes.data(), file.bytes.data(), bytes.size()) == 0;
    });
    if (same != last) {
      file.same_as = same->second;
    } else {
      seen.emplace(key, i);
    }
  }
}

Result<std::shared_ptr<const Image>> keep(TextureMemory* memory, Image&& image) {
  if (memory) return memory->keep(std::move(image));
  return std::make_shared<const Image>(std::move(image));
}

// Decodes the images from index `first` on, in parallel.
void decode_all(const Document& document, std::vector<ImageFile>& files, size_t first, TextureMemory* memory,
                ProgressListener* listener) {
  std::mutex mutex;
  std::optional<Error> storage_error; // of the texture memory: the machine's fault, not the scene's
  size_t done = 0;
  std::atomic<uint64_t> total{0};
  for (size_t i = 0; i < first; ++i) {
    if (files[i].same_as == i && files[i].decoded != nullptr) total += files[i].decoded->byte_count();
  }
  tbb::parallel_for(first, files.size(), [&](size_t i) {
    ImageFile& file = files[i];
    if (file.error.empty() && file.same_as == i && total.load() <= document.limits.max_texture_bytes) {
      Result<Image> image = decode_image(file.bytes, file.name, {}, file.use);
      if (image) {
        total.fetch_add(image.value().byte_count());
        Result<std::shared_ptr<const Image>> stored = keep(memory, std::move(image).value());
        if (stored) {
          file.decoded = std::move(stored).value();
        } else {
          const std::lock_guard lock(mutex);
          storage_error = stored.error();
        }
      } else {
        file.error = image.error().message;
      }
    }
    if (listener == nullptr) return;
    const std::lock_guard lock(mutex);
    ++done;
    listener->on_progress({.phase = Phase::textures,
                           .done = static_cast<double>(done),
                           .total = static_cast<double>(files.size() - first)});
  });
  if (storage_error) fail("", storage_error->message, "", storage_error->kind);
  if (total.load() > document.limits.max_texture_bytes) {
    fail("/images", fmt::format("the decoded images have more than {} bytes", document.limits.max_texture_bytes));
  }
}

// Loads and decodes the images from index `first` on.
void load_files(Document& document, std::vector<ImageFile>& files, size_t first, TextureMemory* memory,
                ProgressListener* listener) {
  tbb::parallel_for(first, files.size(), [&](size_t i) {
    fetch(document, files[i]);
    if (detect_image_format(files[i].bytes) != ImageFormat::ktx2) files[i].use = ImageUse::any; // same pixels
    files[i].hash = hash_content(files[i].bytes);
  });
  for (size_t i = first; i < files.size(); ++i) {
    const ImageFile& file = files[i];
    if (file.owned.size() == 0) continue; // part of a buffer, which is hashed already
    document.bytes_read += file.bytes.size();
    document.content_hash = hash_bytes(std::as_bytes(std::span(&file.hash, 1)), document.content_hash);
  }
  find_equal(files);
  decode_all(document, files, first, memory, listener);
  for (size_t i = first; i < files.size(); ++i) {
    const ImageFile& source = files[files[i].same_as];
    files[i].decoded = source.decoded;
    files[i].error = source.error;
  }
}

} // namespace

void import_samplers(const Document& document, Scene& scene, Warnings& warnings) {
  check_image_objects(document, warnings);
  for (size_t i = 0; i < document.core.textures.size(); ++i) {
    SceneTexture texture;
    if (const int index = document.core.textures[i].sampler; index >= 0) {
      const tinygltf::Sampler& sampler = document.core.samplers[static_cast<size_t>(index)];
      texture.wrap_u = to_wrap(sampler.wrapS);
      texture.wrap_v = to_wrap(sampler.wrapT);
      if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) texture.filter = TextureFilter::nearest;
    }
    if (const std::vector<int> images = images_of(document, i); !images.empty()) {
      texture.name = short_name((*document.json)["images"][static_cast<size_t>(images[0])], images[0]);
    }
    scene.textures.push_back(std::move(texture));
  }
}

void import_images(Document& document, Scene& scene, TextureMemory* memory, ProgressListener* listener,
                   Warnings& warnings) {
  const std::vector<bool> used = used_textures(scene);
  const std::set<int> normals = normal_maps(document, scene);
  std::map<int, size_t> file_of_image;
  std::vector<ImageFile> files;
  std::vector<std::vector<int>> images(used.size());
  size_t max_images = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    images[i] = images_of(document, i);
    max_images = std::max(max_images, images[i].size());
    if (images[i].empty()) {
      warnings.add("no source", fmt::format("/textures/{}", i),
                   "a texture without a readable image: the material's factor is used alone");
    }
  }

  // Load the preferred image of each texture, then the next one of those whose image is unreadable.
  for (size_t rank = 0; rank < max_images; ++rank) {
    const size_t first = files.size();
    const auto wanted = [&](size_t i) { return scene.textures[i].image == nullptr && rank < images[i].size(); };
    for (size_t i = 0; i < used.size(); ++i) {
      if (!wanted(i) || !file_of_image.emplace(images[i][rank], files.size()).second) continue;
      ImageFile file;
      file.image = images[i][rank];
      if (normals.contains(file.image)) file.use = ImageUse::normal_map;
      file.name = short_name((*document.json)["images"][static_cast<size_t>(file.image)], file.image);
      files.push_back(std::move(file));
    }
    load_files(document, files, first, memory, listener);
    for (size_t i = 0; i < used.size(); ++i) {
      if (!wanted(i)) continue;
      const ImageFile& file = files[file_of_image.at(images[i][rank])];
      if (file.decoded == nullptr) continue;
      scene.textures[i].image = file.decoded;
      scene.textures[i].name = file.name;
    }
  }

  std::set<int> failed_images; // images of textures without any readable one
  for (size_t i = 0; i < used.size(); ++i) {
    if (scene.textures[i].image == nullptr) failed_images.insert(images[i].begin(), images[i].end());
  }
  for (const ImageFile& file : files) {
    if (file.decoded != nullptr) continue;
    warnings.add(fmt::format("image {}", file.image), fmt::format("/images/{}", file.image),
                 fmt::format("{}: {}", file.error,
                             failed_images.contains(file.image) ? "the material's factor is used alone"
                                                                : "the texture's other image is used"));
  }
}

Result<Image> read_image(Document& document, int image) {
  ImageFile file;
  file.image = image;
  file.name = short_name((*document.json)["images"][static_cast<size_t>(image)], image);
  fetch(document, file);
  if (!file.error.empty()) return Error{ErrorKind::input_output, file.error};
  document.bytes_read += file.owned.size();
  document.content_hash = hash_content(file.bytes, document.content_hash);
  return decode_image(file.bytes, file.name);
}

} // namespace kindling::gltf
