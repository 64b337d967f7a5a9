// A .cameramodel of mrcal: a Python dictionary of texts and lists of numbers
//   {'lensmodel': 'LENSMODEL_OPENCV8', 'intrinsics': [fx, fy, cx, cy, ...],
//    'extrinsics': [rx, ry, rz, tx, ty, tz], 'imagersize': [w, h]}
// with comments from "#" on. Other keys (valid_intrinsics_region, optimization_inputs) are not
// used.

#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// Values of the dictionary as they stand, without comments, by key.
class PythonDictionary {
 public:
  PythonDictionary(std::string_view text, const std::string& name) : text_(text), name_(&name) {
    if (!next_is('{')) fail("does not start with \"{\"");
    ++at_;
    while (!next_is('}')) {
      const std::string key = quoted();
      if (!next_is(':')) fail("the key \"" + cut_utf8(key, 60) + "\" has no \":\"");
      ++at_;
      if (!values_.emplace(key, value()).second) fail(cut_utf8(key, 60) + " occurs twice");
      if (next_is(',')) ++at_;
    }
  }

  const std::string& raw(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) fail("the key \"" + key + "\" is missing");
    return found->second;
  }
  std::string text(const std::string& key) const {
    const std::string& value = raw(key);
    if (value.size() < 2 || (value.front() != '\'' && value.front() != '"') ||
        value.back() != value.front())
      fail(key + " is not a text");
    return value.substr(1, value.size() - 2);
  }
  std::vector<double> numbers(const std::string& key) const {
    const std::string& value = raw(key);
    if (value.size() < 2 || value.front() != '[' || value.back() != ']')
      fail(key + " is not a list");
    std::vector<double> result;
    const char* at = value.data() + 1;
    const char* const end = value.data() + value.size() - 1;
    const auto skip = [&](std::string_view what) {
      while (at != end && what.find(*at) != std::string_view::npos) ++at;
    };
    for (skip(kBlanks); at != end; skip(kBlanks)) {
      if (*at == '+') ++at;
      double number = 0;
      const auto [stop, error] = std::from_chars(at, end, number);
      if (error != std::errc{} || !std::isfinite(number))
        fail(key + ": number " + std::to_string(result.size() + 1) + " is not a finite number");
      result.push_back(number);
      at = stop;
      skip(kBlanks);
      if (at != end && *at != ',') fail(key + " is not numbers separated by commas");
      if (at != end) ++at;
    }
    return result;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(*name_ + ": " + what);
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\n\v\f";

  /// Skips blanks and comments.
  bool next_is(char c) {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (kBlanks.find(text_[at_]) != std::string_view::npos) {
        ++at_;
      } else {
        return text_[at_] == c;
      }
    }
    fail("the dictionary does not end");
  }
  std::string quoted() {
    if (!next_is('\'') && !next_is('"')) fail("a key is not quoted");
    const std::size_t end = end_of_quote();
    const std::string key(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return key;
  }
  std::size_t end_of_quote() const {
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string_view::npos) fail("a text does not end");
    return end;
  }
  /// To the comma or brace that ends it, comments left out.
  std::string value() {
    std::string result;
    int depth = 0;
    while (!(depth == 0 && (next_is(',') || next_is('}')))) {
      next_is('\0');  // skips
      const char c = text_[at_];
      if (c == '\'' || c == '"') {
        const std::size_t end = end_of_quote();
        result += text_.substr(at_, end + 1 - at_);
        at_ = end + 1;
        continue;
      }
      if (c == '[' || c == '(' || c == '{') ++depth;
      if (c == ']' || c == ')' || c == '}') --depth;
      if (depth < 0) fail("a bracket is closed that was not opened");
      result += c;
      ++at_;
    }
    return result;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  const std::string* name_;
  std::map<std::string, std::string> values_;
};

