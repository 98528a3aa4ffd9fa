// Builds textures; images and their levels are shared by all textures of the same content.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/texture_table.h"

#include <tbb/parallel_for.h>

#include <memory>
#include <set>

namespace kindling {
namespace {

bool is_color(TextureContent content) {
  return content == TextureContent::color || content == TextureContent::cutout_color;
}

// Images without alpha need no alpha-weighted levels of their own.
TextureContent kind_of_levels(const Image& image, TextureContent content) {
  const bool has_alpha = image.channels == 2 || image.channels == 4;
  return content == TextureContent::cutout_color && !has_alpha ? TextureContent::color : content;
}

} // namespace

int32_t TextureTable::number_of(int source, TextureContent content) {
  if (!sources_[static_cast<size_t>(source)].image) return kNone;
  return numbers_.try_emplace({source, content}, static_cast<int32_t>(numbers_.size())).first->second;
}

int32_t TextureTable::number_of_procedural(int graph, int output) {
  const auto [entry, inserted] =
      procedural_numbers_.try_emplace({graph, output}, kNone - 1 - static_cast<int32_t>(procedurals_.size()));
  if (inserted) {
    procedurals_.emplace_back(graphs_[static_cast<size_t>(graph)], static_cast<size_t>(output),
                              [&](int texture, bool color) {
                                return number_of(texture, color ? TextureContent::color : TextureContent::data);
                              });
  }
  return entry->second;
}

Result<std::vector<Texture>> TextureTable::build(TextureMemory* memory, size_t& bytes) const {
  struct Job {
    const Image* image;
    TextureContent content;
    std::shared_ptr<const MipLevels> levels;
    TextureMemory::Paged paged; // used instead if paged
  };
  const bool pages = memory && memory->exceeded();
  std::vector<Job> jobs; // without duplicates
  std::map<std::pair<const Image*, TextureContent>, size_t> job_of;
  std::set<const Image*> images;
  bytes = 0;
  std::vector<std::pair<const std::pair<int, TextureContent>*, size_t>> in_order(numbers_.size()); // key, job
  for (const auto& [key, number] : numbers_) {
    const Image* image = sources_[static_cast<size_t>(key.first)].image.get();
    const TextureContent content = kind_of_levels(*image, key.second);
    const auto [entry, inserted] = job_of.try_emplace({image, content}, jobs.size());
    if (inserted) jobs.push_back({image, content, nullptr, {}});
    if (images.insert(image).second && !pages) bytes += image->byte_count();
    in_order[static_cast<size_t>(number)] = {&key, entry->second};
  }
  if (pages) {
    // Serial: the levels of only one image at a time are in memory.
    for (Job& job : jobs) {
      Result<TextureMemory::Paged> paged = memory->page(*job.image, job.content);
      if (!paged) return paged.error();
      job.paged = std::move(paged).value();
    }
  } else {
    tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) {
      jobs[i].levels = std::make_shared<const MipLevels>(build_mip_levels(*jobs[i].image, jobs[i].content));
    });
    for (const Job& job : jobs) bytes += job.levels->pixels.size();
  }

  std::vector<Texture> textures;
  textures.reserve(in_order.size());
  for (const auto& [key, job] : in_order) {
    const SceneTexture& source = sources_[static_cast<size_t>(key->first)];
    const TextureSettings settings{source.wrap_u, source.wrap_v, source.filter,
                                   is_color(key->second) ? TextureEncoding::srgb : TextureEncoding::linear};
    if (pages)
      textures.emplace_back(jobs[job].paged.tiled, *source.image, settings, jobs[job].paged.levels);
    else
      textures.emplace_back(source.image, settings, jobs[job].levels);
  }
  return textures;
}

} // namespace kindling
