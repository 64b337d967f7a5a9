#include "scenes/seeds/cultivar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "scenes/seeds/toml_text.h"

namespace cousin {
namespace {

constexpr std::array<const char*, 6> kNames = {"zhengdan958", "tianguinuo932", "jimai22",
                                               "aikang58",    "suijing18",     "xiangyaxiangzhan"};

// A standard normal cut at +-2 keeps this share of its standard deviation: sqrt(1 - 2 * 2 phi(2) /
// (2 Phi(2) - 1)).
constexpr double kCut = 2.0;
constexpr double kCutSigma = 0.87963;

Species species_from_string(const std::string& text) {
  if (text == "maize") return Species::maize;
  if (text == "wheat") return Species::wheat;
  if (text == "rice") return Species::rice;
  throw std::invalid_argument("species \"" + text + "\" is not one of maize, wheat, rice");
}

std::string species_name(Species species) {
  return species == Species::maize ? "maize" : species == Species::wheat ? "wheat" : "rice";
}

void require_count(const char* key, const std::vector<double>& values, std::size_t count) {
  if (values.size() != count) {
    throw std::invalid_argument(std::string(key) + " has " + std::to_string(values.size()) +
                                " numbers; it needs " + std::to_string(count));
  }
}

std::vector<CultivarConfig> read_cultivars() {
  std::vector<CultivarConfig> cultivars(kNames.size());
  Fields all;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    all = all + nested(kNames[i], fields(cultivars[i]));
  read_toml_text(cultivars_toml(), "scenes/seeds/cultivars.toml", all, MissingKeys::error);
  for (const CultivarConfig& config : cultivars) validate(config);
  return cultivars;
}

}  // namespace

Fields fields(CultivarConfig& c) {
  const TextField species{[&c] { return species_name(c.species); },
                          [&c](const std::string& text) { c.species = species_from_string(text); }};
  return {
      {"species", species, "maize, wheat or rice: which details are modelled"},
      {"length_m", &c.length_m, "mean", 1e-3, 0.1},
      {"width_m", &c.width_m, "mean", 1e-3, 0.1},
      {"height_m", &c.height_m, "mean", 1e-3, 0.1},
      {"cv_length", &c.cv_length, "standard deviation over mean", 0, 0.3},
      {"cv_width", &c.cv_width, "standard deviation over mean", 0, 0.3},
      {"cv_height", &c.cv_height, "standard deviation over mean", 0, 0.3},
      {"size_share", &c.size_share, "share of the variances that a common size factor explains", 0,
       1},
      {"paper_rmse_m", &c.paper_rmse_m, "RMSE of length, width, height in the paper", 0, 0.01},
      {"paper_r2", &c.paper_r2, "R^2 of length, width, height in the paper", 0, 1},
      {"density_kg_m3", &c.density_kg_m3, "mass over volume", 100, 3000},
      {"profile_width", &c.profile_width, "half-width from tip to crown, 1 = maximum", 0.05, 1},
      {"profile_height", &c.profile_height, "half-height from tip to crown, 1 = maximum", 0.05, 1},
      {"tip_round", &c.tip_round, "share of the length over which the tip closes", 0.01, 0.5},
      {"tip_exponent", &c.tip_exponent, "2 = elliptic, less = pointed, more = blunt", 1.1, 8},
      {"crown_round", &c.crown_round, "share of the length over which the crown closes", 0.01, 0.5},
      {"crown_exponent", &c.crown_exponent, "2 = elliptic, less = pointed, more = blunt", 1.1, 8},
      {"section_exponent", &c.section_exponent, "superellipse of the cross-section", 1.5, 8},
      {"bend_m", &c.bend_m, "bow of the long axis", 0, 0.01},
      {"lump_m", &c.lump_m, "amplitude of individual lopsidedness", 0, 0.001},
      {"relief_m", &c.relief_m, "maize: dent; wheat: rim of the embryo; rice: nerves", 0, 0.002},
      {"groove_m", &c.groove_m, "maize: hollow over the embryo; wheat: crease; rice: seam", 0,
       0.002},
      {"wrinkle_m", &c.wrinkle_m, "fine relief", 0, 0.0005},
      {"neck_m", &c.neck_m, "maize: depth of the tip cap's neck; rice: edge of sterile lemmas", 0,
       0.001},
      {"back_narrower", &c.back_narrower, "wheat: than the belly, share of the half width", 0, 0.5},
      {"beak_m", &c.beak_m, "rice: apiculus along and aside, pedicel along", 0, 0.002},
      {"relief_spread", &c.relief_spread, "sigma of relief_m over its mean", 0, 0.5},
      {"groove_spread", &c.groove_spread, "sigma of groove_m over its mean", 0, 0.5},
      {"slant", &c.slant, "sigma of the lean of the crown, dx/dy", 0, 0.5},
      {"skew", &c.skew, "sigma of the middle's shift sideways over the half width", 0, 0.5},
      {"taper", &c.taper, "sigma of the height's change from side to side", 0, 0.5},
      {"albedo_body", &c.albedo_body, "linear reflectance", 0, 1},
      {"albedo_pale", &c.albedo_pale, "linear reflectance", 0, 1},
      {"albedo_dark", &c.albedo_dark, "linear reflectance", 0, 1},
      {"albedo_tip", &c.albedo_tip, "linear reflectance", 0, 1},
      {"mottle", &c.mottle, "relative contrast of the mottling", 0, 0.5},
      {"mottle_scale_m", &c.mottle_scale_m, "its coarsest scale", 1e-4, 0.01},
      {"roughness", &c.roughness, "of the coat", 0.05, 1},
      {"ior", &c.ior, "of the coat", 1, 2.5},
      {"grid", &c.grid, "cells along an edge of the mesh's cube", 4, 200},
  };
}

void validate(const CultivarConfig& c) {
  require_count("paper_rmse_m", c.paper_rmse_m, 3);
  require_count("paper_r2", c.paper_r2, 3);
  require_count("beak_m", c.beak_m, 3);
  for (const double r2 : c.paper_r2) {
    if (!(r2 < 1)) throw std::invalid_argument("paper_r2 must be below 1");
  }
  if (c.profile_width.size() < 4 || c.profile_width.size() != c.profile_height.size()) {
    throw std::invalid_argument(
        "profile_width and profile_height need the same number of knots, at least 4");
  }
  for (const auto* albedo : {&c.albedo_body, &c.albedo_pale, &c.albedo_dark, &c.albedo_tip}) {
    require_count("albedo_*", *albedo, 3);
  }
  if (!(c.length_m >= c.width_m && c.width_m >= c.height_m)) {
    throw std::invalid_argument("a cultivar needs length_m >= width_m >= height_m");
  }
}

std::vector<std::string> cultivar_names() { return {kNames.begin(), kNames.end()}; }

const CultivarConfig& cultivar(const std::string& name) {
  static const std::vector<CultivarConfig> cultivars = read_cultivars();
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) {
    std::string known;
    for (const char* n : kNames) known += std::string(known.empty() ? "" : ", ") + n;
    throw std::invalid_argument("cultivar \"" + name + "\" is not one of " + known);
  }
  return cultivars[static_cast<std::size_t>(found - kNames.begin())];
}

