#include "calibration/solve/calibration_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

constexpr double kRoundingEigenvalue = 1e-13;
constexpr double kNamedShare = 0.1;  ///< of a direction, above which a parameter belongs to it

/// Where a view's parameters lie in the shared vector.
struct Columns {
  std::vector<std::vector<int>> lens;  ///< for each lens, for each parameter: its column or -1
  std::vector<int> camera;             ///< first of six, or -1
  int deformation = -1;
  int count = 0;
};

Columns columns_of(const CalibrationProblem& problem) {
  Columns c;
  for (const ProblemLens& lens : problem.lenses) {
    std::vector<int> at;
    for (const bool free : lens.free) at.push_back(free ? c.count++ : -1);
    c.lens.push_back(at);
  }
  c.camera.assign(problem.lens_of_camera.size(), -1);
  for (std::size_t i = 1; i < c.camera.size(); ++i, c.count += 6) c.camera[i] = c.count;
  if (problem.config.board_deformation) {
    c.deformation = c.count;
    c.count += 2;
  }
  return c;
}

void name_columns(const CalibrationProblem& problem, const CalibrationState& state,
                  SharedSystem& system) {
  std::vector<double> values, scale;
  const auto add = [&](const std::string& name, double value, double unit) {
    system.names.push_back(name);
    values.push_back(value);
    scale.push_back(unit);
  };
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    const std::vector<std::string> names = lens_parameter_names(problem.lenses[i].shape);
    std::size_t camera = 0;
    while (problem.lens_of_camera[camera] != static_cast<int>(i)) ++camera;
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (!problem.lenses[i].free[k]) continue;
      add("camera" + std::to_string(camera) + "." + names[k],
          state.lenses[i](static_cast<Eigen::Index>(k)), 1);
    }
  }
  for (std::size_t c = 1; c < state.cameras.size(); ++c) {
    const std::string prefix = "camera" + std::to_string(c);
    for (int k = 0; k < 6; ++k) {
      const std::string axis(1, "xyz"[k % 3]);
      add(prefix + (k < 3 ? ".r_" : ".t_") + axis, state.cameras[c](k), k < 3 ? 1 : problem.unit_m);
    }
  }
  if (problem.config.board_deformation) {
    add("kx_m", state.deformation.x(), problem.unit_m);
    add("ky_m", state.deformation.y(), problem.unit_m);
  }
  const auto n = static_cast<Eigen::Index>(values.size());
  system.values = Eigen::Map<const Eigen::VectorXd>(values.data(), n);
  system.scale = Eigen::Map<const Eigen::VectorXd>(scale.data(), n);
}

/// Jacobian of a view's residuals: by its frame's pose and by the shared parameters it knows.
struct ViewJacobian {
  std::vector<int> columns;
  Eigen::MatrixXd shared;
  Eigen::Matrix<double, Eigen::Dynamic, 6> frame;
  Eigen::VectorXd residual;
};

