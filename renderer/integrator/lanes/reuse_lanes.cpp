// Links, shares and receives the light of groups of eight paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/lanes/reuse_lanes.h"

#include "renderer/integrator/lanes/guide_lanes.h"
#include "renderer/integrator/lanes/load_structs.h"

#include <bit>
#include <cstddef>
#include <optional>

namespace kindling {
namespace {

using Vectors = Imath::Vec3<Lanes>;
template <typename T>
using Each = std::array<T, Lanes::kCount>;
static_assert(Lanes::kCount == kMaxPathReuse);

const ReusedPath kMissing{}; // where a group has no path

// The paths of a group; those that are not there receive and give nothing.
struct Members {
  Each<const ReusedPath*> paths;
  uint32_t receive = 0, give = 0; // a bit for each that receives light, and that has light to give

  Members(const ReuseView& view, const ReuseGroup& group) {
    for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) {
      paths[lane] = group[lane] == kNoPath ? &kMissing : &view.paths[group[lane]];
      receive |= paths[lane]->receives ? 1U << lane : 0U;
      give |= paths[lane]->has_light() ? 1U << lane : 0U;
    }
  }

  // Returns a vector of each path, by its offset in bytes, and the number that follows it.
  [[nodiscard]] std::array<Lanes, 4> columns(size_t offset) const { return columns_at(paths, offset); }
  [[nodiscard]] Vectors vectors(size_t offset) const { return vector_of(columns(offset)); }
};

// Returns bit i ^ other of `bits` as bit i.
uint32_t exchanged_bits(uint32_t bits, uint32_t other) {
  if ((other & 1U) != 0) bits = (bits & 0x55U) << 1 | (bits >> 1 & 0x55U);
  if ((other & 2U) != 0) bits = (bits & 0x33U) << 2 | (bits >> 2 & 0x33U);
  if ((other & 4U) != 0) bits = (bits & 0x0fU) << 4 | (bits >> 4 & 0x0fU);
  return bits;
}

// The surfaces of all paths, the first or the second ones.
struct Surfaces {
  Vectors position, origin, geometric_normal, shading_normal;
  BsdfParametersOf<Lanes> bsdf;

  // `lanes` has a bit for each path that has the surface.
  Surfaces(const Members& members, size_t offset, uint32_t lanes) {
    const auto columns = [&](size_t member) { return members.columns(offset + member); };
    static_assert(offsetof(ReusedSurface, origin) == 3 * sizeof(float) &&
                  offsetof(ReusedSurface, geometric_normal) == 6 * sizeof(float) &&
                  offsetof(ReusedSurface, shading_normal) == 9 * sizeof(float) &&
                  offsetof(ReusedSurface, bsdf) == 12 * sizeof(float));
    const auto first = columns(0), second = columns(4 * sizeof(float)), third = columns(8 * sizeof(float));
    position = vector_of(first), origin = {first[3], second[0], second[1]};
    geometric_normal = {second[2], second[3], third[0]};
    shading_normal = select(lane_mask(lanes), Vectors(third[1], third[2], third[3]), Vectors(0.0f, 0.0f, 1.0f));
    bsdf = bsdf_parameters_at(members.paths, offset + offsetof(ReusedSurface, bsdf));
  }
};

// Eight BSDFs, of which some may be Lambert's and others not.
class MixedBsdfs {
 public:
  MixedBsdfs(const BsdfParametersOf<Lanes>& parameters, const Vectors& wo) : lambertian_(is_lambertian(parameters)) {
    if (any(lambertian_)) { // those of the others are not used
      BsdfParametersOf<Lanes> matte = parameters;
      matte.metallic = matte.specular = 0.0f;
      matte_.emplace(matte, wo);
    }
    if (all(lambertian_)) return;
    BsdfParametersOf<Lanes> glossy = parameters;
    glossy.specular = select(lambertian_, Lanes(1.0f), parameters.specular);
    glossy_.emplace(glossy, wo);
  }

