#include "perception/fruit/fruit_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Real spherical harmonics of unit mean square as polynomials of a unit vector, with gradients of
/// these polynomials. Those of degree 1 move the centre; of degree 2 the stretch along the axis and
/// turns are numbers of their own.
struct Wave {
  double value;
  Vector3d gradient;
};
using WaveValues = std::array<Wave, kWaveCount>;

/// Places of the waves that are the same all about the axis.
constexpr int kZonal3 = 2, kZonal4 = 9;
struct ZonalWaves {
  Wave third, fourth;
};
ZonalWaves zonal_waves(double z) {
  const double f = std::sqrt(7.0) / 2, z2 = z * z;
  return {{f * z * (5 * z2 - 3), f * Vector3d(0, 0, 15 * z2 - 3)},
          {0.375 * (35 * z2 * z2 - 30 * z2 + 3), 0.375 * Vector3d(0, 0, 140 * z2 * z - 60 * z)}};
}

void add_low_waves(const Vector3d& d, WaveValues& w) {
  const double x = d.x(), y = d.y(), z = d.z();
  const double a = std::sqrt(15.0), b = std::sqrt(42.0) / 4, c = std::sqrt(105.0),
               e = std::sqrt(70.0) / 4;
  w[0] = {a * x * y, a * Vector3d(y, x, 0)};
  w[1] = {a / 2 * (x * x - y * y), a * Vector3d(x, -y, 0)};
  const double u = 5 * z * z - 1;
  w[kZonal3] = zonal_waves(z).third;
  w[3] = {b * x * u, b * Vector3d(u, 0, 10 * x * z)};
  w[4] = {b * y * u, b * Vector3d(0, u, 10 * y * z)};
  w[5] = {c / 2 * z * (x * x - y * y), c / 2 * Vector3d(2 * x * z, -2 * y * z, x * x - y * y)};
  w[6] = {c * x * y * z, c * Vector3d(y * z, x * z, x * y)};
  w[7] = {e * x * (x * x - 3 * y * y), e * Vector3d(3 * (x * x - y * y), -6 * x * y, 0)};
  w[8] = {e * y * (3 * x * x - y * y), e * Vector3d(6 * x * y, 3 * (x * x - y * y), 0)};
}

void add_fourth_waves(const Vector3d& d, WaveValues& w) {
  const double x = d.x(), y = d.y(), z = d.z();
  const double x2 = x * x, y2 = y * y, z2 = z * z;
  const double a = 3 * std::sqrt(10.0) / 4, b = 3 * std::sqrt(5.0) / 4, c = 3 * std::sqrt(70.0) / 4,
               e = 3 * std::sqrt(35.0) / 8;
  w[kZonal4] = zonal_waves(z).fourth;
  const double u = z * (7 * z2 - 3), v = 7 * z2 - 1;
  w[10] = {a * x * u, a * Vector3d(u, 0, x * (21 * z2 - 3))};
  w[11] = {a * y * u, a * Vector3d(0, u, y * (21 * z2 - 3))};
  w[12] = {b * (x2 - y2) * v, b * Vector3d(2 * x * v, -2 * y * v, 14 * z * (x2 - y2))};
  w[13] = {2 * b * x * y * v, 2 * b * Vector3d(y * v, x * v, 14 * x * y * z)};
  w[14] = {c * x * z * (x2 - 3 * y2),
           c * Vector3d(3 * z * (x2 - y2), -6 * x * y * z, x * (x2 - 3 * y2))};
  w[15] = {c * y * z * (3 * x2 - y2),
           c * Vector3d(6 * x * y * z, 3 * z * (x2 - y2), y * (3 * x2 - y2))};
  w[16] = {e * (x2 * x2 - 6 * x2 * y2 + y2 * y2),
           e * Vector3d(4 * x * (x2 - 3 * y2), 4 * y * (y2 - 3 * x2), 0)};
  w[17] = {4 * e * x * y * (x2 - y2), 4 * e * Vector3d(y * (3 * x2 - y2), x * (x2 - 3 * y2), 0)};
}

