#include "sim/dataset/json_interop.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// A value for a message: short, and never a whole tree.
std::string describe(const nlohmann::json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  std::string text = value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

std::string limits_text(double min, double max) {
  return "is outside [" + Json(min).dump() + ", " + Json(max).dump() + "]";
}

bool is_scalar_array(const Json& value) {
  return value.is_array() &&
         std::none_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); });
}

void require_utf8(const std::string& text, const std::string& pointer) {
  if (is_utf8(text)) return;
  throw std::runtime_error("JSON " + readable_utf8(pointer) + ": \"" +
                           readable_utf8(cut_utf8(text, 200)) + "\" is not UTF-8 text");
}

bool is_printable(const Json& value) {
  if (value.is_number_float()) return std::isfinite(value.get<double>());
  return !value.is_string() || is_utf8(value.get_ref<const std::string&>());
}

[[noreturn]] void refuse_value(const Json& value, const std::string& pointer) {
  if (value.is_string()) require_utf8(value.get_ref<const std::string&>(), pointer);
  throw std::invalid_argument("JSON " + pointer + ": " + std::to_string(value.get<double>()) +
                              " is not finite");
}

void print_line(const Json& value, const std::string& pointer, std::string& out) {
  if (!value.is_array()) {
    if (!is_printable(value)) refuse_value(value, pointer);
    out += value.dump();
    return;
  }
  out += '[';
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (i > 0) out += ", ";
    if (!is_printable(value[i])) refuse_value(value[i], pointer + "/" + std::to_string(i));
    out += value[i].dump();
  }
  out += ']';
}

void print(const Json& value, int indent, const std::string& pointer, std::string& out) {
  if (!value.is_structured() || value.empty() || is_scalar_array(value)) {
    if (value.is_object()) {
      out += "{}";
    } else {
      print_line(value, pointer, out);
    }
    return;
  }
  const std::string margin(static_cast<std::size_t>(indent) + 1, ' ');
  out += value.is_object() ? '{' : '[';
  bool first = true;
  std::size_t index = 0;
  for (auto item = value.begin(); item != value.end(); ++item, ++index) {
    out += first ? "\n" : ",\n";
    first = false;
    out += margin;
    if (value.is_object()) {
      require_utf8(item.key(), pointer);
      out += Json(item.key()).dump() + ": ";
    }
    print(*item, indent + 1,
          pointer + "/" + (value.is_object() ? item.key() : std::to_string(index)), out);
  }
  out += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
  out += value.is_object() ? '}' : ']';
}

}  // namespace

// ---- JsonNode -----------------------------------------------------------------------------------

void JsonNode::fail(const std::string& what) const {
  throw std::runtime_error(*file_ + ": " + (pointer_.empty() ? "/" : pointer_) + " = " +
                           describe(*value_) + " " + what);
}

void JsonNode::expect_keys(std::initializer_list<std::string_view> required,
                           std::initializer_list<std::string_view> optional) const {
  if (!value_->is_object()) fail("is not an object");
  for (const std::string_view key : required) (*this)[key];
  for (const auto& item : value_->items()) {
    const auto is_key = [&](std::string_view key) { return key == item.key(); };
    if (std::none_of(required.begin(), required.end(), is_key) &&
        std::none_of(optional.begin(), optional.end(), is_key)) {
      std::string names;
      for (const std::string_view key : required)
        names += (names.empty() ? "" : ", ") + std::string(key);
      for (const std::string_view key : optional)
        names += (names.empty() ? "" : ", ") + std::string(key);
      fail("has the unknown key " + describe(item.key()) + "; keys are " + names);
    }
  }
}

bool JsonNode::has(std::string_view key) const {
  return value_->is_object() && value_->find(std::string(key)) != value_->end();
}

JsonNode JsonNode::operator[](std::string_view key) const {
  if (!value_->is_object()) fail("is not an object");
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) fail("lacks the key \"" + std::string(key) + "\"");
  return {*found, *file_, pointer_ + "/" + std::string(key)};
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members(std::size_t max_count) const {
  if (!value_->is_object()) fail("is not an object");
  if (value_->size() > max_count) fail("has more than " + std::to_string(max_count) + " keys");
  std::vector<std::pair<std::string, JsonNode>> result;
  for (const auto& item : value_->items()) {
    result.emplace_back(item.key(), JsonNode(item.value(), *file_, pointer_ + "/" + item.key()));
  }
  return result;
}

std::size_t JsonNode::size(std::size_t max_count) const {
  if (!value_->is_array()) fail("is not an array");
  if (value_->size() > max_count) fail("is longer than " + std::to_string(max_count));
  return value_->size();
}

JsonNode JsonNode::operator[](std::size_t index) const {
  return {value_->at(index), *file_, pointer_ + "/" + std::to_string(index)};
}

std::vector<JsonNode> JsonNode::elements(std::size_t max_count) const {
  std::vector<JsonNode> result;
  const std::size_t count = size(max_count);
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back((*this)[i]);
  return result;
}

