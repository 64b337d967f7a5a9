#include "sim/render/path_material.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sim/render/sample_points.h"
#include "sim/truth/scene_check.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

Vector3f vec_of(const Rgbf& c) { return {c.r, c.g, c.b}; }

float lookup(const std::array<float, PathMaterial::kCells + 1>& table, float cosine) {
  const float position = std::sqrt(std::clamp(cosine, 0.0F, 1.0F)) * PathMaterial::kCells;
  const int cell = std::min(static_cast<int>(position), PathMaterial::kCells - 1);
  const float t = position - static_cast<float>(cell);
  const float* e = table.data() + cell;
  return e[0] + t * (e[1] - e[0]);
}

/// One of a glass facet's two ways; weight 0: lost to multiple scattering.
struct FacetWay {
  Vector3f in;
  float weight = 0;  ///< masking's share alone
};

FacetWay facet_way(const Ggx& facets, const Vector3f& out, const Vector3f& m, float eta,
                   bool reflects) {
  FacetWay way;
  const float out_m = std::max(out.dot(m), 0.0F);
  if (reflects) {
    way.in = 2 * out_m * m - out;
  } else {
    const float inner = std::sqrt(std::max(0.0F, 1 - (1 - out_m * out_m) / (eta * eta)));
    way.in = (out_m / eta - inner) * m - out / eta;
  }
  if ((way.in.z() > 0) != reflects || way.in.z() == 0) return way;
  const float lambda_out = facets.lambda(out.z());
  way.weight = (1 + lambda_out) / (1 + lambda_out + facets.lambda(way.in.z()));
  return way;
}

/// Mean weight over draws at each cosine.
template <class Weight>
std::array<float, PathMaterial::kCells + 1> kept_table(const Weight& weight) {
  constexpr std::uint32_t kDraws = 4096;
  std::array<float, PathMaterial::kCells + 1> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const float root = static_cast<float>(i) / static_cast<float>(PathMaterial::kCells);
    const float cosine = std::max(root * root, 1e-5F);
    const Vector3f out(std::sqrt(1 - std::min(cosine * cosine, 1.0F)), 0, cosine);
    double sum = 0, shares = 0;
    for (std::uint32_t k = 0; k < kDraws; ++k) {
      // What is lost comes from facets far from the normal, drawn near u = 1: u = 1 - s^2 puts more
      // points there.
      const Eigen::Vector2f p = sobol_point(k) + Eigen::Vector2f::Constant(0.5F / kDraws);
      const Eigen::Vector2f u(1 - p.x() * p.x(), p.y());
      sum += static_cast<double>(2 * p.x() * weight(out, u));
      shares += static_cast<double>(2 * p.x());
    }
    table[i] = static_cast<float>(sum / shares);
  }
  return table;
}

}  // namespace

float fresnel(float cosine, float eta) {
  const float g2 = eta * eta - 1 + cosine * cosine;
  if (g2 <= 0) return 1;  // total reflection
  const float g = std::sqrt(g2);
  const float a = (g - cosine) / (g + cosine);
  const float b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
  return 0.5F * a * a * (1 + b * b);
}

PathMaterial::PathMaterial(const Material& m)
    : kind((validate(m), m.kind)),
      coat(kind == SurfaceKind::coated || kind == SurfaceKind::leaf ? m.ior : 1, m.roughness),
      facets{static_cast<float>(m.roughness * m.roughness)},
      ior(static_cast<float>(m.ior)),
      albedo(vec_of(m.albedo)),
      back_albedo(vec_of(m.back_albedo.value_or(m.albedo))),
      transmittance(m.kind == SurfaceKind::leaf ? vec_of(m.transmittance) : Vector3f::Zero()),
      ink_albedo(vec_of(m.ink_albedo)),
      mean_free_path_m(vec_of(m.mean_free_path_m)),
      print(m.print),
      noise(m.noise) {
  if (kind == SurfaceKind::conductor) {
    kept_outside = kept_table([&](const Vector3f& out, const Eigen::Vector2f& u) {
      const Vector3f facet = facets.draw_visible(out, u);
      const Vector3f in = 2 * out.dot(facet) * facet - out;
      if (in.z() <= 0) return 0.0F;
      const float lambda_out = facets.lambda(out.z());
      return (1 + lambda_out) / (1 + lambda_out + facets.lambda(in.z()));
    });
  }
  if (kind == SurfaceKind::glass) {
    const auto table = [&](float eta) {
      return kept_table([&](const Vector3f& out, const Eigen::Vector2f& u) {
        const Vector3f facet = facets.draw_visible(out, u);
        const float reflected = fresnel(std::max(out.dot(facet), 0.0F), eta);
        return reflected * facet_way(facets, out, facet, eta, true).weight +
               (1 - reflected) * facet_way(facets, out, facet, eta, false).weight;
      });
    };
    kept_outside = table(ior);
    kept_inside = table(1 / ior);
  }
}

