#include "perception/fruit/fruit_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Weight and cost of a residual in sigmas.
struct Robust {
  double weight, cost;
};
Robust huber(double r) {
  constexpr double kBend = 2;
  const double a = std::abs(r);
  if (a <= kBend) return {1, r * r};
  return {kBend / a, kBend * (2 * a - kBend)};
}
Robust cauchy(double r) {
  constexpr double kBend = 2.5;
  const double q = r * r / (kBend * kBend);
  return {1 / (1 + q), kBend * kBend * std::log1p(q)};
}

/// Normal equations of half the cost; the prior and all residuals.
struct Normal {
  FruitCovariance information = FruitCovariance::Zero();
  FruitParameters gradient = FruitParameters::Zero();
  double cost = 0;
  double prior_cost = 0, depth_cost = 0;      ///< parts of it
  double depth_squares = 0, depth_count = 0;  ///< residuals in sigmas, and how many
  double rim_squares = 0, rim_places = 0;     ///< and of the fruit's own outline
  double edge_cost = 0;    ///< of places before what is farther: the fruit ends there
  double edge_places = 0;  ///< how many

  void add(const FruitParameters& derivative, double residual, double weight, int used) {
    for (int i = 0; i < used; ++i)  // below the diagonal
      information.col(i).segment(i, used - i) +=
          (weight * derivative[i]) * derivative.segment(i, used - i);
    gradient.head(used) += weight * residual * derivative.head(used);
  }
};

/// How much wider the prior of a number is where a fruit is of an odd shape: what is no wave has
/// bounds of its own.
double scale_at(int place, double scale) {
  constexpr double kMost = 4;
  if (place < kConic) return 1;
  return place < kWaves ? std::min(scale, kMost) : scale;
}

/// One search for a fruit.
class Search {
 public:
  Search(const FruitSurface& surface, const FruitKind& kind, const FruitFitConfig& config)
      : surface_(surface), config_(config), mean_(kind.mean), sigmas_(kind.sigmas) {
    point_share_ =
        std::min(1.0, surface.independent_points /
                          static_cast<double>(std::max<std::size_t>(1, surface.points.size())));
  }

  const FruitShape& mean() const { return mean_; }
  const FruitParameters& sigmas() const { return sigmas_; }

  /// @param stride  of points and places that are taken
  Normal normal_at(const FruitShape& shape, bool waves, double wave_scale,
                   std::size_t stride) const {
    const int used = waves ? kFruitNumbers : kWaves;
    Normal normal;
    add_prior(shape, used, wave_scale, normal);
    const double more = static_cast<double>(stride);
    for (std::size_t i = stride / 2; i < surface_.points.size(); i += stride)
      add_point(shape, surface_.points[i], waves, more * point_share_, used, normal);
    for (std::size_t i = stride / 2; i < surface_.outline.size(); i += stride)
      add_place(shape, surface_.outline[i], waves, more, used, normal);
    normal.cost += normal.prior_cost + normal.depth_cost;
    return normal;
  }

  struct Found {
    FruitShape shape;
    Normal normal;
  };
  /// Levenberg-Marquardt for so many steps.
  Found improved(FruitShape shape, bool waves, double wave_scale, std::size_t stride,
                 int steps) const {
    const int used = waves ? kFruitNumbers : kWaves;
    double damping = 1e-3;
    Normal now = normal_at(shape, waves, wave_scale, stride);
    for (int step = 0; step < steps; ++step) {
      Eigen::MatrixXd damped = now.information.topLeftCorner(used, used);
      damped.diagonal() *= 1 + damping;
      FruitParameters by = FruitParameters::Zero();
      by.head(used) = -damped.selfadjointView<Eigen::Lower>().ldlt().solve(now.gradient.head(used));
      limit(by);
      const FruitShape next = changed(shape, by);
      Normal then = normal_at(next, waves, wave_scale, stride);
      if (!(then.cost <= now.cost)) {
        damping = std::max(10 * damping, 1e-2);
        continue;
      }
      const bool is_done = now.cost - then.cost < 1e-3;
      shape = next;
      now = std::move(then);
      damping *= 0.1;
      if (is_done) break;
    }
    return {shape, std::move(now)};
  }