double JsonNode::number(double min, double max) const {
  if (!value_->is_number()) fail("is not a number");
  const double value = value_->get<double>();
  if (!std::isfinite(value)) fail("is not finite");
  if (value < min || value > max) fail(limits_text(min, max));
  return value;
}

double JsonNode::number_or_nan() const {
  return value_->is_null() ? std::numeric_limits<double>::quiet_NaN() : number();
}

std::int64_t JsonNode::integer(std::int64_t min, std::int64_t max) const {
  if (!value_->is_number_integer()) fail("is not an integer");
  const bool too_large =
      value_->is_number_unsigned() && value_->get<std::uint64_t>() > (std::uint64_t{1} << 62);
  const std::int64_t value =
      too_large ? std::numeric_limits<std::int64_t>::max() : value_->get<std::int64_t>();
  if (too_large || value < min || value > max) {
    fail("is outside [" + std::to_string(min) + ", " + std::to_string(max) + "]");
  }
  return value;
}

std::uint64_t JsonNode::unsigned_integer() const {
  if (!value_->is_number_unsigned()) fail("is not an integer >= 0");
  return value_->get<std::uint64_t>();
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) fail("is neither true nor false");
  return value_->get<bool>();
}

std::string JsonNode::text(std::size_t max_chars) const {
  if (!value_->is_string()) fail("is not a text");
  const auto& value = value_->get_ref<const std::string&>();
  if (value.size() > max_chars) fail("is longer than " + std::to_string(max_chars) + " characters");
  return value;
}

std::vector<double> JsonNode::numbers(std::size_t min_count, std::size_t max_count) const {
  if (!value_->is_array()) fail("is not an array");
  if (value_->size() < min_count || value_->size() > max_count) {
    fail(min_count == max_count ? "does not have " + std::to_string(min_count) + " numbers"
                                : "does not have " + std::to_string(min_count) + " to " +
                                      std::to_string(max_count) + " numbers");
  }
  std::vector<double> result;
  result.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    const nlohmann::json& element = (*value_)[i];
    const double value =
        element.is_number() ? element.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(value)) (*this)[i].fail("is not a finite number");
    result.push_back(value);
  }
  return result;
}

// ---- documents ----------------------------------------------------------------------------------

namespace {

using Event = nlohmann::json::parse_event_t;

/// The first key that stands twice in one object.
std::string repeated_key(std::string_view text) {
  std::vector<std::set<std::string>> open;
  std::string repeated;
  const nlohmann::json::parser_callback_t note = [&](int, Event event, nlohmann::json& parsed) {
    if (event == Event::object_start) open.emplace_back();
    if (event == Event::object_end) open.pop_back();
    if (event == Event::key && !open.back().insert(parsed.get<std::string>()).second &&
        repeated.empty())
      repeated = parsed.get<std::string>();
    return true;
  };
  return nlohmann::json::parse(text, note).is_discarded() ? "" : repeated;
}

/// Parses and counts: what is made of the text fits into memory, no key stands twice.
nlohmann::json parse_counted(std::string_view text, const std::string& name) {
  // What the library takes: a value in an array that grew by doubling, a list, a key in a tree.
  constexpr std::uint64_t kValueBytes = 32, kListBytes = 80, kKeyBytes = 96;
  std::uint64_t bytes = 0;
  std::vector<std::size_t> keys;  // of each object that is open
  bool is_repeated = false;
  const nlohmann::json::parser_callback_t count = [&](int, Event event, nlohmann::json& parsed) {
    switch (event) {
      case Event::object_start:
        keys.push_back(0);
        bytes += kListBytes;
        break;
      case Event::array_start:
        bytes += kListBytes;
        break;
      case Event::key:
        ++keys.back();
        bytes += kKeyBytes + parsed.get_ref<const std::string&>().size();
        break;
      case Event::value:
        bytes += kValueBytes;
        if (parsed.is_string()) bytes += parsed.get_ref<const std::string&>().size();
        break;
      case Event::object_end:
        is_repeated = is_repeated || parsed.size() != keys.back();
        keys.pop_back();
        break;
      case Event::array_end:
        break;
    }
    check_memory(name, bytes, "its JSON");
    return true;
  };
  nlohmann::json value = nlohmann::json::parse(text, count);
  if (is_repeated)
    throw std::runtime_error(name + ": the key \"" + cut_utf8(repeated_key(text), 60) +
                             "\" stands twice in one object");
  return value;
}

}  // namespace

JsonDocument::JsonDocument(std::string_view text, std::string name) : name_(std::move(name)) {
  try {
    value_ = parse_counted(text, name_);
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(name_ + ": not JSON: " + error.what());
  }
}

JsonDocument JsonDocument::read(const std::filesystem::path& file) {
  constexpr std::size_t kLimitBytes = std::size_t{1} << 29;
  return {read_file(file, kLimitBytes), file.string()};
}

std::string to_text(const Json& value) {
  std::string out;
  print(value, 0, "", out);
  out += '\n';
  return out;
}

Json nan_to_null(double value) { return std::isnan(value) ? Json(nullptr) : Json(value); }

// ---- shared values ------------------------------------------------------------------------------

