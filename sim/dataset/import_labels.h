#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/dataset/photograph_labels.h"
#include "sim/types/capture.h"

namespace cousin {

/// Somebody's labelled photographs: a frame each, in the order of their names, of any sizes. The
/// lens is not known: its focal length is 0.85 of the larger side.
struct LabelledPhotographs {
  Capture capture;
  PhotographLabels labels;
  std::vector<std::string> categories;  ///< id 1 first
};

/// COCO's annotations, as an annotation file or the folder that holds one alone; the images lie
/// beside it, or in images/ there, or in images/ beside its folder. Boxes, polygons and run lengths
/// are read. Regions that mark a crowd are left out and counted in the warnings, as is what lies
/// outside the image. Categories keep their order; their numbers become 1, 2, ...
/// @throws std::runtime_error naming file, key, value and limit, or images that are not there
LabelledPhotographs import_coco(const std::filesystem::path& source);

/// A set as Ultralytics' YOLO reads it: data.yaml (or the folder that holds it), whose train, val
/// and test are folders of images, with those below them, or a folder with images/ and labels/. A
/// label file has a line an object, "class x y w h" or "class x1 y1 x2 y2 ...", shares of the
/// image; an image without one shows nothing. Folders and label files must lie below the folder of
/// data.yaml, which is taken where its `path` is another machine's. What lies outside the image is
/// cut off, or left out and counted in the warnings.
/// @throws std::runtime_error naming file, line, value and limit
LabelledPhotographs import_yolo(const std::filesystem::path& source);

}  // namespace cousin