  /// The start with this axis in the camera.
  FruitShape start(const Vector3d& axis) const {
    FruitShape shape = mean_;
    shape.camera_from_fruit =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix();
    Vector3d middle = Vector3d::Zero();
    for (const SeenPoint& p : surface_.points)
      middle += p.point_m / static_cast<double>(surface_.points.size());
    shape.numbers.head<3>() = middle + 0.7 * shape.radius_m() * middle.normalized();
    return shape;
  }

 private:
  /// No step goes farther than the linear model can be right.
  static void limit(FruitParameters& by) {
    const auto most = [&](int first, int count, double limit) {
      const double norm = by.segment(first, count).norm();
      if (norm > limit) by.segment(first, count) *= limit / norm;
    };
    most(kCentreX, 3, 0.03);
    most(kTurnX, 2, 0.5);
    most(kLogRadius, 1, 0.2);
    most(kLogStretch, 1, 0.1);
  }

  void add_prior(const FruitShape& shape, int used, double wave_scale, Normal& normal) const {
    for (int k = kLogRadius; k < used; ++k) {
      const double sigma = sigmas_[k] * scale_at(k, wave_scale);
      const double off = shape.numbers[k] - mean_.numbers[k];
      normal.information(k, k) += 1 / (sigma * sigma);
      normal.gradient[k] += off / (sigma * sigma);
      normal.prior_cost += off * off / (sigma * sigma);
    }
    // The axis upright in the image, -y.
    const Eigen::Matrix3d& turn = shape.camera_from_fruit;
    for (const auto& [row, sigma] : {std::pair(0, config_.lean_sigma), {2, config_.pitch_sigma}}) {
      FruitParameters derivative = FruitParameters::Zero();
      derivative[kTurnX] = -turn(row, 1);
      derivative[kTurnY] = turn(row, 0);
      normal.add(derivative, turn(row, 2), 1 / (sigma * sigma), used);
      normal.prior_cost += turn(row, 2) * turn(row, 2) / (sigma * sigma);
    }
  }

  void add_point(const FruitShape& shape, const SeenPoint& p, bool waves, double share, int used,
                 Normal& normal) const {
    const FruitDistance d = distance_to(shape, p.point_m, waves);
    const double across = std::sqrt(std::max(0.0, 1 - d.normal.z() * d.normal.z()));
    const double aside_m = 0.5 * p.point_m.z() / surface_.focal_px * across;
    const double along_m = p.sigma_m * d.normal.z();
    const double sigma_m =
        std::sqrt(along_m * along_m + aside_m * aside_m + config_.floor_m * config_.floor_m);
    const double r = d.distance_m / sigma_m;
    const Robust robust = huber(r);
    normal.add(d.derivative, d.distance_m, share * robust.weight / (sigma_m * sigma_m), used);
    normal.depth_cost += share * robust.cost;
    normal.depth_squares += robust.weight * r * r;
    normal.depth_count += 1;
  }