Json to_json(const Camera& camera) {
  Json distortion = Json::array();
  for (int i = 0; i < distortion_count(camera.model); ++i) {
    distortion.push_back(camera.distortion.at(static_cast<std::size_t>(i)));
  }
  Json result = {{"model", to_string(camera.model)},
                 {"width_px", camera.width_px},
                 {"height_px", camera.height_px},
                 {"fx_px", camera.fx_px},
                 {"fy_px", camera.fy_px},
                 {"cx_px", camera.cx_px},
                 {"cy_px", camera.cy_px},
                 {"distortion", distortion}};
  if (camera.model == LensModel::splined_stereographic) {
    const SplineLens& spline = camera.spline;
    result["spline"] = {{"order", spline.order},
                        {"columns", spline.columns},
                        {"rows", spline.rows},
                        {"fov_x_rad", spline.fov_x_rad},
                        {"delta_u", spline.delta_u}};
  }
  return result;
}

namespace {

/// Its numbers are bounded here so that a hostile file asks for no memory; validate() does the
/// rest.
SplineLens read_spline(const JsonNode& node) {
  constexpr std::int64_t kMostAside = 1024;
  constexpr std::size_t kMostNumbers = 2 * 16384;
  node.expect_keys({"order", "columns", "rows", "fov_x_rad", "delta_u"});
  SplineLens spline;
  spline.order = static_cast<int>(node["order"].integer(2, 3));
  spline.columns = static_cast<int>(node["columns"].integer(1, kMostAside));
  spline.rows = static_cast<int>(node["rows"].integer(1, kMostAside));
  spline.fov_x_rad = node["fov_x_rad"].number();
  spline.delta_u = node["delta_u"].numbers(0, kMostNumbers);
  return spline;
}

}  // namespace

Camera read_camera(const JsonNode& node, const std::string& context) {
  node.expect_keys(
      {"model", "width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "distortion"},
      {"spline"});
  Camera camera;
  try {
    camera.model = lens_model_from_string(node["model"].text(64));
  } catch (const std::invalid_argument& error) {
    node["model"].fail(std::string(error.what()) + " (" + context + ")");
  }
  camera.width_px = static_cast<int>(node["width_px"].integer(1, 65535));
  camera.height_px = static_cast<int>(node["height_px"].integer(1, 65535));
  camera.fx_px = node["fx_px"].number();
  camera.fy_px = node["fy_px"].number();
  camera.cx_px = node["cx_px"].number();
  camera.cy_px = node["cy_px"].number();
  const auto count = static_cast<std::size_t>(distortion_count(camera.model));
  const std::vector<double> distortion = node["distortion"].numbers(count, count);
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  if (camera.model == LensModel::splined_stereographic || node.has("spline")) {
    camera.spline = read_spline(node["spline"]);
  }
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    node.fail("(" + context + "): " + error.what());
  }
  return camera;
}

Json to_json(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"translation_m", to_json(pose.translation_m)}};
}

Pose read_pose(const JsonNode& node) {
  node.expect_keys({"rotation_wxyz", "translation_m"});
  const Eigen::Vector4d wxyz = node["rotation_wxyz"].vector<4>();
  Pose pose{Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]),
            node["translation_m"].vector<3>()};
  const double excess = std::abs(wxyz.norm() - 1);
  if (!(excess < 1e-5)) node["rotation_wxyz"].fail("does not have unit norm to 1e-5");
  if (excess > 1e-12) pose.rotation.normalize();  // short decimals; our own digits stay as they are
  return pose;
}

Json to_json(const SeedBoard& board) {
  return {{"plate_m", board.plate_m},   {"squares", board.squares},
          {"square_m", board.square_m}, {"has_markers", board.has_markers},
          {"marker_m", board.marker_m}, {"marker_ids", board.marker_ids}};
}

SeedBoard read_board(const JsonNode& node) {
  node.expect_keys({"plate_m", "squares", "square_m", "has_markers", "marker_m", "marker_ids"});
  SeedBoard board;
  board.plate_m = node["plate_m"].number();
  board.squares = static_cast<int>(node["squares"].integer(1, 1000));
  board.square_m = node["square_m"].number();
  board.has_markers = node["has_markers"].boolean();
  board.marker_m = node["marker_m"].number();
  if (node["marker_ids"].size(4) != 4) node["marker_ids"].fail("does not have 4 integers");
  for (std::size_t i = 0; i < 4; ++i) {
    board.marker_ids[i] = static_cast<int>(node["marker_ids"][i].integer(0, 49));
  }
  try {
    validate(board);
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
  return board;
}

std::string six_digits(std::int64_t number) {
  std::string digits = std::to_string(number);
  if (number < 0 || digits.size() > 6) {
    throw std::invalid_argument("number " + digits + " in a file name is outside 0..999999");
  }
  return std::string(6 - digits.size(), '0') + digits;
}

int number_of_six_digits(std::string_view name) {
  if (name.size() != 6) return -1;
  int number = 0;
  for (const char c : name) {
    if (c < '0' || c > '9') return -1;
    number = 10 * number + (c - '0');
  }
  return number;
}

}  // namespace cousin