ViewJacobian view_jacobian(const CalibrationProblem& problem, const CalibrationState& state,
                           const ProblemView& view, const Columns& columns, SharedSystem& system) {
  const auto camera = static_cast<std::size_t>(view.camera);
  const auto lens = static_cast<std::size_t>(problem.lens_of_camera[camera]);
  const LensShape& shape = problem.lenses[lens].shape;
  const int n = lens_parameter_count(shape);
  ViewJacobian j;
  std::vector<int> free;
  for (int k = 0; k < n; ++k) {
    if (columns.lens[lens][static_cast<std::size_t>(k)] < 0) continue;
    free.push_back(k);
    j.columns.push_back(columns.lens[lens][static_cast<std::size_t>(k)]);
  }
  const bool moves = columns.camera[camera] >= 0;
  for (int k = 0; moves && k < 6; ++k) j.columns.push_back(columns.camera[camera] + k);
  for (int k = 0; columns.deformation >= 0 && k < 2; ++k)
    j.columns.push_back(columns.deformation + k);
  const auto rows = 2 * static_cast<Eigen::Index>(view.points.size());
  j.shared = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(j.columns.size()));
  j.frame = Eigen::MatrixXd::Zero(rows, 6);
  j.residual = Eigen::VectorXd::Zero(rows);
  const PosedFrame frame(state.frames[static_cast<std::size_t>(view.frame)].data());
  const PosedFrame in_rig(state.cameras[camera].data());
  RowMatrix d_lens(2, n);
  ObservationValue value;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const ProblemPoint& p = view.points[i];
    if (p.rejected || !observe(shape, state.lenses[lens].data(), &in_rig, frame,
                               deformed(problem, p.id, state.deformation), value, d_lens.data()))
      continue;
    const Eigen::Vector2d residual = p.white * (value.pixel_px - p.pixel_px);
    const Softened soft = soften(problem.config.loss, problem.config.loss_px, residual);
    const Eigen::Matrix2d w = std::sqrt(soft.weight) * p.white;
    system.squares += soft.weight * residual.squaredNorm();
    system.cost += soft.factor * soft.factor * residual.squaredNorm();
    system.coordinates += 2;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    j.frame.middleRows<2>(row) = w * value.d_rig_from_points;
    j.residual.segment<2>(row) = std::sqrt(soft.weight) * residual;
    Eigen::Index column = 0;
    for (const int k : free) j.shared.block<2, 1>(row, column++) = w * d_lens.col(k);
    if (moves) {
      j.shared.block<2, 6>(row, column) = w * value.d_camera_from_rig;
      column += 6;
    }
    if (columns.deformation >= 0)
      j.shared.block<2, 2>(row, column) =
          w * value.d_point.col(2) * d_deformation(problem, p.id).transpose();
  }
  return j;
}

void add_prior(SharedSystem& system, Eigen::Index column, double sigma, double off) {
  const double weight = 1 / (sigma * sigma);
  system.reduced(column, column) += weight;
  system.diagonal(column) += weight;
  system.right(column) += weight * off;
}

void add_priors(const CalibrationProblem& problem, const CalibrationState& state,
                const Columns& columns, SharedSystem& system) {
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    const ProblemLens& lens = problem.lenses[i];
    for (std::size_t k = 0; k < lens.free.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      if (!lens.free[k] || !std::isfinite(lens.prior_sigma(at))) continue;
      add_prior(system, columns.lens[i][k], lens.prior_sigma(at),
                state.lenses[i](at) - lens.prior_mean(at));
    }
  }
  const double sigma = problem.config.deformation_prior_share;
  for (int k = 0; sigma > 0 && columns.deformation >= 0 && k < 2; ++k)
    add_prior(system, columns.deformation + k, sigma, state.deformation(k));
}

/// Takes a change of a pose's six numbers to a twist about the origin of the frame it leads to.
Eigen::Matrix<double, 6, 6> twist_of(const Vector6d& pose) {
  const PosedFrame frame(pose.data());
  Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Identity();
  a.topLeftCorner<3, 3>() = frame.left_jacobian;
  a.bottomLeftCorner<3, 3>() = cross_matrix(frame.translation) * frame.left_jacobian;
  return a;
}

}  // namespace