  void add_place(const FruitShape& shape, const OutlinePlace& place, bool waves, double share,
                 int used, Normal& normal) const {
    // Where the ray comes nearest to the centre in the unstretched sphere's space, then one
    // Newton step to where it comes nearest to the surface.
    const Eigen::Matrix3d to_fruit = shape.camera_from_fruit.transpose();
    const Vector3d squash(1, 1, 1 / shape.stretch());
    const Vector3d from = squash.cwiseProduct(to_fruit * -shape.centre_m());
    const Vector3d way = squash.cwiseProduct(to_fruit * place.ray);
    const double first_m = -from.dot(way) / way.squaredNorm();
    if (!(first_m > 0)) return;
    const FruitDistance at_first = distance_to(shape, first_m * place.ray, false);
    const double most_m = 0.3 * shape.radius_m();
    const double on_m =
        std::clamp(-at_first.normal.dot(place.ray) * shape.radius_m(), -most_m, most_m);
    const Vector3d nearest_m = (first_m + on_m) * place.ray;
    const FruitDistance d = distance_to(shape, nearest_m, waves);
    const double sigma_m = config_.outline_sigma_px * nearest_m.z() / surface_.focal_px;
    const double r = d.distance_m / sigma_m;
    // An edge that is not along the model's rim is what hides it.
    const bool is_along = d.normal.dot(place.outward) > config_.along_rim;
    const bool is_own = is_along && place.beyond == Beyond::farther;
    const bool may_be_own = is_along && place.beyond == Beyond::unknown;
    const Robust robust = is_own && r > 0 ? huber(r) : cauchy(r);
    if (place.beyond == Beyond::farther) {
      constexpr double kMostBeside = 4;  // a leaf that no depth shows may cut the fruit
      normal.edge_places += share;
      normal.edge_cost += share * (is_own ? robust.cost : std::min(r * r, kMostBeside));
    }
    if (!is_own && r > 1) {  // the mask is of the fruit, whatever ends it
      const Robust outside = huber(r - 1);
      normal.add(d.derivative, d.distance_m - sigma_m, share * outside.weight / (sigma_m * sigma_m),
                 used);
      normal.cost += share * outside.cost;
    }
    if (!is_own && !may_be_own) return;
    if (may_be_own) share *= config_.unknown_share;
    if (is_own) {
      normal.rim_squares += std::min(r * r, 16.0);
      normal.rim_places += 1;
    }
    normal.add(d.derivative, d.distance_m, share * robust.weight / (sigma_m * sigma_m), used);
    normal.cost += share * robust.cost;
  }

  const FruitSurface& surface_;
  const FruitFitConfig& config_;
  const FruitShape& mean_;
  const FruitParameters& sigmas_;
  double point_share_ = 1;
};

/// Axes that are tried: upright in the image, towards the camera and away, and to both sides.
std::vector<Vector3d> start_axes() {
  std::vector<Vector3d> axes;
  for (const double pitch : {-1.2, -0.6, 0.0, 0.6, 1.2})
    axes.emplace_back(0, -std::cos(pitch), std::sin(pitch));
  for (const double lean : {-0.7, 0.7}) axes.emplace_back(std::sin(lean), -std::cos(lean), 0);
  return axes;
}

struct Candidate {
  FruitShape shape;
  double cost = 0;
  FruitNumbers numbers;  ///< coarsely
};
void sort_by_cost(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
}

std::vector<Candidate> candidates_of(const Search& search, const FruitFitConfig& config) {
  constexpr std::size_t kStride = 3;
  constexpr int kFirstSteps = 5;
  std::vector<Candidate> candidates;
  for (const Vector3d& axis : start_axes()) {
    const Search::Found found = search.improved(search.start(axis), false, 1, kStride, kFirstSteps);
    candidates.push_back({found.shape, found.normal.cost, {}});
  }
  sort_by_cost(candidates);
  candidates.resize(
      std::min<std::size_t>(candidates.size(), static_cast<std::size_t>(config.followed)));
  for (Candidate& one : candidates) {
    const Search::Found found = search.improved(one.shape, false, 1, 1, config.iterations);
    one = {found.shape, found.normal.cost, numbers_of(found.shape, 12)};
  }
  sort_by_cost(candidates);
  return candidates;
}

/// A fit under one prior of shapes.
struct Hypothesis {
  double scale = 1;
  FruitShape shape;
  FruitCovariance covariance;
  double evidence = 0;  ///< -2 log of the probability of what is seen, but for a constant [Laplace]
  double rms = kNaN;    ///< of depths, in sigmas
  double misfit = 0;    ///< cost above that of a fruit of the kind
  FruitMeasure volume_m3, diameter_m, length_m;
};

