#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/boards/board_model.h"
#include "scenes/row/scene_row.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/calibration_target.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin {

/// Tables of boards.toml that are not the board's own; every value is given there.
struct BoardSetting {
  struct Poses {
    double tilt_min_rad = 0, tilt_max_rad = 0, roll_max_rad = 0, fill_min = 0, fill_max = 0;
  } poses;
  struct Video {
    double rate_hz = 0, pose_step_s = 0;
  } video;
  struct Place {
    double table_m = 0, stand_m = 0, wall_m = 0;
    std::vector<double> table_albedo, table_dark, wall_albedo, wall_dark, floor_albedo;
  } place;
  struct LightNumbers {
    double soft_room = 0, soft_panel = 0, hard_room = 0, hard_lamp = 0;
    double sun_scale = 0, sun_elevation_rad = 0, sun_turbidity = 0;
  } light;
};

struct BoardsSceneConfig {
  std::string board = "charuco_a4";  ///< of board_names(); setting it sets `target`
  CalibrationTarget target;
  BoardFlaws flaws;
  BoardBody body;
  /// table: the board lies and the camera goes around it; stand: upright, likewise; hand: somebody
  /// holds it before a camera that stays.
  std::string place = "stand";
  std::string light = "soft";  ///< soft, hard or sun
  int views = 24;
  /// planned: places, tilts and sizes spread evenly; random; video: the camera goes smoothly past
  /// planned ones, picture by picture, and moves on while rows are read.
  std::string plan = "planned";
  double coverage = 1;  ///< share of the picture that the board's middle goes to; 0 = its middle
  double outside = 0;   ///< largest share of the print that may lie beyond the picture's border
  std::string rig = "phone_video_720p";
  BoardSetting setting;
  /// Half the picture's width and height at depth 1, of the rig that takes it; not a key.
  Eigen::Vector2d half_view{0.55, 0.31};
  Pose eye_from_rig;     ///< of the camera that views are planned for; not a key
  double readout_s = 0;  ///< of the rig, the longest; not a key

  BoardsSceneConfig();  ///< as boards.toml says
};
Fields fields(BoardsSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const BoardsSceneConfig& config);

/// Names of presets.toml.
std::vector<std::string> board_names();
/// @throws std::invalid_argument listing the names that exist.
CalibrationTarget board_preset(const std::string& name);

/// A board, what carries it and a room. The board is the specimen "board": its keypoints are the
/// target's points where they really are; Scene::board names the target as designed, which is all
/// that perception gets. With place = hand board and grip move, at rest about each view's time.
Scene build_boards_scene(const BoardsSceneConfig& config, Rng rng);

/// Where the board is seen from in each planned or random view: camera_from_board.
/// @param is_free  whether a camera can be there; a tilt is lessened until it says so
std::vector<Pose> board_poses(const BoardsSceneConfig& config,
                              const std::function<bool(const Pose& camera_from_board)>& is_free,
                              Rng rng);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const BoardsSceneConfig& config, const SceneBuild& which);
std::vector<std::string> specimen_categories(const BoardsSceneConfig& config);
void see(BoardsSceneConfig& config, const RigSight& sight);
PhysicsUse physics_of(const BoardsSceneConfig& config);
const SceneRow& boards_row();
const SceneRow& row_of(const BoardsSceneConfig& config);

}  // namespace cousin