  [[nodiscard]] BsdfEvalOf<Lanes> eval(const Vectors& wi) const {
    if (!glossy_) return matte_->eval(wi);
    const BsdfEvalOf<Lanes> glossy = glossy_->eval(wi);
    if (!matte_) return glossy;
    const BsdfEvalOf<Lanes> matte = matte_->eval(wi);
    return {select(lambertian_, matte.value, glossy.value), select(lambertian_, matte.pdf, glossy.pdf)};
  }
  [[nodiscard]] Lanes alpha() const {
    return of_glossy([](const auto& bsdf) { return bsdf.alpha(); });
  }
  [[nodiscard]] Lanes glossy_probability() const {
    return of_glossy([](const auto& bsdf) { return bsdf.glossy_probability(); });
  }
  // Returns the diffuse part of eval().value of the narrow lobes among them, else all of it.
  [[nodiscard]] Vectors shared_value(const Vectors& wi, const Vectors& all_of_it) const {
    if (!glossy_) return all_of_it;
    const LaneMask narrow = (alpha() > 0.0f) & (alpha() < kMinSharedAlpha);
    return any(narrow) ? select(narrow, glossy_->diffuse_value(wi), all_of_it) : all_of_it;
  }

 private:
  template <typename F>
  [[nodiscard]] Lanes of_glossy(const F& f) const {
    return glossy_ ? select(lambertian_, Lanes(0.0f), f(*glossy_)) : Lanes(0.0f);
  }

  LaneMask lambertian_;
  std::optional<GltfBsdfOf<Lanes>> matte_, glossy_;
};

// Guides the first surfaces of some lanes.
void guide_all(const PathStages& stages, const Members& members, const MixedBsdfs& bsdfs, uint32_t lanes,
               GuideLanes& guides) {
  LaneNumbers glossy, alpha;
  glossy.store(bsdfs.glossy_probability()), alpha.store(bsdfs.alpha());
  for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    const ReusedSurface& surface = members.paths[lane]->first;
    guides.guide(lane, stages, surface.position, surface.shading_normal, {glossy[lane], alpha[lane]});
  }
}

// What second surfaces reflect of light that comes from one direction each: LightFrom in lanes.
struct LightOf {
  uint32_t lanes; // a bit for each that has any
  Vectors light;
  Lanes scale;  // of the light
  Lanes cosine; // of the direction
  MixedBsdfs bsdfs;
};

} // namespace

void link_group(const PathStages& stages, const ReuseView& view, const ReuseGroup& group, GroupLinks& links,
                LinkRays& rays) {
  const Members members(view, group);
  for (uint32_t place = 0; place < view.count; ++place) {
    links[place].density.store(0.0f);
    rays.traced[place] = 0;
  }
  if (members.receive == 0 || members.give == 0) return;
  const Surfaces first(members, offsetof(ReusedPath, first), members.receive),
      second(members, offsetof(ReusedPath, second), members.give);
  const auto set_link = [&](uint32_t place, uint32_t lanes, const Vectors& value, const Lanes& pdf, const Lanes& ratio,
                            const Vectors& direction) {
    links[place].value.store(value * ratio);
    links[place].density.store(select(lane_mask(lanes), pdf * ratio, Lanes(0.0f)));
    links[place].direction.store(direction);
  };
  const WayOf<Lanes> own = way_between(first.position, second.position, second.geometric_normal);
  const auto value = members.columns(offsetof(ReusedPath, value));
  static_assert(offsetof(ReusedPath, pdf) == offsetof(ReusedPath, value) + 3 * sizeof(float));
  set_link(0, members.receive & members.give, vector_of(value), value[3], absolute(own.solid_angle_per_area),
           own.direction);

  uint32_t joined = 0; // those that may be joined to others
  for (uint32_t place = 1; place < view.count; ++place) joined |= members.receive & exchanged_bits(members.give, place);
  if (joined == 0) return;
  const FrameOf<Lanes> frame = FrameOf<Lanes>::around(first.shading_normal);
  const MixedBsdfs bsdfs(first.bsdf, frame.to_local(members.vectors(offsetof(ReusedPath, wo))));
  GuideLanes guides;
  if (stages.guides_directions()) guide_all(stages, members, bsdfs, joined, guides);
  for (uint32_t place = 1; place < view.count; ++place) {
    uint32_t lanes = members.receive & exchanged_bits(members.give, place);
    if (lanes == 0) continue;
    const Vectors origin = exchanged(second.origin, place);
    const WayOf<Lanes> way =
        way_between(first.position, exchanged(second.position, place), exchanged(second.geometric_normal, place));
    const Vectors to_second = origin - first.origin;
    lanes &= packed((way.solid_angle_per_area > 0.0f) & (way.direction.dot(first.geometric_normal) > 0.0f) &
                    (to_second.length2() > 0.0f));
    if (lanes == 0) continue;
    const Vectors local = frame.to_local(way.direction);
    const BsdfEvalOf<Lanes> eval = bsdfs.eval(local);
    lanes &= packed((is_black(eval.value) == LaneMask{}) & (eval.pdf > 0.0f));
    const Lanes pdf = guides.mixed(eval.pdf, local.z, way.direction, lanes);
    lanes &= packed(pdf > 0.0f);
    if (lanes == 0) continue;
    set_link(place, lanes, eval.value, pdf, way.solid_angle_per_area, way.direction);
    const Lanes distance = length_of(to_second);
    rays.halves[place] = first_halves(first.origin, to_second / distance, distance);
    rays.traced[place] = static_cast<uint8_t>(lanes);
  }
}

