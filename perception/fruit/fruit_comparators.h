#pragma once

#include <cstdint>

#include "perception/fruit/fruit_fit.h"

namespace cousin {

/// Other ways from a fruit's visible surface to its size. None says how sure it is: sigmas are NaN.

/// The sphere through the points by least squares of their distances, from that on |p|^2 = 2 c p +
/// d [Coope 1993].
FruitFit fit_sphere(const FruitSurface& surface, const FruitPrior& prior = {});

/// The general quadric through the points by least squares, refused where it is no ellipsoid, as
/// often of a part of one. Its size across is the mean of its two longer axes.
FruitFit fit_ellipsoid(const FruitSurface& surface, const FruitPrior& prior = {});

/// The convex hull of the points and of their mirror images behind the plane across the view beyond
/// 95 % of them: twice what is seen. It wants points up to the outline
/// (FruitSurfaceConfig::rim_px).
FruitFit fit_hull(const FruitSurface& surface, const FruitPrior& prior = {});

/// Circles through three places of the outline are tried. The one that most other places agree with
/// is refined on those [Kasa 1976]. Its size at the fruit's depth is the diameter. Volume is that
/// of the kind's mean shape at this diameter (allometry with exponent 3).
FruitFit fit_allometry(const FruitSurface& surface, const FruitPrior& prior = {});

/// What fills a box when it stands upright.
enum class BoxBody { ellipsoid, cone };
/// An upright body as wide and high as its box at a depth: its centre is half its width behind the
/// surface. A cone is truncated: its tip is `kConeTip` as wide as its shoulders.
/// @param surface_m  under the middle of the box
/// @param why_none   not empty: there is no such point, and so no body
FruitFit fit_box(const DetectedBox& box, const Camera& camera, const Eigen::Vector3d& surface_m,
                 const std::string& why_none, BoxBody body, const FruitPrior& prior);
inline constexpr double kConeTip = 0.4;

}  // namespace cousin