Hypothesis fit_under(const Search& search, const FruitShape& from, double scale, int steps,
                     const FruitFitConfig& config, double independent_points) {
  const Search::Found found = search.improved(from, true, scale, 1, steps);
  const Normal& normal = found.normal;
  Hypothesis fit;
  fit.scale = scale;
  fit.shape = found.shape;
  const Eigen::MatrixXd information = normal.information.selfadjointView<Eigen::Lower>();
  const Eigen::LDLT<Eigen::MatrixXd> solver(information);
  fit.evidence = normal.cost + solver.vectorD().array().abs().max(1e-300).log().sum();
  for (int k = kLogRadius; k < kFruitNumbers; ++k)
    fit.evidence += 2 * std::log(search.sigmas()[k] * scale_at(k, scale));
  fit.rms = std::sqrt(normal.depth_squares / std::max(1.0, normal.depth_count));
  // What one part explains well excuses no other.
  fit.misfit = std::max(0.0, normal.edge_cost - config.usual_rim * normal.edge_places) +
               std::max(0.0, normal.depth_cost - config.usual_depth * independent_points) +
               std::max(0.0, normal.prior_cost - config.usual_prior);
  const double rim = std::sqrt(normal.rim_squares / std::max(1.0, normal.rim_places));
  const double spread = std::max({1.0, fit.rms, rim});
  fit.covariance =
      spread * spread * solver.solve(Eigen::MatrixXd::Identity(kFruitNumbers, kFruitNumbers));
  return fit;
}

/// What other axes that fit about as well add to the variance of a number.
double between_axes(const std::vector<Candidate>& candidates,
                    double (*number)(const FruitNumbers&)) {
  double weights = 0, mean = 0, square = 0;
  for (const Candidate& one : candidates) {
    const double lead = one.cost - candidates.front().cost;
    if (lead > 12) continue;
    const double w = std::exp(-0.5 * lead);
    const double value = number(one.numbers);
    weights += w;
    mean += w * value;
    square += w * value * value;
  }
  mean /= weights;
  return std::max(0.0, square / weights - mean * mean);
}

FruitMeasure measure(const FruitNumber& number, const FruitCovariance& covariance, double between,
                     double unit_sigma, double widen) {
  const double own = number.derivative.dot(covariance * number.derivative);
  const double unit = unit_sigma * number.value;
  return {number.value, widen * std::sqrt(std::max(0.0, own) + between + unit * unit)};
}

void set_sizes(const std::vector<Candidate>& candidates, const FruitFitConfig& config,
               double solid_share, Hypothesis& fit) {
  const FruitNumbers numbers = numbers_of(fit.shape);
  const auto size = [&](const FruitNumber& number, double (*value)(const FruitNumbers&),
                        double dimensions) {
    return measure(number, fit.covariance, between_axes(candidates, value),
                   dimensions * config.unit_sigma, config.widen);
  };
  fit.volume_m3 = size(
      numbers.volume_m3, [](const FruitNumbers& n) { return n.volume_m3.value; }, 3);
  fit.volume_m3.value *= solid_share;
  fit.volume_m3.sigma *= solid_share;
  fit.diameter_m = size(
      numbers.diameter_m, [](const FruitNumbers& n) { return n.diameter_m.value; }, 1);
  fit.length_m = size(
      numbers.length_m, [](const FruitNumbers& n) { return n.length_m.value; }, 1);
}

/// The likelier one's value; its variance has what the other, so likely, would make of it.
FruitMeasure either(const FruitMeasure& likelier, const FruitMeasure& other, double share) {
  const double off = other.value - likelier.value;
  return {likelier.value, std::sqrt((1 - share) * likelier.sigma * likelier.sigma +
                                    share * (other.sigma * other.sigma + off * off))};
}

/// One fit of two hypotheses. @param odd_share  probability of an odd shape before it is seen
FruitFit combined(const Hypothesis& usual, const Hypothesis& odd, double odd_share) {
  const double lead = std::clamp(0.5 * (odd.evidence - usual.evidence), -50.0, 50.0);
  const double is_odd = 1 / (1 + std::exp(lead) * (1 - odd_share) / std::max(1e-9, odd_share));
  const Hypothesis& likelier = is_odd > 0.5 ? odd : usual;
  const Hypothesis& other = is_odd > 0.5 ? usual : odd;
  const double share = std::min(is_odd, 1 - is_odd);
  FruitFit fit;
  fit.shape = likelier.shape;
  fit.covariance = likelier.covariance;
  fit.rms = likelier.rms;
  fit.wave_scale = likelier.scale;
  fit.volume_m3 = either(likelier.volume_m3, other.volume_m3, share);
  fit.diameter_m = either(likelier.diameter_m, other.diameter_m, share);
  fit.length_m = either(likelier.length_m, other.length_m, share);
  return fit;
}

