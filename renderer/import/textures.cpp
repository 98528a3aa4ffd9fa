// Samplers, and the fetching, comparing and decoding of pictures.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/textures.h"

#include "renderer/image/decode_image.h"
#include "renderer/import/extensions.h"
#include "renderer/import/uri.h"
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

// The images of a texture, the preferred one first: of the extensions before the plain source, as they say.
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

// One picture of the file: its encoded bytes, then what came of them.
struct Picture {
  int image = kNone; // index into the file's images
  std::string name;
  OwnedBytes owned; // where the bytes are not part of a buffer
  Bytes bytes;
  std::string error; // not empty: unreadable
  uint64_t hash = 0;
  size_t same_as = 0; // the first picture with these bytes: itself or an earlier one
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

void fetch(const Document& document, Picture& picture) {
  const json& image = (*document.json)["images"][static_cast<size_t>(picture.image)];
  const auto view = image.find("bufferView");
  const auto uri = image.find("uri");
  if (view != image.end()) {
    picture.bytes = document.views[view->get<size_t>()].bytes;
    if (picture.bytes.empty()) picture.error = fmt::format("bufferView {} has no data", view->get<size_t>());
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
    picture.error = fmt::format("{}: {}", in_quotes(picture.name), bytes.error().message);
    return;
  }
  picture.owned = std::move(bytes).value();
  picture.bytes = picture.owned.span();
}

void check_image_objects(const Document& document) {
  const auto images = document.json->find("images");
  if (images == document.json->end()) return;
  for (size_t i = 0; i < images->size(); ++i) {
    const bool has_uri = (*images)[i].contains("uri");
    if (has_uri != (*images)[i].contains("bufferView")) continue;
    fail(fmt::format("/images/{}", i),
         has_uri ? "both uri and bufferView, accepted is one" : "neither uri nor bufferView, accepted is one",
         "ONE_OF_MISMATCH");
  }
}

// Textures that a slot of some material refers to.
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

// Equal bytes are one picture, whatever their names.
void find_equal(std::vector<Picture>& pictures) {
  std::multimap<std::tuple<uint64_t, size_t>, size_t> seen;
  for (size_t i = 0; i < pictures.size(); ++i) {
    Picture& picture = pictures[i];
    picture.same_as = i;
    if (!picture.error.empty()) continue;
    const std::tuple<uint64_t, size_t> key(picture.hash, picture.bytes.size());
    const auto [first, last] = seen.equal_range(key);
    const auto same = std::find_if(first, last, [&](const auto& other) {
      const Bytes bytes = pictures[other.second].bytes;
      return bytes.empty() || std::memcmp(bytes.data(), picture.bytes.data(), bytes.size()) == 0;
    });
    if (same != last) {
      picture.same_as = same->second;
    } else {
      seen.emplace(key, i);
    }
  }
}

Result<std::shared_ptr<const Image>> keep(TextureMemory* memory, Image&& image) {
  if (memory) return memory->keep(std::move(image));
  return std::make_shared<const Image>(std::move(image));
}

// Decodes the pictures from index `first` on.
void decode_all(const Document& document, std::vector<Picture>& pictures, size_t first, TextureMemory* memory,
                ProgressListener* listener) {
  std::mutex mutex;
  std::string not_kept; // why one could not be
  size_t done = 0;
  std::atomic<uint64_t> total{0};
  for (size_t i = 0; i < first; ++i) {
    if (pictures[i].same_as == i && pictures[i].decoded != nullptr) total += pictures[i].decoded->byte_count();
  }
  tbb::parallel_for(first, pictures.size(), [&](size_t i) {
    Picture& picture = pictures[i];
    if (picture.error.empty() && picture.same_as == i && total.load() <= document.limits.max_texture_bytes) {
      Result<Image> image = decode_image(picture.bytes, picture.name);
      if (image) {
        total.fetch_add(image.value().byte_count());
        Result<std::shared_ptr<const Image>> kept = keep(memory, std::move(image).value());
        if (kept) {
          picture.decoded = std::move(kept).value();
        } else {
          const std::lock_guard lock(mutex);
          not_kept = kept.error().message;
        }
      } else {
        picture.error = image.error().message;
      }
    }
    if (listener == nullptr) return;
    const std::lock_guard lock(mutex);
    ++done;
    listener->on_progress({.phase = Phase::textures,
                           .done = static_cast<double>(done),
                           .total = static_cast<double>(pictures.size() - first)});
  });
  if (!not_kept.empty()) fail("/images", not_kept);
  if (total.load() > document.limits.max_texture_bytes) {
    fail("/images", fmt::format("decoded pictures of more than {} bytes", document.limits.max_texture_bytes));
  }
}

// Fetches and decodes the pictures from index `first` on.
void load_pictures(Document& document, std::vector<Picture>& pictures, size_t first, TextureMemory* memory,
                   ProgressListener* listener) {
  tbb::parallel_for(first, pictures.size(), [&](size_t i) {
    fetch(document, pictures[i]);
    pictures[i].hash = hash_content(pictures[i].bytes);
  });
  for (size_t i = first; i < pictures.size(); ++i) {
    const Picture& picture = pictures[i];
    if (picture.owned.size() == 0) continue; // in a buffer, which has been counted
    document.bytes_read += picture.bytes.size();
    document.content_hash = hash_bytes(std::as_bytes(std::span(&picture.hash, 1)), document.content_hash);
  }
  find_equal(pictures);
  decode_all(document, pictures, first, memory, listener);
  for (size_t i = first; i < pictures.size(); ++i) {
    const Picture& source = pictures[pictures[i].same_as];
    pictures[i].decoded = source.decoded;
    pictures[i].error = source.error;
  }
}

} // namespace