/// A dent about a pole: its depth, and that by the cosine of the angle from the pole.
struct Dent {
  double value, by_cosine;
};
Dent dent(double cosine, double width_rad) {
  const double c = std::clamp(cosine, -1.0, 1.0);
  const double angle = std::acos(c);
  if (angle > 5 * width_rad) return {0, 0};
  const double value = std::exp(-angle * angle / (width_rad * width_rad));
  const double over_sine = angle < 1e-4 ? 1 : angle / std::sqrt(std::max(1e-12, 1 - c * c));
  return {value, 2 * value * over_sine / (width_rad * width_rad)};
}

/// The radius in a direction, its gradient, and how it changes with each number.
struct Radius {
  double value = 1;
  Vector3d gradient = Vector3d::Zero();
  FruitParameters derivative = FruitParameters::Zero();
};
Radius radius_in(const FruitShape& shape, const Vector3d& d, bool waves) {
  const FruitParameters& n = shape.numbers;
  const Dent top = dent(d.z(), shape.stalk_dent_rad), low = dent(-d.z(), shape.calyx_dent_rad);
  const double base = 1 + n[kConic] * d.z() + n[kLopsidedX] * d.x() + n[kLopsidedY] * d.y();
  const double with_top = 1 - n[kStalkDent] * top.value, with_low = 1 - n[kCalyxDent] * low.value;
  const double dents = with_top * with_low;
  Radius r;
  r.value = base * dents;
  r.gradient = dents * Vector3d(n[kLopsidedX], n[kLopsidedY], n[kConic]);
  r.gradient.z() +=
      base * (n[kCalyxDent] * low.by_cosine * with_top - n[kStalkDent] * top.by_cosine * with_low);
  r.derivative[kConic] = d.z() * dents;
  r.derivative[kLopsidedX] = d.x() * dents;
  r.derivative[kLopsidedY] = d.y() * dents;
  r.derivative[kStalkDent] = -base * top.value * with_low;
  r.derivative[kCalyxDent] = -base * low.value * with_top;
  if (!waves) {
    const ZonalWaves zonal = zonal_waves(d.z());
    r.value += n[kWaves + kZonal3] * zonal.third.value + n[kWaves + kZonal4] * zonal.fourth.value;
    r.gradient +=
        n[kWaves + kZonal3] * zonal.third.gradient + n[kWaves + kZonal4] * zonal.fourth.gradient;
    return r;
  }
  WaveValues w;
  add_low_waves(d, w);
  add_fourth_waves(d, w);
  for (int k = 0; k < kWaveCount; ++k) {
    const Wave& wave = w[static_cast<std::size_t>(k)];
    r.value += n[kWaves + k] * wave.value;
    r.gradient += n[kWaves + k] * wave.gradient;
    r.derivative[kWaves + k] = wave.value;
  }
  return r;
}

Vector3d direction(double from_stalk_rad, double about_rad) {
  const double s = std::sin(from_stalk_rad);
  return {s * std::cos(about_rad), s * std::sin(about_rad), std::cos(from_stalk_rad)};
}

/// A point of the surface in the fruit's own frame, and how far it moves along `way` with each
/// number.
double extent_by(const FruitShape& shape, const Vector3d& d, const Vector3d& way,
                 FruitParameters& derivative) {
  const Radius r = radius_in(shape, d, true);
  const Vector3d unit(d.x(), d.y(), d.z() * shape.stretch());
  const double along = shape.radius_m() * unit.dot(way);
  derivative += along * r.derivative;
  derivative[kLogRadius] += along * r.value;
  derivative[kLogStretch] += shape.radius_m() * r.value * d.z() * shape.stretch() * way.z();
  return along * r.value;
}

/// Extent of sampled points along a unit vector.
FruitNumber extent(const FruitShape& shape, const std::vector<Vector3d>& directions,
                   const std::vector<Vector3d>& points_m, const Vector3d& way) {
  std::size_t most = 0, least = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (points_m[i].dot(way) > points_m[most].dot(way)) most = i;
    if (points_m[i].dot(way) < points_m[least].dot(way)) least = i;
  }
  FruitNumber number;
  number.value = extent_by(shape, directions[most], way, number.derivative) +
                 extent_by(shape, directions[least], -way, number.derivative);
  return number;
}

}  // namespace