constexpr double kMostLonger = 1.6;  ///< length over width of one lump's mask; two balls have 2

bool is_strange(const FruitFit& fit) { return fit.strange > 0.5; }

/// The fit with what it is if the fruit is strange.
/// @param misfit  of the kind's best shape
void allow_for_strange(const FruitLump& lump, double misfit, const Search& search,
                       const FruitFitConfig& config, const FruitPrior& prior, FruitFit& fit) {
  const double lead = std::clamp(0.5 * misfit, -50.0, 50.0);
  const double odds = std::exp(lead) * config.strange_share / (1 - config.strange_share);
  fit.strange = odds / (1 + odds);
  constexpr double kSurely = 0.95;  // what is less sure keeps its own value, and a wide interval
  const bool is_lump = fit.strange > kSurely && lump.is_whole;
  const auto mixed = [&](const FruitMeasure& own, const FruitMeasure& of_lump) {
    return is_lump ? either(of_lump, own, 1 - fit.strange) : either(own, of_lump, fit.strange);
  };
  fit.volume_m3 = mixed(fit.volume_m3, lump.volume_m3);
  fit.diameter_m = mixed(fit.diameter_m, lump.diameter_m);
  fit.length_m = mixed(fit.length_m, lump.length_m);
  if (is_lump) {
    fit.shape = shape_of(lump, search.start({0, -1, 0}));
    fit.covariance = spread_of(lump);
  } else {
    fit.covariance += fit.strange * spread_of(lump);
  }
  fit.mass_kg.value = prior.density_kg_m3 * fit.volume_m3.value;
  fit.mass_kg.sigma =
      fit.mass_kg.value * std::hypot(fit.volume_m3.sigma / fit.volume_m3.value,
                                     prior.sigma_density_kg_m3 / prior.density_kg_m3);
}

/// Says why a fit is not to be trusted; empty: it is.
std::string why_not(const FruitFit& fit, const FruitLump& lump, const Search& search,
                    const FruitFitConfig& config) {
  if (is_strange(fit) && lump.longer > kMostLonger)
    return "its mask is " + std::to_string(lump.longer) +
           " times as long as wide, and no such fruit: it may be two";
  if (!(fit.rms < config.most_rms))
    return "its depths are " + std::to_string(fit.rms) +
           " sigmas off any such fruit: most_rms is " + std::to_string(config.most_rms);
  if (!(fit.volume_m3.sigma < config.most_sigma_volume * fit.volume_m3.value))
    return (is_strange(fit) ? "it has the shape of no such fruit: its volume is known to "
                            : "too little of it is seen: its volume is known to ") +
           std::to_string(100 * fit.volume_m3.sigma / fit.volume_m3.value) + " %";
  for (const auto& [k, what] : {std::pair(static_cast<int>(kLogRadius), "size"),
                                {static_cast<int>(kLogStretch), "length over diameter"}}) {
    const double odd = (fit.shape.numbers[k] - search.mean().numbers[k]) / search.sigmas()[k];
    if (std::abs(odd) > config.most_odd)
      return "its " + std::string(what) + " is " + std::to_string(odd) +
             " sigmas from the kind's: it may be something else";
  }
  return {};
}

}  // namespace

