#include "perception/fruit/fruit_seam.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace cousin {
namespace {

struct NumberName {
  const char* name;
  const char* unit;
};
constexpr int kRotation = kFruitNumbers, kSizes = kFruitNumbers + 3, kSeamNumbers = kSizes + 3;

std::array<FitParameter, kSeamNumbers> seam_parameters() {
  std::array<FitParameter, kSeamNumbers> all;
  const NumberName first[] = {{"centre_x", "m"},    {"centre_y", "m"},   {"centre_z", "m"},
                              {"turn_x", "rad"},    {"turn_y", "rad"},   {"log_radius", "1"},
                              {"log_stretch", "1"}, {"conic", "1"},      {"lopsided_x", "1"},
                              {"lopsided_y", "1"},  {"stalk_dent", "1"}, {"calyx_dent", "1"}};
  for (std::size_t k = 0; k < std::size(first); ++k) all[k] = {first[k].name, first[k].unit, kNaN};
  for (int k = 0; k < kWaveCount; ++k)
    all[static_cast<std::size_t>(kWaves + k)] = {"wave_" + std::to_string(k), "1", kNaN};
  const NumberName last[] = {{"rotation_x", "rad"}, {"rotation_y", "rad"}, {"rotation_z", "rad"},
                             {"volume", "m3"},      {"diameter", "m"},     {"length", "m"}};
  for (std::size_t k = 0; k < std::size(last); ++k)
    all[kRotation + k] = {last[k].name, last[k].unit, kNaN};
  return all;
}

/// Place of a parameter; -1 if the fit has none of this name.
int place_of(const ObjectFit& fit, std::string_view name) {
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    if (fit.parameters[k].name == name) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace

ObjectFit seam_of(const FruitFit& fit, int instance, const std::string& model) {
  ObjectFit seam;
  seam.instance = instance;
  seam.model = model;
  seam.status = fit.status;
  seam.reason = fit.reason;
  const auto parameters = seam_parameters();
  seam.parameters.assign(parameters.begin(), parameters.end());
  for (int k = 0; k < kFruitNumbers; ++k)
    seam.parameters[static_cast<std::size_t>(k)].value = fit.shape.numbers[k];
  const Eigen::AngleAxisd turn(fit.shape.camera_from_fruit);
  for (int k = 0; k < 3; ++k)
    seam.parameters[static_cast<std::size_t>(kRotation + k)].value = turn.angle() * turn.axis()[k];
  const FruitMeasure sizes[] = {fit.volume_m3, fit.diameter_m, fit.length_m};
  bool is_sure = true;
  for (std::size_t k = 0; k < std::size(sizes); ++k) {
    seam.parameters[kSizes + k].value = sizes[k].value;
    is_sure = is_sure && std::isfinite(sizes[k].sigma);
  }
  if (!is_sure) return seam;
  seam.covariance = Eigen::MatrixXd::Zero(kSeamNumbers, kSeamNumbers);
  seam.covariance.topLeftCorner(kFruitNumbers, kFruitNumbers) =
      0.5 * (fit.covariance + fit.covariance.transpose());
  for (std::size_t k = 0; k < std::size(sizes); ++k) {
    const auto at = static_cast<Eigen::Index>(kSizes + k);
    seam.covariance(at, at) = sizes[k].sigma * sizes[k].sigma;
  }
  return seam;
}

FruitMeasure parameter_of(const ObjectFit& fit, std::string_view name) {
  const int place = place_of(fit, name);
  if (place < 0) return {};
  return {fit.parameters[static_cast<std::size_t>(place)].value,
          fit.covariance.size() > 0 ? std::sqrt(fit.covariance(place, place)) : kNaN};
}

FruitShape shape_of(const ObjectFit& fit) {
  FruitShape shape;
  const auto parameters = seam_parameters();
  for (int k = 0; k < kFruitNumbers; ++k)
    shape.numbers[k] = parameter_of(fit, parameters[static_cast<std::size_t>(k)].name).value;
  const Eigen::Vector3d turn(parameter_of(fit, "rotation_x").value,
                             parameter_of(fit, "rotation_y").value,
                             parameter_of(fit, "rotation_z").value);
  if (turn.norm() > 0)
    shape.camera_from_fruit = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return shape;
}

FruitCovariance covariance_of(const ObjectFit& fit) {
  const auto parameters = seam_parameters();
  FruitCovariance covariance = FruitCovariance::Constant(kNaN);
  if (fit.covariance.size() == 0) return covariance;
  std::array<int, kFruitNumbers> places;
  for (std::size_t k = 0; k < places.size(); ++k) places[k] = place_of(fit, parameters[k].name);
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (places[i] >= 0 && places[k] >= 0)
        covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
            fit.covariance(places[i], places[k]);
    }
  }
  return covariance;
}

}  // namespace cousin