void import_samplers(const Document& document, Scene& scene) {
  check_image_objects(document);
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
  std::map<int, size_t> picture_of_image;
  std::vector<Picture> pictures;
  std::vector<std::vector<int>> images(used.size());
  size_t most_images = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    images[i] = images_of(document, i);
    most_images = std::max(most_images, images[i].size());
    if (images[i].empty()) {
      warnings.add("no source", fmt::format("/textures/{}", i),
                   "a texture without a picture that can be read: the material's factor is used alone");
    }
  }

  // First what each texture prefers, then, where that could not be read, what it names besides.
  for (size_t rank = 0; rank < most_images; ++rank) {
    const size_t first = pictures.size();
    const auto wanted = [&](size_t i) { return scene.textures[i].image == nullptr && rank < images[i].size(); };
    for (size_t i = 0; i < used.size(); ++i) {
      if (!wanted(i) || !picture_of_image.emplace(images[i][rank], pictures.size()).second) continue;
      Picture picture;
      picture.image = images[i][rank];
      picture.name = short_name((*document.json)["images"][static_cast<size_t>(picture.image)], picture.image);
      pictures.push_back(std::move(picture));
    }
    load_pictures(document, pictures, first, memory, listener);
    for (size_t i = 0; i < used.size(); ++i) {
      if (!wanted(i)) continue;
      const Picture& picture = pictures[picture_of_image.at(images[i][rank])];
      if (picture.decoded == nullptr) continue;
      scene.textures[i].image = picture.decoded;
      scene.textures[i].name = picture.name;
    }
  }

  std::set<int> missed; // images of textures that have got none
  for (size_t i = 0; i < used.size(); ++i) {
    if (scene.textures[i].image == nullptr) missed.insert(images[i].begin(), images[i].end());
  }
  for (const Picture& picture : pictures) {
    if (picture.decoded != nullptr) continue;
    warnings.add(fmt::format("image {}", picture.image), fmt::format("/images/{}", picture.image),
                 fmt::format("{}: {}", picture.error,
                             missed.contains(picture.image) ? "the material's factor is used alone"
                                                            : "the texture's other picture is used"));
  }
}

Result<Image> read_image(Document& document, int image) {
  Picture picture;
  picture.image = image;
  picture.name = short_name((*document.json)["images"][static_cast<size_t>(image)], image);
  fetch(document, picture);
  if (!picture.error.empty()) return Error{ErrorKind::input_output, picture.error};
  document.bytes_read += picture.owned.size();
  document.content_hash = hash_content(picture.bytes, document.content_hash);
  return decode_image(picture.bytes, picture.name);
}

} // namespace kindling::gltf
