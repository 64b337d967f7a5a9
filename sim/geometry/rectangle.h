#pragma once

#include <Eigen/Core>
#include <vector>

namespace cousin::geometry {

/// Private to sim/geometry. Direction of one side of the rectangle of least area around points in a
/// plane: it is flush with an edge of their hull [Freeman & Shapira 1975]. (1, 0) for a single
/// point; the line for points on a line.
Eigen::Vector2d smallest_rectangle_side(std::vector<Eigen::Vector2d> points);

}  // namespace cousin::geometry