PathBsdf::Lobes PathBsdf::lobes() const {
  const PathMaterial& m = *material;
  Lobes p;
  p.coat = m.coat.exists() ? m.coat.reflected(out.z()) : 0;
  p.reflect = (1 - p.coat) * albedo.maxCoeff();
  p.transmit = (1 - p.coat) * m.transmittance.maxCoeff();
  const float sum = p.coat + p.reflect + p.transmit;
  if (!(sum > 0)) return {};
  // No less than a tenth to a lobe that exists, so that no weight grows large.
  const auto lift = [&](float v) { return v > 0 ? std::max(v / sum, 0.1F) : 0.0F; };
  p = {lift(p.coat), lift(p.reflect), lift(p.transmit)};
  const float all = p.coat + p.reflect + p.transmit;
  return {p.coat / all, p.reflect / all, p.transmit / all};
}

PathBsdf::Value PathBsdf::value(const Vector3f& in) const {
  const PathMaterial& m = *material;
  if (m.kind == SurfaceKind::conductor) return metal(in);
  if (m.kind == SurfaceKind::glass) return glass(in);
  if (m.kind == SurfaceKind::clear) return {};
  const Lobes p = lobes();
  const float cosine = std::abs(in.z());
  Value value;
  const float through = m.coat.exists() ? m.coat.leaving(out.z()) * m.coat.entering(cosine) : 1;
  const float lambert = kInversePiF * cosine;
  if (in.z() < 0) {
    value.bsdf_cosine = through * lambert * m.transmittance;
    value.density = p.transmit * lambert;
    return value;
  }
  if (part != Part::coat) {
    value.bsdf_cosine = through * lambert * (part == Part::base ? came_out : albedo);
    value.density = p.reflect * lambert;
  }
  if (m.coat.exists() && part != Part::base) {
    const Coat::Value gloss = m.coat.value(out, in);
    value.bsdf_cosine += Vector3f::Constant(gloss.brdf_cosine);
    value.density += p.coat * gloss.density;
  }
  return value;
}

PathBsdf::Draw PathBsdf::draw(const Eigen::Vector2f& u, float lobe) const {
  const PathMaterial& m = *material;
  if (m.kind == SurfaceKind::conductor) return draw_metal(u);
  if (m.kind == SurfaceKind::glass) return draw_glass(u, lobe);
  if (m.kind == SurfaceKind::clear) return draw_clear(lobe);
  const Lobes p = lobes();
  Draw draw;
  if (part != Part::whole && (lobe < p.coat) != (part == Part::coat)) return draw;
  if (lobe < p.coat) {
    const Coat::Draw gloss = m.coat.draw(out, u);
    if (gloss.weight <= 0) return draw;
    draw.in = gloss.in;
  } else {
    if (!(p.reflect + p.transmit > 0)) return draw;
    const Eigen::Vector2f d = concentric_disk(u);
    const float z = std::sqrt(std::max(1 - d.squaredNorm(), 1e-12F));
    draw.in = {d.x(), d.y(), lobe < p.coat + p.reflect ? z : -z};
  }
  const Value v = value(draw.in);
  if (!(v.density > 0)) return draw;
  draw.weight = v.bsdf_cosine / v.density;
  draw.density = v.density;
  return draw;
}