void share_group(const ReuseView& view, const ReuseGroup& group, const GroupLinks& links, PathState* states) {
  const Members members(view, group);
  Lanes density = 0.0f; // with which all first surfaces find a second one
  for (uint32_t place = 0; place < view.count; ++place)
    density = density + exchanged(links[place].density.load(), place);
  const uint32_t give = members.give & packed(density > 0.0f);
  if (give == 0) return;
  const Surfaces second(members, offsetof(ReusedPath, second), give);
  const FrameOf<Lanes> frame = FrameOf<Lanes>::around(second.shading_normal);
  const auto light_of = [&](const Vectors& light, const Vectors& wi, const Lanes& scale) -> std::optional<LightOf> {
    const uint32_t lanes = give & ~packed(is_black(light));
    if (lanes == 0) return std::nullopt;
    return LightOf{lanes, light, scale, wi.dot(frame.normal), MixedBsdfs(second.bsdf, frame.to_local(wi))};
  };
  const auto tail_wi = members.columns(offsetof(ReusedPath, tail_wi));
  static_assert(offsetof(ReusedPath, tail_pdf) == offsetof(ReusedPath, tail_wi) + 3 * sizeof(float));
  const Vectors throughput = members.vectors(offsetof(ReusedPath, throughput));
  const auto own_link = members.columns(offsetof(ReusedPath, value));
  const std::optional<LightOf> sampled = light_of(members.vectors(offsetof(ReusedPath, light)),
                                                  members.vectors(offsetof(ReusedPath, light_wi)), 1.0f),
                               tail = light_of(members.vectors(offsetof(ReusedPath, tail)), vector_of(tail_wi),
                                               1.0f / tail_wi[3]);
  Vectors own(Lanes(0.0f)), received(Lanes(0.0f));
  for (uint32_t place = 0; place < view.count; ++place) {
    const Lanes joined = links[place].density.load();
    const uint32_t lanes = give & packed(exchanged(joined, place) > 0.0f);
    if (lanes == 0) continue;
    const Vectors value = exchanged(links[place].value.load(), place);
    const Vectors local = frame.to_local(-exchanged(links[place].direction.load(), place));
    Vectors given(Lanes(0.0f));
    for (const std::optional<LightOf>* of : {&sampled, &tail}) {
      if (!*of || ((*of)->lanes & lanes) == 0) continue;
      const LightOf& from = **of;
      const LaneMask here = lane_mask(from.lanes & lanes);
      const Lanes cosines = select(local.z > 0.0f, from.cosine / local.z, Lanes(0.0f));
      const Vectors reflected = from.bsdfs.eval(local).value;
      const Vectors everything = reflected * cosines, shared = from.bsdfs.shared_value(local, reflected) * cosines;
      const Vectors part = value * shared * Lanes(from.scale / density) * from.light;
      given = select(here, given + part, given);
      if (place != 0) continue;
      const Vectors alone =
          throughput * vector_of(own_link) * (everything - shared) * Lanes(from.scale / own_link[3]) * from.light;
      own = select(here, own + alone, own);
    }
    received = received + exchanged(given, place);
  }
  const Vectors light = throughput * received;
  for (uint32_t rest = members.receive; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
    Rgb& sum = states[group[lane]].light[kIndirect];
    sum += lane_of(light, lane);
    sum += lane_of(own, lane);
  }
}

} // namespace kindling