Fields fields(FruitPrior& p) {
  return {{"diameter_m", &p.diameter_m, "mean extent across the axis", 0.005, 0.5},
          {"sigma_diameter", &p.sigma_diameter, "its sigma over the mean", 0.001, 2},
          {"shape_index", &p.shape_index, "length along the axis over diameter", 0.4, 2.5},
          {"sigma_shape_index", &p.sigma_shape_index, "its sigma", 0.001, 1},
          {"conic", &p.conic, "wider to the stalk, over the radius", -0.5, 0.5},
          {"sigma_conic", &p.sigma_conic, "its sigma", 1e-5, 1},
          {"zonal_3", &p.zonal_3, "zonal wave of degree 3, over the radius", -0.3, 0.3},
          {"zonal_4", &p.zonal_4, "and of degree 4", -0.3, 0.3},
          {"sigma_lopsided", &p.sigma_lopsided, "sigma of one side's excess", 1e-5, 1},
          {"stalk_dent", &p.stalk_dent, "depth over the radius", 0, 0.7},
          {"stalk_dent_rad", &p.stalk_dent_rad, "where it is e times shallower", 0.05, 1},
          {"calyx_dent", &p.calyx_dent, "depth over the radius", 0, 0.7},
          {"calyx_dent_rad", &p.calyx_dent_rad, "where it is e times shallower", 0.05, 1},
          {"sigma_dents", &p.sigma_dents, "sigma of both depths over their means", 1e-4, 1},
          {"sigma_waves_2", &p.sigma_waves_2, "of each wave of degree 2 over the radius", 1e-5, 1},
          {"sigma_waves_3", &p.sigma_waves_3, "of each wave of degree 3", 1e-5, 1},
          {"sigma_waves_4", &p.sigma_waves_4, "of each wave of degree 4", 1e-5, 1},
          {"solid_share", &p.solid_share, "volume over that of the smooth shape of its outline",
           0.5, 1.5},
          {"density_kg_m3", &p.density_kg_m3, "mass over volume", 100, 3000},
          {"sigma_density_kg_m3", &p.sigma_density_kg_m3, "its sigma; 0: known", 0, 1000}};
}

void validate(const FruitPrior& prior) {
  FruitPrior copy = prior;
  check_limits(fields(copy), "prior");
}

double FruitShape::radius_m() const { return std::exp(numbers[kLogRadius]); }
double FruitShape::stretch() const { return std::exp(numbers[kLogStretch]); }

FruitShape mean_shape(const FruitPrior& prior) {
  FruitShape shape;
  shape.stalk_dent_rad = prior.stalk_dent_rad;
  shape.calyx_dent_rad = prior.calyx_dent_rad;
  shape.numbers[kConic] = prior.conic;
  shape.numbers[kStalkDent] = prior.stalk_dent;
  shape.numbers[kCalyxDent] = prior.calyx_dent;
  shape.numbers[kWaves + kZonal3] = prior.zonal_3;
  shape.numbers[kWaves + kZonal4] = prior.zonal_4;
  shape.numbers[kLogRadius] = std::log(prior.diameter_m / 2);
  // Dents and the cone change both extents: to the asked ones in two steps.
  for (int step = 0; step < 2; ++step) {
    const FruitNumbers now = numbers_of(shape);
    shape.numbers[kLogRadius] += std::log(prior.diameter_m / now.diameter_m.value);
    shape.numbers[kLogStretch] +=
        std::log(prior.shape_index * now.diameter_m.value / now.length_m.value);
  }
  return shape;
}

