#include "perception/silhouette/edge_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace cousin {
namespace {

constexpr double kAlong_px = 1.5;
constexpr double kAcross_px = 3.5;
constexpr int kLinear = 9;                                  ///< s0 (3), s1 (3), w0, w1, e
constexpr int kOffset = kLinear, kCurvature = kLinear + 1;  ///< Gauss-Newton steps
constexpr int kUnknowns = kLinear + 2;
constexpr int kIterations = 8;
constexpr double kFarthest_px = 2.5;  ///< an edge farther from the guess is not the one meant
constexpr double kHuber = 2.0;

// Noise of a pixel in linear colour: read noise and quantisation, and shot noise. Only ratios
// matter: each fit scales it to its own misfit.
constexpr double kFloorVariance = 1.0e-5;
constexpr double kShotVariance = 1.7e-4;

// Priors (mean 0 but for w0), in units of the object's or the board's brightness, per pixel where
// it is a change.
constexpr double kObjectChange = 0.10;
constexpr double kLight = 0.7, kLightSigma = 0.4, kLightChange = 0.08;
constexpr double kReflected = 0.15;
// Of the curvature about the guess's, whose line is smoothed: a tip is sharper than it looks.
constexpr double kCurvatureSigma = 0.1;
constexpr double kLeastCurvature = -0.3, kLargestCurvature = 1;

struct Sample {
  Eigen::Vector3d color, board, reflected;
  double across = 0;  ///< v
  double bend =
      0;  ///< (t^2 + sigma^2) / 2: times the curvature, how far the half-level line is inside
  double weight = 1;  ///< robust
};

using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

double upper_tail(double x) { return 0.5 * std::erfc(x * std::numbers::sqrt2 / 2); }
double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi); }

struct Problem {
  std::vector<Sample> samples;
  Unknowns prior_mean = Unknowns::Zero(), prior_precision = Unknowns::Zero();
  double sigma_px = 0;
  double guessed_curvature = 0;
};

/// Where the edge is now believed to be.
struct Edge {
  double offset_px = 0, curvature = 0;
};

std::optional<Problem> gather(const ObjectWindow& window, const ContourVertex& guess,
                              double blur_sigma_px) {
  Problem problem;
  problem.sigma_px = std::sqrt(blur_sigma_px * blur_sigma_px + 1.0 / 12);
  const Eigen::Vector2d tangent(-guess.normal.y(), guess.normal.x());
  const double reach = kAlong_px + kAcross_px;
  const int x0 = static_cast<int>(std::floor(guess.pixel_px.x() - reach));
  const int y0 = static_cast<int>(std::floor(guess.pixel_px.y() - reach));
  const int size = static_cast<int>(std::ceil(2 * reach)) + 1;
  int on_plate = 0, off_plate = 0;
  Eigen::Vector3d beyond = Eigen::Vector3d::Zero();
  problem.guessed_curvature =
      std::clamp(guess.curvature_per_px, kLeastCurvature, kLargestCurvature);
  const Eigen::Vector3d object = window.object.cast<double>();
  for (int y = y0; y < y0 + size; ++y) {
    for (int x = x0; x < x0 + size; ++x) {
      const Eigen::Vector2d from_guess = Eigen::Vector2d(x, y) - guess.pixel_px;
      const double along = tangent.dot(from_guess), across = guess.normal.dot(from_guess);
      if (std::abs(along) > kAlong_px || std::abs(across) > kAcross_px) continue;
      if (!window.color.contains(x, y)) return std::nullopt;
      Sample sample;
      sample.color = window.color(x, y).cast<double>();
      sample.board = window.board_at(x, y).cast<double>();
      sample.reflected = window.white(x, y) * object;
      sample.across = across;
      sample.bend = 0.5 * (along * along + problem.sigma_px * problem.sigma_px);
      if (across > 0) {
        const bool plate = window.on_plate(x, y) != 0;
        on_plate += plate ? 1 : 0;
        off_plate += plate ? 0 : 1;
        if (across > 2) beyond += sample.color;
      }
      problem.samples.push_back(sample);
    }
  }
  if (problem.samples.size() < 12 || (on_plate > 0 && off_plate > 0)) return std::nullopt;
  double light = kLight;
  if (off_plate > 0) {
    // One unknown colour, measured outside; its brightness stays free.
    int count = 0;
    for (const Sample& sample : problem.samples) count += sample.across > 2 ? 1 : 0;
    if (count == 0) return std::nullopt;
    for (Sample& sample : problem.samples) {
      sample.board = beyond / count;
      sample.reflected.setZero();
    }
    light = 1;
  }
  const double brightness = object.norm() / std::numbers::sqrt3;
  const auto precision = [](double sigma) { return 1 / (sigma * sigma); };
  problem.prior_precision << Eigen::Vector3d::Constant(precision(2 * brightness)),
      Eigen::Vector3d::Constant(precision(kObjectChange * brightness)), precision(kLightSigma),
      precision(kLightChange), precision(kReflected), 0, precision(kCurvatureSigma);
  problem.prior_mean.head<3>() = object;
  problem.prior_mean[6] = light;
  return problem;
}

/// Linear unknowns at an edge; the last two are the edge's Gauss-Newton step about them.
struct Solution {
  Unknowns x = Unknowns::Zero();
  double cost = 0;      ///< with priors, of the linear model
  double variance = 0;  ///< of the offset
};