Fields fields(FruitFitConfig& c) {
  return {
      {"iterations", &c.iterations, "of each start that is followed", 1, 1000},
      {"followed", &c.followed, "starts, of those that are tried", 1, 7},
      {"wave_iterations", &c.wave_iterations, "of the whole shape; twice that of an odd one", 1,
       1000},
      {"odd_scale", &c.odd_scale, "of an odd shape's waves over the prior's", 1, 1000},
      {"odd_share", &c.odd_share, "probability of an odd shape before it is seen", 0, 1},
      {"strange_share", &c.strange_share, "probability of a fruit like none of its kind", 0, 0.5},
      {"usual_rim", &c.usual_rim, "mean cost of a place of a usual fruit's outline", 0, 100},
      {"usual_depth", &c.usual_depth, "the same of an independent depth", 0, 100},
      {"usual_prior", &c.usual_prior, "and of the prior", 0, 1000},
      {"outline_sigma_px", &c.outline_sigma_px, "sigma of a place of the outline", 0.01, 100},
      {"along_rim", &c.along_rim, "cosine of an edge's turn against the rim; less is not the rim",
       -1, 1},
      {"unknown_share", &c.unknown_share, "weight of an outline with no depth beyond it", 0, 1},
      {"floor_m", &c.floor_m, "sigma of a surface finer than the model's", 1e-6, 1},
      {"unit_sigma", &c.unit_sigma, "sigma of what all lengths of a unit are off, over them", 0, 1},
      {"lean_sigma", &c.lean_sigma, "sigma of the axis sideways", 0.01, 100},
      {"pitch_sigma", &c.pitch_sigma, "and towards the camera", 0.01, 100},
      {"most_rms", &c.most_rms, "residuals of more sigmas are of no such fruit", 1, 1000},
      {"most_sigma_volume", &c.most_sigma_volume, "over the volume; more is too little seen", 0.001,
       10},
      {"most_odd", &c.most_odd, "sigmas of the prior that a size or shape may be off", 0.1, 1000},
      {"widen", &c.widen, "times all sigmas", 0.1, 10}};
}

void validate(const FruitFitConfig& config) {
  FruitFitConfig copy = config;
  check_limits(fields(copy), "fit");
}

FruitFit unseen_fruit(const FruitKind& kind, const std::string& reason) {
  const FruitPrior& prior = kind.prior;
  FruitFit fit;
  fit.status = FitStatus::too_few_points;
  fit.reason = reason;
  fit.shape = kind.mean;
  const FruitNumbers numbers = numbers_of(fit.shape, 12);
  const double size = prior.sigma_diameter, index = prior.sigma_shape_index / prior.shape_index;
  const double volume = std::hypot(3 * size, index);
  fit.volume_m3.value = prior.solid_share * numbers.volume_m3.value;
  fit.volume_m3.sigma = volume * fit.volume_m3.value;
  fit.diameter_m = {numbers.diameter_m.value, size * numbers.diameter_m.value};
  fit.length_m = {numbers.length_m.value, std::hypot(size, index) * numbers.length_m.value};
  fit.mass_kg.value = prior.density_kg_m3 * fit.volume_m3.value;
  fit.mass_kg.sigma =
      fit.mass_kg.value * std::hypot(volume, prior.sigma_density_kg_m3 / prior.density_kg_m3);
  return fit;
}

FruitFit fit_fruit(const FruitSurface& surface, const FruitKind& kind,
                   const FruitFitConfig& config) {
  if (!surface.why_none.empty()) return unseen_fruit(kind, surface.why_none);
  const Search search(surface, kind, config);
  const std::vector<Candidate> candidates = candidates_of(search, config);
  const auto under = [&](const FruitShape& from, double scale, int steps) {
    return fit_under(search, from, scale, steps, config, surface.independent_points);
  };
  Hypothesis usual = under(candidates.front().shape, 1, config.wave_iterations);
  Hypothesis odd = under(usual.shape, config.odd_scale, 2 * config.wave_iterations);
  set_sizes(candidates, config, kind.prior.solid_share, usual);
  set_sizes(candidates, config, kind.prior.solid_share, odd);
  FruitFit fit = combined(usual, odd, config.odd_share);
  const FruitLump lump = lump_of(surface, kind.prior.solid_share);
  allow_for_strange(lump, usual.misfit, search, config, kind.prior, fit);
  fit.reason = why_not(fit, lump, search, config);
  fit.status = fit.reason.empty() ? FitStatus::ok : FitStatus::degenerate;
  if (fit.status == FitStatus::ok && is_strange(fit))
    fit.reason = "it has the shape of no such fruit: its intervals are wide";
  if (!fit.covariance.allFinite() || !std::isfinite(fit.volume_m3.value))
    return unseen_fruit(kind, "its fit does not converge");
  return fit;
}

}  // namespace cousin
