#pragma once

#include "sim/render/truth_pass.h"

namespace cousin {

/// Direction of a pixel's centre and its change per pixel along x and y, by differences within the
/// image; zero where there is no ray, or a neighbour has none. Along y the camera is held, as a row
/// is exposed at once.
struct PixelDirections {
  Eigen::Vector3f centre, slope_x, slope_y;
};
PixelDirections pixel_directions(const PreparedRays& rays, int x, int y);

/// Places of a specimen's surface among the geometries: its own, and its organs'.
struct SpecimenGeometries {
  int id = 0;  ///< the specimen's Instance::id
  std::vector<std::size_t> geometries;
};
/// By Instance::id.
std::vector<SpecimenGeometries> specimens_by_id(const RayScene::Impl& impl);

/// The area of each specimen in each pixel, from `samples` rays to every pixel: see TruthNeeds.
std::vector<InstanceShares> specimen_shares(const RayScene& rays, const PreparedRays& prepared,
                                            int samples);

/// Share of each pixel's area that shows a specimen, from `samples` stratified rays where a pixel
/// and its eight neighbours do not agree; 0 or 1 elsewhere. Private to sim/render.
/// @param is_specimen  at pixel centres: 1 = specimen first hit.
Image<float> specimen_coverage(const RayScene& rays, const PreparedRays& prepared,
                               const Image<std::uint8_t>& is_specimen, int samples);

/// Full masks and visible fractions of all specimens, by id. @param instance  ids at pixel centres.
void add_visibility(const RayScene& rays, const TrueView& view, const PreparedRays& prepared,
                    const Image<std::int32_t>& instance, TruthImages& truth);

}  // namespace cousin