/// @param step_about  the colours of a solution before, for the derivatives by the edge; nullptr:
/// edge held
Solution solve(const Problem& problem, const Edge& edge, const Unknowns* step_about) {
  Normal h = problem.prior_precision.asDiagonal();
  Unknowns mean = problem.prior_mean;
  mean[kCurvature] = step_about != nullptr ? problem.guessed_curvature - edge.curvature : 0;
  Unknowns g = problem.prior_precision.cwiseProduct(mean);
  double constant = mean.dot(g);
  for (const Sample& sample : problem.samples) {
    const double z =
        (sample.across - edge.offset_px + edge.curvature * sample.bend) / problem.sigma_px;
    const double a = upper_tail(z), rest = 1 - a, slope = density(z) / problem.sigma_px;
    const double inwards = std::min(0.0, sample.across - edge.offset_px);
    const double outwards = std::max(0.0, sample.across - edge.offset_px);
    for (int channel = 0; channel < 3; ++channel) {
      Unknowns row = Unknowns::Zero();
      row[channel] = a;
      row[3 + channel] = a * inwards;
      row[6] = rest * sample.board[channel];
      row[7] = row[6] * outwards;
      row[8] = rest * sample.reflected[channel];
      if (step_about != nullptr) {
        const Unknowns& x = *step_about;
        const double object = x[channel] + x[3 + channel] * inwards;
        const double board =
            (x[6] + x[7] * outwards) * sample.board[channel] + x[8] * sample.reflected[channel];
        row[kOffset] = slope * (object - board);
        row[kCurvature] = -sample.bend * row[kOffset];
      }
      const double weight =
          sample.weight / (kFloorVariance + kShotVariance * sample.color[channel]);
      h.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
      g += weight * sample.color[channel] * row;
      constant += weight * sample.color[channel] * sample.color[channel];
    }
  }
  if (step_about == nullptr) h(kOffset, kOffset) = 1;
  const Eigen::LLT<Normal> solver(h.selfadjointView<Eigen::Lower>());
  Solution solution;
  solution.x = solver.solve(g);
  solution.cost = constant - g.dot(solution.x);
  solution.variance = solver.solve(Unknowns::Unit(kOffset))[kOffset];
  return solution;
}

/// Robust weights from the residuals, and their mean square in units of the pixel noise.
double reweigh(Problem& problem, const Edge& edge, const Unknowns& x) {
  std::vector<double> squares;
  for (Sample& sample : problem.samples) {
    const double a = upper_tail((sample.across - edge.offset_px + edge.curvature * sample.bend) /
                                problem.sigma_px);
    const double inwards = std::min(0.0, sample.across - edge.offset_px);
    const double outwards = std::max(0.0, sample.across - edge.offset_px);
    double square = 0;
    for (int channel = 0; channel < 3; ++channel) {
      const double object = x[channel] + x[3 + channel] * inwards;
      const double board =
          (x[6] + x[7] * outwards) * sample.board[channel] + x[8] * sample.reflected[channel];
      const double residual = sample.color[channel] - a * object - (1 - a) * board;
      square += residual * residual / (kFloorVariance + kShotVariance * sample.color[channel]);
    }
    squares.push_back(square / 3);
  }
  std::vector<double> sorted = squares;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double typical =
      std::max(1e-6, *middle / 0.79);  // median of a mean of three squared normals
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double distance = std::sqrt(squares[i] / typical);
    problem.samples[i].weight = distance <= kHuber ? 1 : kHuber / distance;
    sum += problem.samples[i].weight * squares[i];
    weights += problem.samples[i].weight;
  }
  // Nine or so of the residuals' freedoms are spent on the unknowns.
  const double freedoms = 3.0 * static_cast<double>(squares.size());
  return sum / weights * freedoms / std::max(1.0, freedoms - kUnknowns);
}

}  // namespace

std::optional<EdgeFit> fit_edge(const ObjectWindow& window, const ContourVertex& guess,
                                const EdgeFitOptions& options) {
  auto problem = gather(window, guess, options.blur_sigma_px);
  if (!problem) return std::nullopt;

  Edge edge{0, problem->guessed_curvature};
  Solution solution = solve(*problem, edge, nullptr);
  for (double trial = -options.search_px; trial <= options.search_px; trial += 0.5) {
    const Solution candidate = solve(*problem, {trial, edge.curvature}, nullptr);
    if (!(candidate.cost < solution.cost)) continue;
    solution = candidate;
    edge.offset_px = trial;
  }

  double misfit = 1;
  for (int i = 0; i < kIterations; ++i) {
    misfit = reweigh(*problem, edge, solution.x);
    solution = solve(*problem, edge, &solution.x);
    const double step = std::clamp(solution.x[kOffset], -0.5, 0.5);
    edge.offset_px += step;
    edge.curvature = std::clamp(edge.curvature + std::clamp(solution.x[kCurvature], -0.2, 0.2),
                                kLeastCurvature, kLargestCurvature);
    if (!std::isfinite(edge.offset_px) || std::abs(edge.offset_px) > kFarthest_px)
      return std::nullopt;
    if (std::abs(step) < 2e-3 && i > 1) break;
  }

  EdgeFit fit;
  fit.offset_px = edge.offset_px;
  fit.sigma_px = std::sqrt(solution.variance * std::max(1.0, misfit));
  Eigen::Vector3d board = Eigen::Vector3d::Zero();
  double count = 0;
  for (const Sample& sample : problem->samples) {
    if (std::abs(sample.across - edge.offset_px) > 1) continue;
    board += solution.x[6] * sample.board + solution.x[8] * sample.reflected;
    count += 1;
  }
  if (count > 0) fit.contrast = (solution.x.head<3>() - board / count).norm() / std::numbers::sqrt3;
  return fit;
}

}  // namespace cousin
