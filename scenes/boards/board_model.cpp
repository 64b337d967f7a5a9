#include "scenes/boards/board_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scenes/boards/print_grid.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

enum Part : std::uint16_t { kPaper, kInk, kPlate };

/// Deflection at a point of the plane and its slope.
struct Deflection {
  double z_m = 0;
  Vector2d slope = Vector2d::Zero();
};

Deflection deflection(const CalibrationTarget& target, const BoardFlaws& f, const Vector2d& at_m) {
  const Vector2d half = 0.5 * print_size_m(target);
  const Vector2d u = at_m.cwiseQuotient(half);
  const double k = 2 * std::numbers::pi / f.wave_length_m;
  const Vector2d along(std::cos(f.wave_turn_rad), std::sin(f.wave_turn_rad));
  const double phase = k * along.dot(at_m);
  Deflection d;
  d.z_m = f.warp_x_m * (1 - u.x() * u.x()) + f.warp_y_m * (1 - u.y() * u.y()) +
          f.wave_m * std::sin(phase);
  d.slope = Vector2d(-2 * f.warp_x_m * u.x() / half.x(), -2 * f.warp_y_m * u.y() / half.y()) +
            f.wave_m * k * std::cos(phase) * along;
  return d;
}

Vector2d printed(const BoardFlaws& f, const Vector2d& designed_m) {
  return {f.stretch_x * designed_m.x() + f.shear * designed_m.y(), f.stretch_y * designed_m.y()};
}

class Builder {
 public:
  explicit Builder(ObjectModel& model) : model_(model) {}

  std::uint32_t vertex(const Vector3d& at_m, const Vector3d& normal) {
    model_.mesh.vertices_m.push_back(at_m);
    model_.vertex_normals.push_back(normal.cast<float>());
    return static_cast<std::uint32_t>(model_.mesh.vertices_m.size() - 1);
  }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, Part part) {
    model_.mesh.triangles.push_back({a, b, c});
    model_.mesh.triangles.push_back({a, c, d});
    model_.triangle_part.insert(model_.triangle_part.end(), 2, part);
  }

 private:
  ObjectModel& model_;
};

/// Vertices of the plate's outline, counter-clockwise from the lower left.
std::vector<std::size_t> outline(const PrintGrid& grid) {
  std::vector<std::size_t> loop;
  for (int i = 0; i < grid.columns; ++i) loop.push_back(grid.vertex(i, 0));
  for (int j = 0; j < grid.rows; ++j) loop.push_back(grid.vertex(grid.columns, j));
  for (int i = grid.columns; i > 0; --i) loop.push_back(grid.vertex(i, grid.rows));
  for (int j = grid.rows; j > 0; --j) loop.push_back(grid.vertex(0, j));
  return loop;
}

}  // namespace

Fields fields(BoardFlaws& f) {
  constexpr double kMost_m = 0.1;
  return {
      {"warp_x_m", &f.warp_x_m, "deflection of the middle over the left and right edge", -kMost_m,
       kMost_m},
      {"warp_y_m", &f.warp_y_m, "deflection of the middle over the lower and upper edge", -kMost_m,
       kMost_m},
      {"wave_m", &f.wave_m, "amplitude of a wave on top of it", 0, kMost_m},
      {"wave_length_m", &f.wave_length_m, "its length", 0.005, 100},
      {"wave_turn_rad", &f.wave_turn_rad, "its direction from x", -7, 7},
      {"stretch_x", &f.stretch_x, "printed over designed width", 0.8, 1.25},
      {"stretch_y", &f.stretch_y, "printed over designed height", 0.8, 1.25},
      {"shear", &f.shear, "x moves by this times y", -0.2, 0.2},
  };
}

Fields fields(BoardBody& b) {
  return {
      {"margin_m", &b.margin_m, "white about the print", 0, 1},
      {"thickness_m", &b.thickness_m, "of the plate", 1e-4, 0.1},
      {"detail_m", &b.detail_m, "longest edge of the face's triangles", 2e-4, 1},
      {"paper_albedo", &b.paper_albedo, "white of the print", 0, 1},
      {"ink_albedo", &b.ink_albedo, "black of the print", 0, 1},
      {"plate_albedo", &b.plate_albedo, "back and edges", 0, 1},
      {"paper_infrared", &b.paper_infrared, "paper's albedo at 850 nm", 0, 1},
      {"ink_infrared", &b.ink_infrared, "the black's albedo at 850 nm", 0, 1},
      {"roughness", &b.roughness, "of the paper's coat: 0.05 a mirror, 1 matt", 0.05, 1},
      {"ink_roughness", &b.ink_roughness, "of the coat over the ink", 0.05, 1},
      {"ior", &b.ior, "of the coat; 1 = none", 1, 2.5},
  };
}