FruitParameters prior_sigmas(const FruitPrior& prior) {
  FruitParameters sigmas = FruitParameters::Constant(std::numeric_limits<double>::infinity());
  sigmas[kLogRadius] = prior.sigma_diameter;
  sigmas[kLogStretch] = prior.sigma_shape_index / prior.shape_index;
  sigmas[kConic] = prior.sigma_conic;
  sigmas[kLopsidedX] = sigmas[kLopsidedY] = prior.sigma_lopsided;
  sigmas[kStalkDent] = std::max(1e-4, prior.sigma_dents * prior.stalk_dent);
  sigmas[kCalyxDent] = std::max(1e-4, prior.sigma_dents * prior.calyx_dent);
  sigmas.segment<2>(kWaves).setConstant(prior.sigma_waves_2);
  sigmas.segment<7>(kWaves + 2).setConstant(prior.sigma_waves_3);
  sigmas.segment<9>(kWaves + 9).setConstant(prior.sigma_waves_4);
  return sigmas;
}

FruitKind kind_of(const FruitPrior& prior) {
  return {prior, mean_shape(prior), prior_sigmas(prior)};
}

FruitPrior strawberry_prior() {
  FruitPrior prior;
  // Ripe fruits of 18 to 22 g and 930 to 950 kg/m3 are 31 to 36 mm across; green ones half of that.
  prior.diameter_m = 0.030;
  prior.sigma_diameter = 0.22;
  prior.shape_index = 1.30;
  prior.sigma_shape_index = 0.16;
  // Least squares of the outlines of scenes/strawberries/varieties.toml: cone .12 to .16, degree 3
  // -.069 to -.083, degree 4 -.009 to -.017; 0.2 mm of 45 are left. Sigmas are free, and wider.
  prior.conic = 0.14;
  prior.sigma_conic = 0.05;
  prior.zonal_3 = -0.075;
  prior.zonal_4 = -0.013;
  prior.sigma_lopsided = 0.05;
  prior.stalk_dent = prior.calyx_dent = 0;
  prior.solid_share = 0.95;  // fitted to seeds 101 to 103 of the scene
  prior.sigma_waves_2 = 0.022;
  prior.sigma_waves_3 = 0.016;
  prior.sigma_waves_4 = 0.010;
  prior.density_kg_m3 = 940;
  prior.sigma_density_kg_m3 = 20;
  return prior;
}

FruitDistance distance_to(const FruitShape& shape, const Vector3d& point_m, bool waves) {
  const double radius_m = shape.radius_m(), stretch = shape.stretch();
  const Vector3d x_m = shape.camera_from_fruit.transpose() * (point_m - shape.centre_m());
  const Vector3d y = Vector3d(x_m.x(), x_m.y(), x_m.z() / stretch) / radius_m;
  const double norm = std::max(1e-9, y.norm());
  const Vector3d d = y / norm;
  const Radius r = radius_in(shape, d, waves);
  const Vector3d by_y = d - (r.gradient - d * d.dot(r.gradient)) / norm;
  const Vector3d by_x = Vector3d(by_y.x(), by_y.y(), by_y.z() / stretch) / radius_m;
  const double slope = by_x.norm();
  FruitDistance result;
  result.distance_m = (norm - r.value) / slope;
  result.normal = shape.camera_from_fruit * by_x / slope;
  result.derivative = -r.derivative;
  result.derivative.head<3>() = -(shape.camera_from_fruit * by_x);
  const Vector3d turn = -x_m.cross(by_x);
  result.derivative[kTurnX] = turn.x();
  result.derivative[kTurnY] = turn.y();
  result.derivative[kLogRadius] = -norm;
  result.derivative[kLogStretch] = -by_y.z() * y.z();
  result.derivative /= slope;
  return result;
}

FruitShape changed(const FruitShape& shape, const FruitParameters& by) {
  FruitShape result = shape;
  const Vector3d turn(by[kTurnX], by[kTurnY], 0);
  const double angle = turn.norm();
  if (angle > 0)
    result.camera_from_fruit =
        shape.camera_from_fruit * Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  result.numbers += by;
  result.numbers[kTurnX] = result.numbers[kTurnY] = 0;
  return result;
}

