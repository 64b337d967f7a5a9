#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/tools/detections/found_files.h"

namespace cousin {

/// A specimen as a picture shows it.
struct TrueObject {
  int instance = 0;
  std::string name;      ///< "fruit 03"
  std::string category;  ///< as in the scene, or of the label asked for
  PictureBox box;        ///< of what is seen
  PlacedMask mask;       ///< of what is seen
  std::int64_t area_px = 0;
  double visible_fraction = 0;           ///< NaN: nobody knows
  std::map<std::string, double> traits;  ///< SI
  std::map<std::string, std::string> labels;
};

/// A picture that truth is of, with what it shows.
struct TruePicture {
  std::filesystem::path file;
  std::string name;        ///< "000001_000012": scene and frame, and another sensor than the first
  std::size_t sensor = 0;  ///< of the rig
  std::string light;       ///< as the scene's configuration names it; empty if it does not
  std::string plant;       ///< pictures of the same plants share it: intervals are over plants
  int width_px = 0, height_px = 0;
  std::vector<TrueObject> objects;
};

struct TruePictures {
  std::vector<TruePicture> pictures;
  /// The dataset's, in its order; a class of a file is a place, from 1.
  std::vector<std::string> categories;
  PictureNames names;     ///< that files of detections may use
  bool has_masks = true;  ///< of the objects
  /// Names of categories by the numbers that their source has for them; empty: places from 1.
  std::map<int, std::string> class_numbers;
};

/// Truth is the scenes', or the labels that somebody gave to photographs (photograph_labels.h). A
/// file of detections then calls a picture by COCO's number or its file's name, and pictures that
/// Roboflow made of one ("NAME.rf.HASH") count as of one plant.
/// @param label  of the specimens that is their category; empty: the scenes' own
/// @param progress  called with scenes done and in all
/// @throws std::runtime_error naming the scene and the truth that `render` must write
TruePictures read_true_pictures(const std::filesystem::path& dataset, const std::string& label = {},
                                const std::function<void(int, int)>& progress = {});

/// Leaves out the pictures of each sensor beside the first none of which the file names: no
/// detector looked at them. @return how many
std::size_t leave_out_sensors(TruePictures& truth, FoundFile& found);

}  // namespace cousin