Eigen::Vector3d size_sigma_m(const CultivarConfig& c, SizeSpread spread) {
  if (spread == SizeSpread::literature) {
    return {c.cv_length * c.length_m, c.cv_width * c.width_m, c.cv_height * c.height_m};
  }
  // R^2 = 1 - RMSE^2 / variance of the sample.
  Eigen::Vector3d sigma_m;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sigma_m[i] = c.paper_rmse_m[k] / std::sqrt(1 - c.paper_r2[k]);
  }
  return sigma_m;
}

Eigen::Vector3d draw_size_m(const CultivarConfig& c, SizeSpread spread, Rng& rng) {
  const Eigen::Vector3d mean_m(c.length_m, c.width_m, c.height_m);
  const Eigen::Vector3d sigma_m = size_sigma_m(c, spread) / kCutSigma;
  constexpr double kOrder = 1.02;  // a box whose axes differ less could swap them
  for (;;) {
    const double common = normal(rng);
    Eigen::Vector3d deviation;
    for (int i = 0; i < 3; ++i) {
      deviation[i] = std::sqrt(c.size_share) * common + std::sqrt(1 - c.size_share) * normal(rng);
    }
    const Eigen::Vector3d size_m = mean_m + sigma_m.cwiseProduct(deviation);
    if (deviation.cwiseAbs().maxCoeff() > kCut) continue;
    if (size_m[0] >= kOrder * size_m[1] && size_m[1] >= kOrder * size_m[2]) return size_m;
  }
}

}  // namespace cousin
