#include <algorithm>
#include <cmath>

// The point type is ours, so that every template of PCL is compiled here: Debian's PCL is built for
// 16-byte alignment, and a cloud that its code allocates may not be freed by code built for AVX,
// where Eigen has another allocator.
#define PCL_NO_PRECOMPILE
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/ransac.h>
#include <pcl/sample_consensus/sac_model_plane.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include "perception/cloud/clusters.h"

/// A cloud's point as PCL wants it. Its voxel grid averages position, normal, colour and curvature,
/// and no field of another name: what it calls curvature is our sigma, m.
struct EIGEN_ALIGN16 PaperPoint {
  PCL_ADD_POINT4D;
  PCL_ADD_NORMAL4D;
  PCL_ADD_RGB;
  float curvature;
};
POINT_CLOUD_REGISTER_POINT_STRUCT(
    PaperPoint,
    (float, x, x)(float, y, y)(float, z, z)(float, normal_x, normal_x)(float, normal_y, normal_y)(
        float, normal_z, normal_z)(float, rgb, rgb)(float, curvature, curvature))

namespace cousin {
namespace {

using PclCloud = pcl::PointCloud<PaperPoint>;

/// A plane model whose random draws come from our stream; PCL's own seed is fixed or a clock.
class SeededPlane : public pcl::SampleConsensusModelPlane<PaperPoint> {
 public:
  SeededPlane(const PclCloud::ConstPtr& cloud, std::uint32_t seed)
      : pcl::SampleConsensusModelPlane<PaperPoint>(cloud, false) {
    rng_alg_.seed(seed);
  }
};

/// PCL's copy of the finite points, about their mean: its sums are in float.
PclCloud::Ptr to_pcl(const Cloud& cloud, Eigen::Vector3d& mean_m) {
  std::size_t count = 0;
  mean_m.setZero();
  for (const CloudPoint& p : cloud) {
    if (!p.position_m.allFinite()) continue;
    mean_m += p.position_m.cast<double>();
    ++count;
  }
  if (count > 0) mean_m /= static_cast<double>(count);
  auto result = std::make_shared<PclCloud>();
  result->reserve(count);
  for (const CloudPoint& p : cloud) {
    if (!p.position_m.allFinite()) continue;
    PaperPoint q{};
    q.getVector3fMap() = (p.position_m.cast<double>() - mean_m).cast<float>();
    q.getNormalVector3fMap() = p.normal.allFinite() ? p.normal : Eigen::Vector3f::Zero();
    q.r = p.color.r;
    q.g = p.color.g;
    q.b = p.color.b;
    q.curvature = std::isfinite(p.sigma_m) ? p.sigma_m : 0;
    result->push_back(q);
  }
  return result;
}

CloudPoint from_pcl(const PaperPoint& q, const Eigen::Vector3d& mean_m) {
  CloudPoint p;
  p.position_m = (q.getVector3fMap().cast<double>() + mean_m).cast<float>();
  p.normal = q.getNormalVector3fMap();
  const float length = p.normal.norm();
  p.normal = length > 0.1F ? Eigen::Vector3f(p.normal / length) : Eigen::Vector3f::Zero();
  p.color = {q.r, q.g, q.b};
  p.sigma_m = q.curvature;
  return p;
}

PclCloud::Ptr without_outliers(const PclCloud::Ptr& cloud, const PaperClusterConfig& config) {
  if (static_cast<int>(cloud->size()) <= config.outlier_neighbours) return cloud;
  pcl::StatisticalOutlierRemoval<PaperPoint> filter;
  filter.setInputCloud(cloud);
  filter.setMeanK(config.outlier_neighbours);
  filter.setStddevMulThresh(config.outlier_sigma);
  auto result = std::make_shared<PclCloud>();
  filter.filter(*result);
  return result;
}

/// PCL's voxel grid indexes cells by an int: where the extent asks for more, its filter returns the
/// input unthinned and only prints a warning.
PclCloud::Ptr in_voxels(const PclCloud::Ptr& cloud, double voxel_m) {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e300), high = -low;
  for (const auto& p : *cloud) {
    low = low.min(p.getArray3fMap().cast<double>());
    high = high.max(p.getArray3fMap().cast<double>());
  }
  if (((high - low) / voxel_m + 2).prod() > 2147483647.0) {
    throw std::runtime_error("paper_clusters.voxel_m = " + std::to_string(voxel_m) +
                             " is too small for the extent of the cloud: more than 2^31 voxels");
  }
  pcl::VoxelGrid<PaperPoint> filter;
  filter.setInputCloud(cloud);
  const float leaf = static_cast<float>(voxel_m);
  filter.setLeafSize(leaf, leaf, leaf);
  auto result = std::make_shared<PclCloud>();
  filter.filter(*result);
  return result;
}

/// Indices of what stands on the plane; empty if there is no plane.
pcl::IndicesPtr above_plane(const PclCloud::Ptr& cloud, double distance_m, std::uint32_t seed,
                            const Eigen::Vector3d& up) {
  auto above = std::make_shared<pcl::Indices>();
  if (cloud->size() < 3) return above;
  const auto model = std::make_shared<SeededPlane>(cloud, seed);
  pcl::RandomSampleConsensus<PaperPoint> ransac(model, distance_m);
  ransac.setMaxIterations(1000);
  ransac.setProbability(0.999);
  if (!ransac.computeModel()) return above;
  pcl::Indices inliers;
  Eigen::VectorXf plane, refined;
  ransac.getInliers(inliers);
  ransac.getModelCoefficients(plane);
  model->optimizeModelCoefficients(inliers, plane, refined);
  if (refined.head<3>().dot(up.cast<float>()) < 0) refined = -refined;
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    const float d = refined.head<3>().dot((*cloud)[i].getVector3fMap()) + refined[3];
    if (d > static_cast<float>(distance_m)) above->push_back(static_cast<int>(i));
  }
  return above;
}

}  // namespace

Clusters cluster_as_paper(const Cloud& cloud, const PaperClusterConfig& config, Rng rng,
                          const Eigen::Vector3d& up) {
  validate(config);
  Clusters result;
  Eigen::Vector3d mean_m;
  PclCloud::Ptr points = to_pcl(cloud, mean_m);
  if (points->empty()) return result;
  points = in_voxels(without_outliers(points, config), config.voxel_m);
  for (const auto& p : *points) result.cloud.push_back(from_pcl(p, mean_m));
  result.instance.assign(points->size(), -1);
  const pcl::IndicesPtr above = above_plane(points, config.plane_distance_m,
                                            static_cast<std::uint32_t>(rng.fork("plane")()), up);
  if (above->empty()) return result;

  pcl::EuclideanClusterExtraction<PaperPoint> extraction;
  extraction.setInputCloud(points);
  extraction.setIndices(above);
  extraction.setSearchMethod(std::make_shared<pcl::search::KdTree<PaperPoint>>());
  extraction.setClusterTolerance(config.cluster_distance_m);
  extraction.setMinClusterSize(config.cluster_min_points);
  extraction.setMaxClusterSize(static_cast<int>(points->size()));
  std::vector<pcl::PointIndices> found;
  extraction.extract(found);
  // PCL orders by size; ours is by first point.
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return *std::min_element(a.indices.begin(), a.indices.end()) <
           *std::min_element(b.indices.begin(), b.indices.end());
  });
  for (const pcl::PointIndices& cluster : found) {
    for (const int i : cluster.indices) result.instance[static_cast<std::size_t>(i)] = result.count;
    ++result.count;
  }
  return result;
}

}  // namespace cousin