PathBsdf::Value PathBsdf::metal(const Vector3f& in) const {
  const PathMaterial& m = *material;
  if (in.z() <= 0) return {};
  const Vector3f facet = (out + in).normalized();
  const float lambda_out = m.facets.lambda(out.z()), lambda_in = m.facets.lambda(in.z());
  const float common = m.facets.distribution(facet) / (4 * out.z());
  const float c = 1 - std::clamp(out.dot(facet), 0.0F, 1.0F);
  const Vector3f reflected = albedo + (Vector3f::Ones() - albedo) * (c * c * c * c * c);
  // What single scattering loses comes back, coloured [Turquin 2019].
  const float kept = std::max(lookup(m.kept_outside, out.z()), 0.1F);
  const Vector3f again = Vector3f::Ones() + albedo * ((1 - kept) / kept);
  return {(common / (1 + lambda_out + lambda_in)) * reflected.cwiseProduct(again),
          common / (1 + lambda_out)};
}

PathBsdf::Draw PathBsdf::draw_metal(const Eigen::Vector2f& u) const {
  const Vector3f facet = material->facets.draw_visible(out, u);
  Draw draw;
  draw.in = 2 * out.dot(facet) * facet - out;
  if (draw.in.z() <= 0) return draw;
  const Value v = value(draw.in);
  if (!(v.density > 0)) return draw;
  draw.weight = v.bsdf_cosine / v.density;
  draw.density = v.density;
  return draw;
}

PathBsdf::Value PathBsdf::glass(const Vector3f& in) const {
  const PathMaterial& m = *material;
  const float eta = is_inside ? 1 / m.ior : m.ior;
  const bool reflects = in.z() > 0;
  Vector3f facet = reflects ? Vector3f(out + in) : Vector3f(out + eta * in);
  const float length = facet.norm();
  if (!(length > 1e-9F)) return {};
  facet /= facet.z() < 0 ? -length : length;
  const float out_m = out.dot(facet), in_m = in.dot(facet);
  if (out_m <= 0 || (in_m > 0) != reflects) return {};
  const float lambda_out = m.facets.lambda(out.z());
  const float visible = m.facets.distribution(facet) * out_m / (out.z() * (1 + lambda_out));
  const float reflected = fresnel(out_m, eta);
  const float root = out_m + eta * in_m;
  // Density of the facet times its change with the direction [Walter et al. 2007, eq. 14 and 17].
  const float density = reflects ? reflected * visible / (4 * out_m)
                                 : (1 - reflected) * visible * eta * eta * -in_m / (root * root);
  const float weight = (1 + lambda_out) / (1 + lambda_out + m.facets.lambda(in.z()));
  const float kept = std::max(lookup(is_inside ? m.kept_inside : m.kept_outside, out.z()), 0.1F);
  return {density * weight / kept * albedo, density};
}

PathBsdf::Draw PathBsdf::draw_glass(const Eigen::Vector2f& u, float lobe) const {
  const PathMaterial& m = *material;
  const float eta = is_inside ? 1 / m.ior : m.ior;
  const Vector3f facet = m.facets.draw_visible(out, u);
  const bool reflects = lobe < fresnel(std::max(out.dot(facet), 0.0F), eta);
  const FacetWay way = facet_way(m.facets, out, facet, eta, reflects);
  Draw draw;
  if (!(way.weight > 0)) return draw;
  const float kept = std::max(lookup(is_inside ? m.kept_inside : m.kept_outside, out.z()), 0.1F);
  draw.in = way.in;
  draw.weight = way.weight / kept * albedo;
  draw.density = glass(way.in).density;
  return draw;
}

/// Snell's refraction or mirroring.
PathBsdf::Draw PathBsdf::clear_way(bool reflects) const {
  const float eta = is_inside ? 1 / material->ior : material->ior;
  const float mirrored = fresnel(out.z(), eta);
  const float inner2 = 1 - (1 - out.z() * out.z()) / (eta * eta);
  Draw draw;
  draw.is_sharp = true;
  if (reflects) {
    draw.in = {-out.x(), -out.y(), out.z()};
    draw.weight = mirrored * albedo;
  } else if (inner2 > 0) {
    draw.in = {-out.x() / eta, -out.y() / eta, -std::sqrt(inner2)};
    draw.weight = (1 - mirrored) * albedo;
  }
  return draw;
}

/// Drawn by Fresnel's share, which the weight then leaves out.
PathBsdf::Draw PathBsdf::draw_clear(float lobe) const {
  const float eta = is_inside ? 1 / material->ior : material->ior;
  Draw draw = clear_way(lobe < fresnel(out.z(), eta));
  if (draw.weight.maxCoeff() > 0) draw.weight = albedo;
  return draw;
}

}  // namespace cousin
