#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/calibration_target.h"

namespace cousin {

/// How a board differs from its design.
struct BoardFlaws {
  /// Deflection out of the plane, mrcal's model: kx (1 - x^2) + ky (1 - y^2), x and y from -1 to 1
  /// over the print [mrcal, "Flexing of the calibration object"].
  double warp_x_m = 0, warp_y_m = 0;
  double wave_m = 0;                    ///< amplitude of a wave on top of it
  double wave_length_m = 0.15;          ///< its length
  double wave_turn_rad = 0.6;           ///< direction of its crests' normal from x
  double stretch_x = 1, stretch_y = 1;  ///< printed over designed lengths
  double shear = 0;                     ///< x moves by this times y
};
Fields fields(BoardFlaws& flaws);

/// The plate and its surface.
struct BoardBody {
  double margin_m = 0.01;  ///< white about the print
  double thickness_m = 0.004;
  double detail_m = 0.005;  ///< longest edge of a triangle of the face
  std::vector<double> paper_albedo, ink_albedo, plate_albedo;
  double paper_infrared = 0, ink_infrared = 0;  ///< at 850 nm
  double roughness = 0.5, ior = 1.5;            ///< of the paper's coat
  double ink_roughness = 0.5;                   ///< of the same coat over the ink
};
Fields fields(BoardBody& body);

/// Where a designed point of the print lies: stretched in the plane, then deflected.
Eigen::Vector3d on_board_m(const CalibrationTarget& target, const BoardFlaws& flaws,
                           const Eigen::Vector2d& designed_m);
/// Unit, out of the face there.
Eigen::Vector3d board_normal(const CalibrationTarget& target, const BoardFlaws& flaws,
                             const Eigen::Vector2d& designed_m);

/// Parts of the model, in this order: paper, ink, plate. Keypoints: every point of the target where
/// it really is, "corner ID" or "disc ID". Frame: the target's.
ObjectModel board_model(const CalibrationTarget& target, const BoardFlaws& flaws,
                        const BoardBody& body);
/// One for each part.
std::vector<Material> board_materials(const BoardBody& body);

/// points (1), width, height (m, of the print as it is), flatness (m, highest less lowest point).
std::vector<TrueTrait> board_traits(const CalibrationTarget& target, const BoardFlaws& flaws,
                                    const ObjectModel& model);

}  // namespace cousin