SharedSystem shared_system(const CalibrationProblem& problem, const CalibrationState& state) {
  const Columns columns = columns_of(problem);
  SharedSystem system;
  name_columns(problem, state, system);
  const Eigen::Index n = columns.count;
  system.reduced = Eigen::MatrixXd::Zero(n, n);
  system.diagonal = Eigen::VectorXd::Zero(n);
  system.right = Eigen::VectorXd::Zero(n);
  system.mean_frame_gain = Eigen::MatrixXd::Zero(6, n);
  const double share = 1 / static_cast<double>(problem.frames.size());
  for (std::size_t v = 0; v < problem.views.size();) {
    const int frame = problem.views[v].frame;
    Eigen::Matrix<double, 6, 6> own = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(6, n);
    Vector6d own_right = Vector6d::Zero();
    for (; v < problem.views.size() && problem.views[v].frame == frame; ++v) {
      const ViewJacobian j = view_jacobian(problem, state, problem.views[v], columns, system);
      own += j.frame.transpose() * j.frame;
      own_right += j.frame.transpose() * j.residual;
      const Eigen::VectorXd shared_right = j.shared.transpose() * j.residual;
      const Eigen::MatrixXd across = j.frame.transpose() * j.shared;
      const Eigen::MatrixXd square = j.shared.transpose() * j.shared;
      for (std::size_t a = 0; a < j.columns.size(); ++a) {
        const auto ia = static_cast<Eigen::Index>(a);
        mixed.col(j.columns[a]) += across.col(ia);
        system.right(j.columns[a]) += shared_right(ia);
        system.diagonal(j.columns[a]) += square(ia, ia);
        for (std::size_t b = 0; b < j.columns.size(); ++b)
          system.reduced(j.columns[a], j.columns[b]) += square(ia, static_cast<Eigen::Index>(b));
      }
    }
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(own);
    const Eigen::MatrixXd gain = factor.solve(mixed);
    system.reduced.noalias() -= mixed.transpose() * gain;
    system.frame_gain.emplace_back(gain);
    system.frame_own.emplace_back(factor.solve(own_right));
    system.right -= mixed.transpose() * system.frame_own.back();
    const Eigen::Matrix<double, 6, 6> twist =
        share * twist_of(state.frames[static_cast<std::size_t>(frame)]);
    system.mean_frame_gain -= twist * gain;
    system.mean_frame_covariance +=
        twist * factor.solve(Eigen::Matrix<double, 6, 6>::Identity()) * twist.transpose();
  }
  add_priors(problem, state, columns, system);
  return system;
}

SharedCovariance invert(const SharedSystem& system) {
  SharedCovariance result;
  const Eigen::Index n = system.reduced.rows();
  std::set<std::string> unseen;
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (system.diagonal(i) > 0) {
      scale(i) = 1 / std::sqrt(system.diagonal(i));
    } else {
      unseen.insert(system.names[static_cast<std::size_t>(i)]);
    }
  }
  const Eigen::MatrixXd scaled = scale.asDiagonal() *
                                 (0.5 * (system.reduced + system.reduced.transpose())) *
                                 scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (solver.eigenvalues()(i) > kRoundingEigenvalue) {
      inverse(i) = 1 / solver.eigenvalues()(i);
      continue;
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      if (std::abs(solver.eigenvectors()(k, i)) > kNamedShare)
        unseen.insert(system.names[static_cast<std::size_t>(k)]);
    }
  }
  result.covariance = scale.asDiagonal() * solver.eigenvectors() * inverse.asDiagonal() *
                      solver.eigenvectors().transpose() * scale.asDiagonal();
  for (const std::string& name : system.names) {
    if (unseen.count(name) > 0) result.not_determined.push_back(name);
  }
  return result;
}

CalibrationState gauss_newton_step(const CalibrationProblem& problem, const CalibrationState& state,
                                   const SharedSystem& system, const SharedCovariance& inverse) {
  CalibrationState next = state;
  const Eigen::VectorXd step = -(inverse.covariance * system.right);
  const Columns columns = columns_of(problem);
  for (std::size_t i = 0; i < columns.lens.size(); ++i) {
    for (std::size_t k = 0; k < columns.lens[i].size(); ++k) {
      if (columns.lens[i][k] >= 0)
        next.lenses[i](static_cast<Eigen::Index>(k)) += step(columns.lens[i][k]);
    }
  }
  for (std::size_t c = 1; c < columns.camera.size(); ++c)
    next.cameras[c] += step.segment<6>(columns.camera[c]);
  if (columns.deformation >= 0) next.deformation += step.segment<2>(columns.deformation);
  for (std::size_t f = 0; f < next.frames.size(); ++f)
    next.frames[f] -= system.frame_own[f] + system.frame_gain[f] * step;
  return next;
}

}  // namespace cousin