/// The whole number after "key=" in a model's name.
int named_number(const PythonDictionary& file, const std::string& model, const std::string& key) {
  const std::size_t at = model.find(key + "=");
  int value = 0;
  if (at != std::string::npos) {
    const char* const begin = model.data() + at + key.size() + 1;
    const auto [end, error] = std::from_chars(begin, model.data() + model.size(), value);
    if (error == std::errc{} && value >= 1 && value <= 1024) return value;
  }
  file.fail("lensmodel = " + cut_utf8(model, 100) + ": " + key + " is not in [1, 1024]");
}

void set_lens(const PythonDictionary& file, const std::vector<double>& values, Camera& camera) {
  const std::string model = file.text("lensmodel");
  if (model == "LENSMODEL_PINHOLE") {
    camera.model = LensModel::pinhole;
  } else if (model == "LENSMODEL_OPENCV4" || model == "LENSMODEL_OPENCV5") {
    camera.model = LensModel::opencv5;
  } else if (model == "LENSMODEL_OPENCV8") {
    camera.model = LensModel::opencv8;
  } else if (model == "LENSMODEL_OPENCV12") {
    camera.model = LensModel::opencv12;
  } else if (model.starts_with("LENSMODEL_SPLINED_STEREOGRAPHIC_")) {
    camera.model = LensModel::splined_stereographic;
    camera.spline.order = named_number(file, model, "order");
    camera.spline.columns = named_number(file, model, "Nx");
    camera.spline.rows = named_number(file, model, "Ny");
    camera.spline.fov_x_rad = named_number(file, model, "fov_x_deg") * std::numbers::pi / 180;
    camera.spline.delta_u = values;
    return;
  } else {
    file.fail("lensmodel = " + cut_utf8(model, 100) +
              " is not one of LENSMODEL_PINHOLE, LENSMODEL_OPENCV4, LENSMODEL_OPENCV5, "
              "LENSMODEL_OPENCV8, LENSMODEL_OPENCV12, LENSMODEL_SPLINED_STEREOGRAPHIC_...");
  }
  const auto count = model == "LENSMODEL_OPENCV4"
                         ? std::size_t{4}
                         : static_cast<std::size_t>(distortion_count(camera.model));
  if (values.size() != count) {
    file.fail("intrinsics: " + std::to_string(4 + values.size()) + " numbers; " + model + " has " +
              std::to_string(4 + count));
  }
  std::copy(values.begin(), values.end(), camera.distortion.begin());
}

}  // namespace

CalibratedCamera camera_from_mrcal(std::string_view text, const std::string& name) {
  const PythonDictionary file(text, name);
  CalibratedCamera result;
  Camera& camera = result.camera;
  const std::vector<double> intrinsics = file.numbers("intrinsics");
  const std::vector<double> size = file.numbers("imagersize");
  const std::vector<double> rt = file.numbers("extrinsics");
  if (intrinsics.size() < 4) file.fail("intrinsics has fewer than 4 numbers");
  if (rt.size() != 6) file.fail("extrinsics does not have 6 numbers");
  if (size.size() != 2) file.fail("imagersize does not have 2 numbers");
  for (const double side : size) {
    if (!(side >= 1 && side <= 65535) || side != std::floor(side))
      file.fail("imagersize is not whole numbers in [1, 65535]");
  }
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  camera.fx_px = intrinsics[0];
  camera.fy_px = intrinsics[1];
  camera.cx_px = intrinsics[2];
  camera.cy_px = intrinsics[3];
  set_lens(file, {intrinsics.begin() + 4, intrinsics.end()}, camera);
  const Eigen::Vector3d r(rt[0], rt[1], rt[2]);
  if (!(r.norm() < 1e6)) file.fail("extrinsics: a rotation of 1e6 rad and more");
  if (r.norm() > 0)
    result.camera_from_reference.rotation = Eigen::AngleAxisd(r.norm(), r.normalized());
  result.camera_from_reference.translation_m = {rt[3], rt[4], rt[5]};
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    file.fail(error.what());
  }
  return result;
}

}  // namespace cousin