Vector3d on_board_m(const CalibrationTarget& target, const BoardFlaws& flaws,
                    const Vector2d& designed_m) {
  const Vector2d at = printed(flaws, designed_m);
  return {at.x(), at.y(), deflection(target, flaws, at).z_m};
}

Vector3d board_normal(const CalibrationTarget& target, const BoardFlaws& flaws,
                      const Vector2d& designed_m) {
  const Vector2d slope = deflection(target, flaws, printed(flaws, designed_m)).slope;
  return Vector3d(-slope.x(), -slope.y(), 1).normalized();
}

ObjectModel board_model(const CalibrationTarget& target, const BoardFlaws& flaws,
                        const BoardBody& body) {
  const PrintGrid grid = print_grid(target, body.margin_m, body.detail_m);
  ObjectModel model;
  model.name = "board";
  model.part_names = {"paper", "ink", "plate"};
  Builder builder(model);
  std::vector<Vector3d> face, normals;
  for (const Vector2d& at_m : grid.at_m) {
    face.push_back(on_board_m(target, flaws, at_m));
    normals.push_back(board_normal(target, flaws, at_m));
    builder.vertex(face.back(), normals.back());
  }
  const auto corner = [&](int i, int j) { return static_cast<std::uint32_t>(grid.vertex(i, j)); };
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      builder.quad(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1),
                   grid.has_ink[static_cast<std::size_t>(j * grid.columns + i)] ? kInk : kPaper);
    }
  }
  // The back is the face moved down.
  const Vector3d down(0, 0, -body.thickness_m);
  const auto back = static_cast<std::uint32_t>(face.size());
  for (std::size_t i = 0; i < face.size(); ++i) builder.vertex(face[i] + down, -normals[i]);
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      builder.quad(back + corner(i, j), back + corner(i, j + 1), back + corner(i + 1, j + 1),
                   back + corner(i + 1, j), kPlate);
    }
  }
  const std::vector<std::size_t> loop = outline(grid);
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Vector3d &a = face[loop[k]], &b = face[loop[(k + 1) % loop.size()]];
    const Vector3d out = (b - a).cross(Vector3d::UnitZ()).normalized();
    builder.quad(builder.vertex(a + down, out), builder.vertex(b + down, out),
                 builder.vertex(b, out), builder.vertex(a, out), kPlate);
  }
  const bool has_discs =
      target.kind == TargetKind::circles || target.kind == TargetKind::asymmetric_circles;
  for (const TargetPoint& point : target_points(target)) {
    model.keypoints.push_back({(has_discs ? "disc " : "corner ") + std::to_string(point.id),
                               on_board_m(target, flaws, point.at_m)});
  }
  return model;
}

std::vector<Material> board_materials(const BoardBody& body) {
  Material paper;
  paper.name = "paper";
  paper.albedo = to_rgb(color_vector(body.paper_albedo));
  paper.roughness = body.roughness;
  paper.ior = body.ior;
  paper.infrared_albedo = static_cast<float>(body.paper_infrared);
  Material ink = paper;
  ink.name = "ink";
  ink.albedo = to_rgb(color_vector(body.ink_albedo));
  ink.roughness = body.ink_roughness;
  ink.infrared_albedo = static_cast<float>(body.ink_infrared);
  Material plate = paper;
  plate.name = "plate";
  plate.albedo = to_rgb(color_vector(body.plate_albedo));
  plate.infrared_albedo = plate.albedo.r;  // metal: the same
  return {paper, ink, plate};
}

std::vector<TrueTrait> board_traits(const CalibrationTarget& target, const BoardFlaws& flaws,
                                    const ObjectModel& model) {
  const Vector2d size = print_size_m(target);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Keypoint& keypoint : model.keypoints) {
    low = std::min(low, keypoint.in_object_m.z());
    high = std::max(high, keypoint.in_object_m.z());
  }
  return {{"points", "1", static_cast<double>(model.keypoints.size())},
          {"width", "m", flaws.stretch_x * size.x()},
          {"height", "m", flaws.stretch_y * size.y()},
          {"flatness", "m", high - low}};
}

}  // namespace cousin
