#include "perception/sfm/track_bundle.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "calibration/bundle/triangulation.h"

namespace cousin {

BundleAdjustmentInput track_bundle(const SfmModel& model, const std::optional<Camera>& lens,
                                   double sigma_px) {
  BundleAdjustmentInput input;
  if (lens) {
    input.lenses = {*lens};
  } else if (!model.lenses.empty()) {
    input.lenses = {model.lenses.front()};
  }
  input.lens_of_image.assign(model.images.size(), 0);
  input.camera_from_world = model.camera_from_world;
  std::map<int, int> place;
  for (std::size_t i = 0; i < model.images.size(); ++i)
    place[model.images[i]] = static_cast<int>(i);
  for (const SfmPoint& point : model.points) {
    const auto index = static_cast<int>(input.points_in_world_m.size());
    input.points_in_world_m.push_back(point.in_world_m);
    for (const SfmSighting& seen : point.sightings) {
      const auto found = place.find(seen.image);
      if (found == place.end())
        throw std::invalid_argument("track_bundle: a sighting in image " +
                                    std::to_string(seen.image) + ", which is not placed");
      input.observations.push_back({found->second, index, seen.pixel_px, sigma_px});
    }
  }
  return input;
}

std::vector<BoardCorner> board_corners(const BundleAdjustmentResult& bundle,
                                       const std::vector<Camera>& lens_of_image,
                                       const std::vector<int>& images, const Corners& corners,
                                       double floor_px) {
  std::map<std::pair<int, int>, std::vector<BundleObservation>> seen;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const FrameCorners& own = corners.at(static_cast<std::size_t>(images[i]));
    if (own.status != BoardStatus::ok) continue;
    for (const CornerObservation& corner : own.corners) {
      BundleObservation observation;
      observation.image = static_cast<int>(i);
      observation.pixel_px = corner.pixel_px;
      observation.sigma_px = std::hypot(rms_sigma_px(corner.covariance_px2), floor_px);
      seen[{corner.row, corner.column}].push_back(observation);
    }
  }
  std::vector<BoardCorner> result;
  for (auto& [place, observations] : seen) {
    if (observations.size() < 2) continue;
    std::vector<PointSighting> sightings;
    for (const BundleObservation& observation : observations) {
      const auto image = static_cast<std::size_t>(observation.image);
      sightings.push_back(
          {lens_of_image.at(image), bundle.camera_from_world.at(image), observation.pixel_px,
           // Poses and lens are a model's, not the truth: a sighting may miss by their error.
           isotropic_px2(std::hypot(observation.sigma_px, 1))});
    }
    const Triangulation found = triangulate(sightings);
    if (found.status != TriangulationStatus::ok) continue;
    result.push_back({place.second, place.first, found.in_world_m, std::move(observations)});
  }
  return result;
}

SquareScale scale_by_squares(const SeedBoard& board, const std::vector<BoardCorner>& corners) {
  std::map<std::pair<int, int>, Eigen::Vector3d> at;
  for (const BoardCorner& corner : corners) at[{corner.row, corner.column}] = corner.in_world_m;
  std::vector<double> sides;
  for (const auto& [place, point] : at) {
    for (const std::pair<int, int>& next :
         {std::pair{place.first, place.second + 1}, std::pair{place.first + 1, place.second}}) {
      const auto other = at.find(next);
      if (other != at.end()) sides.push_back((other->second - point).norm());
    }
  }
  SquareScale result;
  result.sides = static_cast<int>(sides.size());
  if (sides.size() < 2) return result;
  const auto n = static_cast<double>(sides.size());
  double mean = 0, squares = 0;
  for (const double side : sides) mean += side / n;
  for (const double side : sides) squares += (side - mean) * (side - mean);
  result.scale = board.square_m / mean;
  result.sigma_share = std::sqrt(squares / (n - 1) / n) / mean;
  return result;
}

}  // namespace cousin
