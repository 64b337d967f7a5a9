#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace cousin {

/// GGX microfacets [Walter et al. 2007; Heitz, JCGT 2018]. Directions are unit and in the surface's
/// frame, z along the normal. Private to sim/render.
struct Ggx {
  float alpha = 1;

  /// Normal drawn from those visible along `out` [Heitz 2018, listing 1].
  Eigen::Vector3f draw_visible(const Eigen::Vector3f& out, const Eigen::Vector2f& u) const {
    const Eigen::Vector3f v =
        Eigen::Vector3f(alpha * out.x(), alpha * out.y(), out.z()).normalized();
    const float length2 = v.x() * v.x() + v.y() * v.y();
    const Eigen::Vector3f t1 =
        length2 > 0 ? Eigen::Vector3f(Eigen::Vector3f(-v.y(), v.x(), 0) / std::sqrt(length2))
                    : Eigen::Vector3f::UnitX();
    const Eigen::Vector3f t2 = v.cross(t1);
    const float r = std::sqrt(u.x());
    const float phi = 2 * std::numbers::pi_v<float> * u.y();
    const float p1 = r * std::cos(phi);
    const float s = 0.5F * (1 + v.z());
    const float p2 = (1 - s) * std::sqrt(std::max(0.0F, 1 - p1 * p1)) + s * r * std::sin(phi);
    const Eigen::Vector3f n =
        p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0F, 1 - p1 * p1 - p2 * p2)) * v;
    return Eigen::Vector3f(alpha * n.x(), alpha * n.y(), std::max(1e-7F, n.z())).normalized();
  }

  float distribution(const Eigen::Vector3f& m) const {
    const float a2 = alpha * alpha;
    const float sin2 = m.x() * m.x() + m.y() * m.y();
    const float d = sin2 + a2 * m.z() * m.z();  // (cos^2 (a^2 - 1) + 1) without cancellation
    return a2 / (std::numbers::pi_v<float> * d * d);
  }

  /// Smith's lambda at the cosine of a direction.
  float lambda(float cosine) const {
    const float c2 = std::max(cosine * cosine, 1e-12F);
    return 0.5F * (std::sqrt(1 + alpha * alpha * (1 - c2) / c2) - 1);
  }
};

}  // namespace cousin
