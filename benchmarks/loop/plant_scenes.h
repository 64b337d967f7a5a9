#pragma once

#include <array>
#include <vector>

#include "benchmarks/loop/scene_table.h"

namespace cousin {

/// What `cousin scenes` says of a scene, whether it is built in or not.
struct PlantSceneText {
  const char* name;
  const char* help;
  bool needs_physics = false;
  bool has_points = false;  ///< as SceneEntry
};
inline constexpr auto kPlantScenes = std::to_array<PlantSceneText>({
    {.name = "seedlings",
     .help = "watermelon seedlings of day 0 to 12 in a tray of 50 cells, hand-held views, three "
             "lights (D1 sun, D2 overcast, D3 violet LED)"},
    {.name = "maize",
     .help = "maize from V3 to VT, one plant or rows, with a keypoint at every node, seen by a ZED "
             "stereo camera"},
    {.name = "apples",
     .help = "a Fuji spindle tree in its row, seen from 0.1 to 1 m of a fruit; four lights (front, "
             "back, side, shade); occlusion on demand"},
    {.name = "boards",
     .help = "calibration boards (chessboards, ChArUco, AprilGrid, circles) with warp, stretch and "
             "gloss, on a table, on a stand or held by hand",
     .has_points = true},
    {.name = "specimen",
     .help = "your own mesh on a table: --set mesh=FILE (PLY, OBJ, STL, glTF) --set unit=mm"},
    {.name = "strawberries",
     .help = "strawberries of three varieties on a raised bed, 1 to 10 fruits of all maturities in "
             "view, four lights (morning, overcast, noon, lamp), seen by a D457",
     .needs_physics = true},
});

/// One row for each of kPlantScenes. In the part `scenes` they are `plant_scenes.cpp`'s; in the
/// first part `benchmarks/app/plant_scenes_off.cpp`'s, which say how to build the other.
std::vector<SceneEntry> plant_scenes();

}  // namespace cousin
