#pragma once

#include <array>
#include <vector>

#include "benchmarks/scenes/scene_table.h"

namespace cousin {

/// What `cousin scenes` says of a scene, whether it is built in or not.
struct PlantSceneText {
  const char* name;
  const char* help;
};
inline constexpr auto kPlantScenes = std::to_array<PlantSceneText>({
    {"seedlings",
     "watermelon seedlings of day 0 to 12 in a tray of 50 cells, hand-held views, three lights "
     "(D1 sun, D2 overcast, D3 violet LED)"},
    {"maize",
     "maize from V3 to VT, one plant or rows, with a keypoint at every node, seen by a ZED stereo "
     "camera"},
    {"apples",
     "a Fuji spindle tree in its row, seen from 0.1 to 1 m of a fruit; four lights (front, back, "
     "side, shade); occlusion on demand"},
    {"boards",
     "calibration boards (chessboards, ChArUco, AprilGrid, circles) with warp, stretch and gloss, "
     "on "
     "a table, on a stand or held by hand"},
    {"specimen", "your own mesh on a table: --set mesh=FILE (PLY, OBJ, STL, glTF) --set unit=mm"},
    {"strawberries",
     "strawberries of three varieties on a raised bed, 1 to 10 fruits of all maturities in view, "
     "four lights (morning, overcast, noon, lamp), seen by a D457"},
});

/// One row for each of kPlantScenes. In the part `scenes` they are `plant_scenes.cpp`'s; in the
/// first part `benchmarks/app/plant_scenes_off.cpp`'s, which say how to build the other.
std::vector<SceneEntry> plant_scenes();

}  // namespace cousin
