#include "perception/silhouette/outlines.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "perception/silhouette/contour_line.h"
#include "perception/silhouette/edge_fit.h"
#include "perception/silhouette/object_window.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kFirstSearch_px = 2;
constexpr double kMaskSmoothing_px = 1.0;  ///< along the line: the mask's is jagged
constexpr double kFitSmoothing_px = 1.0;   ///< of the first fit, for normals and curvatures
constexpr double kMaxSigma_px = 0.5;       ///< a fit less sure than this is not on the object
constexpr double kOtherReach_px = 4;       ///< an outline nearer to another object may be cut by it
constexpr double kModelSigma_px =
    0.08;  ///< what the edge's model does not say, added in quadrature

ViewClusters project_clusters(const Image<Rgb8>& image, const FramePose& pose,
                              const Clusters& clusters) {
  ViewClusters view{&image, pose, {}};
  view.pixels_px.resize(static_cast<std::size_t>(std::max(0, clusters.count)));
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    const int instance = clusters.instance[i];
    if (instance < 0 || instance >= clusters.count) continue;
    const auto pixel =
        project(pose.camera, pose.camera_from_world * clusters.cloud[i].position_m.cast<double>());
    if (pixel && pixel->allFinite())
      view.pixels_px[static_cast<std::size_t>(instance)].push_back(pixel->cast<float>());
  }
  return view;
}

struct FittedVertex {
  ContourVertex vertex;
  std::optional<EdgeFit> fit;
};

std::vector<FittedVertex> fit_edges(const ObjectWindow& window,
                                    const std::vector<ContourVertex>& contour,
                                    const EdgeFitOptions& options) {
  std::vector<FittedVertex> fitted;
  fitted.reserve(contour.size());
  for (const ContourVertex& vertex : contour)
    fitted.push_back({vertex, fit_edge(window, vertex, options)});
  return fitted;
}

/// The contour moved by its fits; where there is none, or it is far from its neighbours', by the
/// neighbours' median.
std::vector<Eigen::Vector2d> moved(const std::vector<FittedVertex>& fitted) {
  const int count = static_cast<int>(fitted.size());
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < count; ++i) {
    std::vector<double> near;
    for (int k = -3; k <= 3; ++k) {
      const auto& neighbour = fitted[static_cast<std::size_t>(((i + k) % count + count) % count)];
      if (neighbour.fit && neighbour.fit->sigma_px < kMaxSigma_px)
        near.push_back(neighbour.fit->offset_px);
    }
    const FittedVertex& here = fitted[static_cast<std::size_t>(i)];
    double offset = 0;
    if (!near.empty()) {
      const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
      std::nth_element(near.begin(), middle, near.end());
      offset = *middle;
    }
    const bool sure = here.fit && here.fit->sigma_px < kMaxSigma_px &&
                      std::abs(here.fit->offset_px - offset) < 0.7;
    if (sure) offset = here.fit->offset_px;
    line.push_back(here.vertex.pixel_px + offset * here.vertex.normal);
  }
  return line;
}

OutlinePoint outline_point(const FittedVertex& fitted, const ObjectWindow& window,
                           const OutlineConfig& config) {
  const Eigen::Vector2d origin(window.box.x, window.box.y);
  OutlinePoint point;
  point.normal = fitted.vertex.normal.cast<float>();
  if (!fitted.fit) {
    point.pixel_px = (origin + fitted.vertex.pixel_px).cast<float>();
    point.sigma_px = static_cast<float>(kMaxSigma_px);
    point.on_object = false;
    return point;
  }
  const EdgeFit& fit = *fitted.fit;
  point.pixel_px =
      (origin + fitted.vertex.pixel_px + fit.offset_px * fitted.vertex.normal).cast<float>();
  point.sigma_px = static_cast<float>(std::hypot(kModelSigma_px, fit.sigma_px));
  const int x = std::clamp(static_cast<int>(std::lround(fitted.vertex.pixel_px.x())), 0,
                           window.box.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(fitted.vertex.pixel_px.y())), 0,
                           window.box.height - 1);
  const bool alone = window.to_others_px(x, y) > static_cast<float>(kOtherReach_px);
  point.on_object = alone && fit.sigma_px < kMaxSigma_px && std::abs(fit.offset_px) < 1.5 &&
                    fit.contrast >= config.min_contrast;
  return point;
}

std::vector<OutlinePoint> outline_in(const ViewClusters& view, std::size_t instance,
                                     const BoardPattern& pattern, const OutlineConfig& config) {
  const auto window = open_window(view, instance, pattern, config);
  if (!window) return {};
  std::vector<ContourVertex> contour =
      smooth_contour(trace_mask(rough_mask(*window, config)), kMaskSmoothing_px);
  EdgeFitOptions options{config.blur_sigma_px, kFirstSearch_px};
  std::vector<FittedVertex> fitted = fit_edges(*window, contour, options);
  contour = smooth_contour(moved(fitted), kFitSmoothing_px);
  options.search_px = 0;
  fitted = fit_edges(*window, contour, options);
  std::vector<OutlinePoint> outline;
  for (const FittedVertex& vertex : fitted)
    outline.push_back(outline_point(vertex, *window, config));
  return outline;
}

}  // namespace

Fields fields(OutlineConfig& config) {
  return {
      {"margin_px", &config.margin_px, "searched beyond the cluster's projection", 1, 100},
      {"min_contrast", &config.min_contrast,
       "linear colour between seed and board across the outline", 0, 1},
      {"blur_sigma_px", &config.blur_sigma_px, "Gaussian of lens and pixel response", 0, 10},
  };
}

void validate(const OutlineConfig& config) {
  OutlineConfig copy = config;
  check_limits(fields(copy));
}

Silhouettes find_outlines(const Capture& capture, const Poses& poses, const SeedBoard& board,
                          const Clusters& clusters, const OutlineConfig& config) {
  validate(config);
  validate(board);
  if (poses.size() != capture.frames.size()) {
    throw std::invalid_argument(std::to_string(poses.size()) + " poses for " +
                                std::to_string(capture.frames.size()) + " frames");
  }
  if (clusters.instance.size() != clusters.cloud.size()) {
    throw std::invalid_argument("clusters: " + std::to_string(clusters.instance.size()) +
                                " instances for " + std::to_string(clusters.cloud.size()) +
                                " points");
  }
  const BoardPattern pattern(board);
  std::vector<Silhouettes> found(poses.size());
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t f) {
    const FramePose& pose = poses[f];
    if (pose.status != PoseStatus::ok || capture.frames[f].sensors.empty()) return;
    const Image<Rgb8>& image = capture.frames[f].sensors[0].color;
    if (image.width() != pose.camera.width_px || image.height() != pose.camera.height_px) return;
    const ViewClusters view = project_clusters(image, pose, clusters);
    for (std::size_t i = 0; i < view.pixels_px.size(); ++i) {
      std::vector<OutlinePoint> outline = outline_in(view, i, pattern, config);
      if (!outline.empty())
        found[f].push_back({pose.frame, static_cast<int>(i), std::move(outline)});
    }
  });
  Silhouettes silhouettes;
  for (Silhouettes& part : found)
    std::move(part.begin(), part.end(), std::back_inserter(silhouettes));
  return silhouettes;
}

}  // namespace cousin
