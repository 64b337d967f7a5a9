#include "perception/splats/splat_start.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "perception/splats/near_points.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/colmap_points.h"
#include "sim/geometry/ply_rows.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostStartBytes = std::size_t{1} << 32;
constexpr double kFirstHarmonic = 0.28209479177387814;  ///< Y of degree 0: 1 / sqrt(4 pi)
constexpr double kFarOff = 100;       ///< coordinates over spread, beyond which an origin is kept
constexpr double kLeastShare = 0.01;  ///< of the median scale

[[noreturn]] void fail_config(const std::string& what) {
  throw std::invalid_argument("splat_start: " + what);
}

StartPoints from_colmap(const std::vector<ColmapStartPoint>& points) {
  StartPoints result;
  for (const ColmapStartPoint& point : points)
    result.points.push_back({.position_m = point.position, .color = point.color});
  return result;
}

/// Column of each of x y z red green blue, or -1.
std::array<int, 6> columns_of(const geometry::PlyElementHeader& element, const std::string& name) {
  constexpr std::array<const char*, 6> kNames = {"x", "y", "z", "red", "green", "blue"};
  std::array<int, 6> columns{-1, -1, -1, -1, -1, -1};
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      if (!element.properties[i].is_list && element.properties[i].name == kNames[k])
        columns[k] = static_cast<int>(i);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (columns[k] < 0)
      throw std::runtime_error(name + ": header: vertices have no property \"" + kNames[k] + "\"");
  }
  return columns;
}

StartPoints from_ply(const std::string& bytes, const std::string& name, std::size_t most_points) {
  const geometry::PlyHeader header = geometry::parse_ply_header(bytes, name);
  geometry::PlyBody body(bytes, header.body, header.encoding, name);
  for (const geometry::PlyElementHeader& element : header.elements) {
    if (element.name != "vertex") {
      geometry::skip_rows(element, body);
      continue;
    }
    const std::array<int, 6> columns = columns_of(element, name);
    if (element.count > most_points) {
      throw std::runtime_error(name + ": there are " + std::to_string(element.count) +
                               " points; the limit is " + std::to_string(most_points));
    }
    body.require_rows(element);
    const bool colored = columns[3] >= 0 && columns[4] >= 0 && columns[5] >= 0;
    StartPoints result;
    std::vector<double> row(element.properties.size());
    for (std::size_t i = 0; i < element.count; ++i) {
      for (std::size_t k = 0; k < row.size(); ++k) {
        const geometry::PlyProperty& property = element.properties[k];
        const std::size_t items = property.is_list ? body.list_length(property) : 1;
        for (std::size_t item = 0; item < items; ++item) row[k] = body.number(property.type);
      }
      const auto value = [&](int k) {
        return row[static_cast<std::size_t>(columns[static_cast<std::size_t>(k)])];
      };
      const auto code = [&](int k) {
        const auto column = static_cast<std::size_t>(columns[static_cast<std::size_t>(k)]);
        const geometry::PlyType type = element.properties[column].type;
        const bool of_one = type == geometry::PlyType::f32 || type == geometry::PlyType::f64;
        const double v = row[column] * (of_one ? 255 : 1);
        if (!(v >= 0 && v <= 255)) {
          throw std::runtime_error(name + ": vertex " + std::to_string(i) + ": " +
                                   element.properties[column].name + " = " +
                                   std::to_string(row[column]) + " is not a colour");
        }
        return static_cast<std::uint8_t>(std::lround(v));
      };
      StartPoint point;
      point.position_m = {value(0), value(1), value(2)};
      if (!point.position_m.allFinite()) {
        ++result.not_finite;
        continue;
      }
      if (colored) point.color = {code(3), code(4), code(5)};
      result.points.push_back(point);
    }
    return result;
  }
  throw std::runtime_error(name + ": header: there is no element \"vertex\"");
}

/// Root mean square distance of the three nearest other points, of each; NaN where there is none.
std::vector<double> neighbour_scales(const std::vector<Eigen::Vector3d>& points_m) {
  const NearPoints near(points_m);
  std::vector<double> scales(points_m.size());
  tbb::parallel_for(std::size_t{0}, points_m.size(), [&](std::size_t i) {
    const std::vector<double> nearest = near.squared_distances_m2(i, 3);
    double sum = 0;
    for (const double distance2 : nearest) sum += distance2;
    scales[i] = std::sqrt(sum / static_cast<double>(nearest.size()));
  });
  return scales;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Zero, or the median where floats of the coordinates themselves would be too coarse for the
/// half of the points nearest to it: a few far off decide nothing.
Eigen::Vector3d origin_of(const std::vector<Eigen::Vector3d>& points_m) {
  if (points_m.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d middle;
  double spread = 0;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(points_m.size());
    for (const Eigen::Vector3d& p : points_m) values.push_back(p[k]);
    middle[k] = median(values);
    for (double& value : values) value = std::abs(value - middle[k]);
    spread = std::max(spread, median(values));
  }
  return middle.cwiseAbs().maxCoeff() > kFarOff * spread ? middle : Eigen::Vector3d::Zero();
}

/// Turns a round Gaussian's third axis along a normal and makes it thinner there.
void lay_flat(const Eigen::Vector3d& normal, double flatness, Splat& splat) {
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
  splat.rotation_wxyz = Eigen::Vector4d(turn.w(), turn.x(), turn.y(), turn.z()).cast<float>();
  splat.log_scale.z() += static_cast<float>(std::log(flatness));
}

}  // namespace

