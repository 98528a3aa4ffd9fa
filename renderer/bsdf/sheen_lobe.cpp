// Evaluation and sampling of the sheen lobe.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/sheen_lobe.h"

#include "renderer/base/on_gpu.h"
#include "renderer/sampling/warp.h"

namespace kindling {

namespace {

constexpr float kLog2E = std::numbers::log2e_v<float>;

} // namespace

template <typename Each>
SheenLobeOf<Each>::SheenLobeOf(const Each& roughness, const Vector& wo, const SheenNode* table)
    : wo_(wo), gain_(roughness < kSheenGainRoughness) {
  const Each alpha = roughness * roughness;
  inverse_alpha_ = 1.0f / alpha;
  norm_ = (2.0f + inverse_alpha_) * (0.125f * kInvPi) / wo.z;

  const Each t = square(1.0f - alpha);
  const auto fit = [&t](float rough, float smooth) { return lerp(Each(rough), Each(smooth), t); };
  a_ = fit(21.5473f, 25.3245f) * kLog2E;
  b_ = fit(3.82987f, 3.32435f);
  c_ = fit(0.19823f, 0.16801f);
  d_ = fit(-1.97760f, -1.27393f) * kLog2E;
  e_ = fit(-4.32054f, -4.85967f) * kLog2E;
  twice_half_ = 2.0f * (a_ / (1.0f + b_ * fast_exp2(Each(-c_))) + 0.5f * d_ + e_);
  shadowing_o_ = shadowing(wo.z);

  const Each y = (roughness - kMinSheenRoughness) * ((kSheenRoughnessNodes - 1) / (1.0f - kMinSheenRoughness));
  if constexpr (kInLanes) {
    const Int8 rows = cells_of(y, kSheenRoughnessNodes - 2);
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) rows_[lane] = table + rows[lane] * int{kSheenMuNodes};
    fraction_ = y - Lanes(__builtin_convertvector(rows, Float8));
  } else {
    const uint32_t row = cell_of(y, kSheenRoughnessNodes - 2);
    rows_[0] = table + row * kSheenMuNodes;
    fraction_ = y - static_cast<float>(row);
  }

  const Column<Each> column = column_of(wo.z);
  const auto seen = [&](float SheenNode::*member) { return at_column(column, member); };
  albedo_ = seen(&SheenNode::albedo);
  greater_ = seen(&SheenNode::greater);
  if (any(gain_)) raw_o_ = select(gain_, maximum(Each(1.0f), seen(&SheenNode::raw)), Each(1.0f));
  stretch_x_ = seen(&SheenNode::stretch_x);
  stretch_y_ = seen(&SheenNode::stretch_y);
  shear_ = seen(&SheenNode::shear);
  pdf_norm_ = stretch_x_ * stretch_y_ * kInvPi;

  const Each length = square_root(Each(wo.x * wo.x + wo.y * wo.y));
  const auto has_azimuth = length > 1e-12f;
  cos_azimuth_ = select(has_azimuth, Each(wo.x / length), Each(1.0f));
  sin_azimuth_ = select(has_azimuth, Each(wo.y / length), Each(0.0f));
}

template <typename Each>
template <typename Real>
typename SheenLobeOf<Each>::template Column<Real> SheenLobeOf<Each>::column_of(const Real& mu) {
  const Real x = square_root(minimum(mu, Real(1.0f))) * static_cast<float>(kSheenMuNodes - 1);
  if constexpr (std::is_same_v<Real, Lanes>) {
    const Int8 cells = cells_of(x, kSheenMuNodes - 2);
    return {cells, x - Lanes(__builtin_convertvector(cells, Float8))};
  } else {
    const uint32_t cell = cell_of(x, kSheenMuNodes - 2);
    return {cell, x - static_cast<float>(cell)};
  }
}