FruitNumbers numbers_of(const FruitShape& shape, int rows) {
  const int widths = rows / 2;  // columns stand where widths are taken
  constexpr double kPi = std::numbers::pi;
  std::vector<Vector3d> directions, points_m;
  FruitNumbers result;
  const double scale = std::pow(shape.radius_m(), 3) * shape.stretch();
  for (int i = 0; i < rows; ++i) {
    const double angle = (i + 0.5) * kPi / rows;
    for (int k = 0; k < rows; ++k) {
      const Vector3d d = direction(angle, 2 * kPi * k / rows);
      const Radius r = radius_in(shape, d, true);
      const double part = std::sin(angle) * (kPi / rows) * (2 * kPi / rows) * scale;
      result.volume_m3.value += part * std::pow(r.value, 3) / 3;
      result.volume_m3.derivative += part * r.value * r.value * r.derivative;
      directions.push_back(d);
      points_m.push_back(shape.radius_m() * r.value *
                         Vector3d(d.x(), d.y(), d.z() * shape.stretch()));
    }
  }
  result.volume_m3.derivative[kLogRadius] = 3 * result.volume_m3.value;
  result.volume_m3.derivative[kLogStretch] = result.volume_m3.value;
  for (int k = 0; k < widths; ++k) {
    const FruitNumber one =
        extent(shape, directions, points_m, direction(kPi / 2, kPi * k / widths));
    result.diameter_m.value += one.value / widths;
    result.diameter_m.derivative += one.derivative / widths;
  }
  result.length_m = extent(shape, directions, points_m, Vector3d::UnitZ());
  return result;
}

FruitVector centroid_in_fruit(const FruitShape& shape, int rows) {
  constexpr double kPi = std::numbers::pi;
  FruitVector moment;
  FruitNumber volume;
  for (int i = 0; i < rows; ++i) {
    const double angle = (i + 0.5) * kPi / rows;
    for (int k = 0; k < rows; ++k) {
      const Vector3d d = direction(angle, 2 * kPi * k / rows);
      const Radius r = radius_in(shape, d, true);
      const double part = std::sin(angle) * r.value * r.value;
      const Vector3d way = shape.radius_m() * Vector3d(d.x(), d.y(), d.z() * shape.stretch());
      volume.value += part * r.value / 3;
      volume.derivative += part * r.derivative;
      moment.value_m += part * r.value * r.value / 4 * way;
      moment.derivative += part * r.value * way * r.derivative.transpose();
    }
  }
  FruitVector centre;
  centre.value_m = moment.value_m / volume.value;
  centre.derivative =
      (moment.derivative - centre.value_m * volume.derivative.transpose()) / volume.value;
  centre.derivative.col(kLogRadius) += centre.value_m;
  centre.derivative(2, kLogStretch) += centre.value_m.z();
  return centre;
}

FruitNumber pole_m(const FruitShape& shape) {
  FruitNumber pole;
  pole.value = extent_by(shape, Vector3d::UnitZ(), Vector3d::UnitZ(), pole.derivative);
  return pole;
}

Vector3d normal_on_ray(const FruitShape& shape, const Vector3d& ray) {
  // Where the ray meets the stretched sphere, in the space where that is round.
  const Eigen::Matrix3d to_fruit = shape.camera_from_fruit.transpose();
  const Vector3d squash(1, 1, 1 / shape.stretch());
  const Vector3d from = squash.cwiseProduct(to_fruit * -shape.centre_m());
  const Vector3d way = squash.cwiseProduct(to_fruit * ray);
  const double nearest_m = -from.dot(way) / way.squaredNorm();
  const double off_2 = shape.radius_m() * shape.radius_m() - (from + nearest_m * way).squaredNorm();
  if (!(off_2 > 0)) return -ray;
  const double t_m = nearest_m - std::sqrt(off_2 / way.squaredNorm());
  return distance_to(shape, t_m * ray, false).normal;
}

std::vector<Vector3d> points_of(const FruitShape& shape, int rows, int columns) {
  std::vector<Vector3d> points_m;
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < columns; ++k) {
      const Vector3d d =
          direction((i + 0.5) * std::numbers::pi / rows, 2 * std::numbers::pi * k / columns);
      const double r = shape.radius_m() * radius_in(shape, d, true).value;
      points_m.push_back(shape.centre_m() +
                         shape.camera_from_fruit *
                             (r * Vector3d(d.x(), d.y(), d.z() * shape.stretch())));
    }
  }
  return points_m;
}

}  // namespace cousin