StartPoints read_start_points(const fs::path& file, std::size_t most_points) {
  const std::string name = file.string();
  const std::string ending = file.extension().string();
  StartPoints result;
  if (ending == ".ply") {
    result = from_ply(read_file(file, kMostStartBytes), name, most_points);
  } else if (ending == ".txt") {
    result = from_colmap(colmap_points_from_text(read_file(file, kMostStartBytes), name));
  } else if (ending == ".bin") {
    result = from_colmap(colmap_points_from_binary(read_file(file, kMostStartBytes), name));
  } else {
    throw std::runtime_error(name + ": points are .ply, points3D.txt or points3D.bin, not \"" +
                             ending + "\"");
  }
  if (result.points.size() > most_points) {
    throw std::runtime_error(name + ": there are " + std::to_string(result.points.size()) +
                             " points; the limit is " + std::to_string(most_points));
  }
  return result;
}

std::vector<StartPoint> random_start_points(const Eigen::Vector3d& low_m,
                                            const Eigen::Vector3d& high_m, int count, Rng rng) {
  if (!low_m.allFinite() || !high_m.allFinite() || !(high_m.array() > low_m.array()).all())
    fail_config("the box of random points has a side that is not positive and finite");
  if (count < 0) fail_config("count = " + std::to_string(count) + " of random points is negative");
  std::vector<StartPoint> points(static_cast<std::size_t>(count));
  for (StartPoint& point : points) {
    for (int k = 0; k < 3; ++k) point.position_m[k] = uniform(rng, low_m[k], high_m[k]);
  }
  return points;
}

void validate(const SplatStartConfig& config) {
  if (config.sh_degree < 0 || config.sh_degree > 3)
    fail_config("sh_degree = " + std::to_string(config.sh_degree) + " is not in 0..3");
  if (!(config.opacity > 0 && config.opacity < 1))
    fail_config("opacity = " + std::to_string(config.opacity) + " is not between 0 and 1");
  if (!(config.flatness > 0 && config.flatness <= 1))
    fail_config("flatness = " + std::to_string(config.flatness) + " is not above 0 and at most 1");
  if (!(config.alone_m > 0) || !std::isfinite(config.alone_m))
    fail_config("alone_m = " + std::to_string(config.alone_m) + " is not a length");
}

SplatModel splats_from_points(std::span<const StartPoint> points, const SplatStartConfig& config) {
  validate(config);
  std::vector<Eigen::Vector3d> positions_m;
  positions_m.reserve(points.size());
  for (const StartPoint& point : points) {
    if (!point.position_m.allFinite())
      fail_config("point " + std::to_string(positions_m.size()) + " is not finite");
    if (!(point.opacity >= 0 && point.opacity < 1))
      fail_config("point " + std::to_string(positions_m.size()) +
                  ": opacity = " + std::to_string(point.opacity) + " is not in 0 .. 1, without 1");
    positions_m.push_back(point.position_m);
  }
  std::vector<double> scales = neighbour_scales(positions_m);
  double least = 0;
  if (points.size() > 1) {
    least = kLeastShare * median(scales);
  }
  SplatModel model;
  model.sh_degree = config.sh_degree;
  model.origin_in_world_m = origin_of(positions_m);
  model.splats.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Splat& splat = model.splats[i];
    splat.centre_m = (positions_m[i] - model.origin_in_world_m).cast<float>();
    const double scale = std::max(scales[i], least);
    splat.log_scale.setConstant(static_cast<float>(std::log(scale > 0 ? scale : config.alone_m)));
    if (points[i].normal.squaredNorm() > 0.5) lay_flat(points[i].normal, config.flatness, splat);
    const double opacity = points[i].opacity > 0 ? points[i].opacity : config.opacity;
    splat.opacity_logit = static_cast<float>(std::log(opacity / (1 - opacity)));
    const std::array<std::uint8_t, 3> codes = {points[i].color.r, points[i].color.g,
                                               points[i].color.b};
    for (std::size_t c = 0; c < 3; ++c)
      splat.sh_dc[c] = static_cast<float>((codes[c] / 255.0 - 0.5) / kFirstHarmonic);
  }
  return model;
}

}  // namespace cousin