// Interpolates between two rows.
template <typename Each>
template <typename Real>
Real SheenLobeOf<Each>::at_column(const Column<Real>& column, float SheenNode::*member) const {
  const auto interpolate = [&](const Real(&corners)[4]) {
    const Real upper = corners[0] + (corners[1] - corners[0]) * column.s;
    const Real lower = corners[2] + (corners[3] - corners[2]) * column.s;
    return Real(upper + (lower - upper) * fraction_);
  };
  if constexpr (std::is_same_v<Real, Lanes>) {
    LaneNumbers corners[4];
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const SheenNode* const n = rows_[kInLanes ? lane : 0] + column.cell[lane];
      const SheenNode* const m = n + kSheenMuNodes;
      corners[0][lane] = n[0].*member, corners[1][lane] = n[1].*member;
      corners[2][lane] = m[0].*member, corners[3][lane] = m[1].*member;
    }
    return interpolate({corners[0].load(), corners[1].load(), corners[2].load(), corners[3].load()});
  } else {
    const SheenNode* const n = rows_[0] + column.cell;
    const SheenNode* const m = n + kSheenMuNodes;
    return interpolate({n[0].*member, n[1].*member, m[0].*member, m[1].*member});
  }
}

template <typename Each>
template <typename Real>
Real SheenLobeOf<Each>::albedo(const Real& mu) const {
  return at_column(column_of(mu), &SheenNode::albedo);
}

template <typename Each>
template <typename Real>
Real SheenLobeOf<Each>::shadowing(const Real& mu) const {
  const auto low = mu < 0.5f;
  const Real x = select(low, mu, maximum(Real(1.0f - mu), Real(0.0f)));
  const Real l = a_ / (1.0f + b_ * fast_pow(x, c_)) + d_ * x + e_;
  return fast_exp2(select(low, l, Real(twice_half_ - l)));
}

template <typename Each>
template <typename Real>
Real SheenLobeOf<Each>::raw_value(const Imath::Vec3<Real>& wi) const {
  const Real x = wo_.x + wi.x, y = wo_.y + wi.y, z = wo_.z + wi.z;
  const Real across2 = x * x + y * y;
  const Real sin2 = minimum(Real(across2 / (across2 + z * z)), Real(1.0f));
  const Real d = fast_pow(sin2, 0.5f * inverse_alpha_);
  return norm_ * d / (1.0f + shadowing_o_ + shadowing(wi.z));
}

template <typename Each>
template <typename Real>
Real SheenLobeOf<Each>::pdf(const Imath::Vec3<Real>& wi) const {
  const Real x = stretch_x_ * (cos_azimuth_ * wi.x + sin_azimuth_ * wi.y) - shear_ * wi.z;
  const Real y = stretch_y_ * (cos_azimuth_ * wi.y - sin_azimuth_ * wi.x);
  const Real length2 = x * x + y * y + wi.z * wi.z;
  return pdf_norm_ * wi.z / (length2 * length2);
}

template <typename Each>
template <typename Real>
typename SheenLobeOf<Each>::template EvalOf<Real> SheenLobeOf<Each>::eval(const Imath::Vec3<Real>& wi) const {
  Real value = raw_value(wi);
  if (any(gain_)) {
    const Real gain = maximum(Real(raw_o_), at_column(column_of(wi.z), &SheenNode::raw));
    value = select(gain_, Real(value / gain), value);
  }
  return {value, pdf(wi)};
}

template <typename Each>
Imath::Vec3<Each> SheenLobeOf<Each>::sample(const Imath::Vec2<Each>& u) const {
  const Vector w = sample_cosine_hemisphere(u);
  const Each x = (w.x + shear_ * w.z) / stretch_x_;
  const Each y = w.y / stretch_y_;
  const Vector local(x * cos_azimuth_ - y * sin_azimuth_, x * sin_azimuth_ + y * cos_azimuth_, w.z);
  return local * Each(1.0f / length_of(local));
}

template class SheenLobeOf<float>;
template float SheenLobe::raw_value(const V3f&) const;
template SheenLobe::Eval SheenLobe::eval(const V3f&) const;
template float SheenLobe::albedo(const float&) const;
#if !KINDLING_ON_GPU
template Lanes SheenLobe::albedo(const Lanes&) const;
template SheenLobe::EvalOf<Lanes> SheenLobe::eval(const Imath::Vec3<Lanes>&) const;
template class SheenLobeOf<Lanes>;
template Lanes SheenLobeOf<Lanes>::albedo(const Lanes&) const;
template SheenLobeOf<Lanes>::Eval SheenLobeOf<Lanes>::eval(const Imath::Vec3<Lanes>&) const;
#endif

} // namespace kindling
