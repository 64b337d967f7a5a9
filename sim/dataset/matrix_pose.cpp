#include "sim/dataset/matrix_pose.h"

#include <Eigen/SVD>
#include <stdexcept>

#include "sim/dataset/import_images.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

constexpr double kMostSkew = 1e-3;

bool is_no_number(const std::string& word) {
  const std::string_view bare = std::string_view(word).substr(word.find_first_not_of("+-") == 1);
  return bare == "inf" || bare == "nan" || bare == "Inf" || bare == "NaN" || bare == "INF" ||
         bare == "NAN";
}

}  // namespace

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix) {
  const double skew =
      (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(skew <= kMostSkew))
    throw std::invalid_argument("the 3 x 3 block is not a rotation: an entry of R R^T differs by " +
                                exact_text(skew) + " from that of the identity; the limit is 1e-3");
  if (matrix.determinant() < 0)
    throw std::invalid_argument("the 3 x 3 block mirrors: its determinant is " +
                                exact_text(matrix.determinant()) + ", not 1");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose()))
      .normalized();
}

Pose pose_of_matrix(const Eigen::Matrix4d& a_from_b) {
  if (!((a_from_b.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() <= 1e-9))
    throw std::invalid_argument("its last row is not 0 0 0 1");
  if (!(a_from_b.topRightCorner<3, 1>().cwiseAbs().maxCoeff() <= kMostCoordinate))
    throw std::invalid_argument("its place is beyond 1e9");
  return {nearest_rotation(a_from_b.topLeftCorner<3, 3>()), a_from_b.topRightCorner<3, 1>()};
}

std::optional<Pose> pose_of_text(std::string_view text, const std::string& name) {
  const std::vector<TextLine> lines = records(text, name);
  if (lines.size() != 4)
    throw std::runtime_error(name + ": has " + std::to_string(lines.size()) + " rows, not 4");
  Eigen::Matrix4d matrix;
  bool is_finite = true;
  for (std::size_t row = 0; row < 4; ++row) {
    if (lines[row].size() != 4)
      lines[row].fail("has " + std::to_string(lines[row].size()) + " words, not 4");
    for (std::size_t column = 0; column < 4; ++column) {
      const bool is_lost = is_no_number(lines[row].text(column));
      is_finite = is_finite && !is_lost;
      matrix(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          is_lost ? 0 : lines[row].number(column);
    }
  }
  if (!is_finite) return std::nullopt;
  try {
    return pose_of_matrix(matrix);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(name + ": " + error.what());
  }
}

}  // namespace cousin
