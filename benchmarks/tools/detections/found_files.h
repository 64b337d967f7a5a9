#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/score/average_precision.h"
#include "sim/dataset/mask_codes.h"

namespace cousin {

/// Something that a detector found in a picture.
struct FoundObject {
  int category = 0;  ///< as the file numbers its classes
  double score = 0;  ///< confidence, 0 to 1
  PictureBox box;
  PlacedMask mask;  ///< empty if only the box is known
};

/// Width and height of a picture, by the names that files may call it.
struct PictureSize {
  std::size_t place = 0;  ///< among the pictures that are scored
  int width_px = 0, height_px = 0;
  bool is_ambiguous = false;  ///< several pictures are called so
};
/// A number that is no text begins with "#"; if none is called so, its digits are looked for.
using PictureNames = std::map<std::string, PictureSize>;

/// A file of detections.
struct FoundFile {
  std::map<std::size_t, std::vector<FoundObject>> of_picture;  ///< by its place
  bool has_masks = false;                                      ///< any has one
  std::size_t count = 0;
};

/// COCO results, a list of {"image_id", "category_id", "bbox", "score", "segmentation"}, as
/// pycocotools and Ultralytics (predictions.json, whose image_id is the file's stem) write them. An
/// image_id is a name of `pictures`.
/// @throws std::runtime_error naming file, key, value and limit, or the picture that there is not
FoundFile read_coco_results(const std::filesystem::path& file, const PictureNames& pictures);

/// A folder of YOLO's text files, STEM.txt: a line an object, shares of width and height:
///   class x y w h confidence             a box
///   class x1 y1 x2 y2 x3 y3 ... confidence   a polygon
/// @throws std::runtime_error naming file and line; a file without confidences is one of labels
FoundFile read_yolo_results(const std::filesystem::path& folder, const PictureNames& pictures);

/// Whether the path is a folder of text files, or a JSON file. @throws std::runtime_error where it
/// is neither
FoundFile read_found(const std::filesystem::path& path, const PictureNames& pictures);

}  // namespace cousin
