#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/dataset/json_interop.h"
#include "sim/imaging/image_size.h"

namespace cousin {

/// Private to sim/dataset: keys of a frame of a transforms.json; those that it lacks are the
/// file's.
class FrameKeys {
 public:
  FrameKeys(const JsonNode& file, const JsonNode& frame) : file_(file), frame_(frame) {}
  const JsonNode& file() const { return file_; }
  const JsonNode& frame() const { return frame_; }
  bool has(std::string_view key) const { return frame_.has(key) || file_.has(key); }
  JsonNode at(std::string_view key) const { return frame_.has(key) ? frame_[key] : file_[key]; }
  double number_or(std::string_view key, double otherwise) const {
    return has(key) ? at(key).number() : otherwise;
  }

 private:
  JsonNode file_;
  JsonNode frame_;
};

/// False, 0, or a list of these.
bool is_false_or_zero(const JsonNode& node);

/// Whether `key` is one of a lens, so that a frame that has it has a lens of its own.
bool is_nerfstudio_lens_key(std::string_view key);

/// The lens that the keys say. A second focal length or angle of view that says something else than
/// the one that counts is added to `warnings` where other programs pass over it.
/// @param image    size of the frame's image, where the keys say none
/// @param context  "frame 3", for errors. @throws std::runtime_error naming file, key, value and
/// limit; so for keys of lenses that there is no model for.
Camera nerfstudio_lens(const FrameKeys& keys, const std::optional<ImageSize>& image,
                       const std::string& context, std::vector<std::string>& warnings);

}  // namespace cousin
