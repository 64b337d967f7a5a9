#include "sim/geometry/gltf_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin::geometry {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr std::size_t kMostBuffers = 10'000;
constexpr std::size_t kMostBytes = std::size_t{1} << 32;
enum ComponentType { kByte = 5120, kUByte, kShort, kUShort, kUInt = 5125, kFloat };

std::size_t size_of(int component_type) {
  switch (component_type) {
    case kByte:
    case kUByte:
      return 1;
    case kShort:
    case kUShort:
      return 2;
    case kUInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

std::size_t components_of(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  return 0;  // matrices: nothing that we read has them
}

template <class T>
T take(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

float number_at(const char* at, int type, bool is_normalized) {
  const auto integer = [&](auto value, float full) {
    const auto v = static_cast<float>(value);
    return is_normalized ? std::max(v / full, -1.0F) : v;
  };
  switch (type) {
    case kByte:
      return integer(take<std::int8_t>(at), 127.0F);
    case kUByte:
      return integer(take<std::uint8_t>(at), 255.0F);
    case kShort:
      return integer(take<std::int16_t>(at), 32767.0F);
    case kUShort:
      return integer(take<std::uint16_t>(at), 65535.0F);
    case kUInt:
      return static_cast<float>(take<std::uint32_t>(at));
    default:
      return take<float>(at);
  }
}

std::string document_place(const char* list, std::size_t index) {
  return "/" + std::string(list) + "/" + std::to_string(index);
}

std::string percent_decoded(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto digit = [&](std::size_t k) {
      const std::size_t found =
          std::string_view("0123456789abcdef")
              .find(static_cast<char>(std::tolower(static_cast<unsigned char>(uri[k]))));
      return found == std::string_view::npos ? -1 : static_cast<int>(found);
    };
    if (uri[i] == '%' && i + 2 < uri.size() && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
      text += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

}  // namespace

bool decode_base64(std::string_view text, std::string& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<int, 256> value{};
  value.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    value[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
  bytes.clear();
  bytes.reserve(text.size() / 4 * 3);
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int v = value[static_cast<unsigned char>(c)];
    if (v < 0) return false;
    bits = (bits << 6) | static_cast<std::uint32_t>(v);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>((bits >> held) & 0xFFU);
  }
  return true;
}

OpenFile files_beside(const fs::path& file) {
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  return [folder, name = file.string()](const std::string& uri) {
    const fs::path relative = percent_decoded(uri);
    const auto refuse = [&](const char* why) {
      throw std::runtime_error(name + ": the buffer \"" + cut_utf8(uri, 200) + "\" " + why);
    };
    if (uri.find("://") != std::string::npos || relative.is_absolute())
      refuse("is no file inside the folder");
    std::error_code error;
    const fs::path inside = fs::weakly_canonical(folder, error);
    const fs::path there = fs::weakly_canonical(folder / relative, error);
    const auto [end, rest] =
        std::mismatch(inside.begin(), inside.end(), there.begin(), there.end());
    if (error || end != inside.end() || rest == there.end())
      refuse("leads out of the file's folder");
    return read_whole(there);
  };
}

GltfDocument::GltfDocument(std::string_view bytes, std::string name, OpenFile open)
    : name_(std::move(name)), open_(std::move(open)) {
  constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
  if (bytes.size() >= 12 && take<std::uint32_t>(bytes.data()) == kMagic) {
    parse_container(bytes);
  } else {
    root_ = parse_json(bytes);
  }
  if (root_.is_discarded()) throw std::runtime_error(name_ + ": not JSON in UTF-8, as glTF is");
  if (!root_.is_object()) fail("/", "is not an object");
  const auto asset = root_.find("asset");
  std::string version;
  if (asset != root_.end() && asset->is_object()) {
    const auto text = asset->find("version");
    if (text != asset->end() && text->is_string()) version = text->get<std::string>();
  }
  if (!version.starts_with("2.")) fail("/asset/version", "is \"" + version + "\"; 2.0 is read");
  // What these leave out is looks, or written out by us.
  constexpr std::array<std::string_view, 3> kRead = {
      "KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual"};
  const auto required = root_.find("extensionsRequired");
  if (required != root_.end() && required->is_array()) {
    for (const json& extension : *required) {
      const std::string text = extension.is_string() ? extension.get<std::string>() : "?";
      if (std::find(kRead.begin(), kRead.end(), text) == kRead.end() &&
          !text.starts_with("KHR_materials_"))
        fail("/extensionsRequired", "names " + cut_utf8(text, 100) + ", which is not read");
    }
  }
  const std::size_t buffers = count("buffers");
  if (buffers > kMostBuffers)
    fail("/buffers", "has " + std::to_string(buffers) + " entries; the limit is 10000");
  buffers_.resize(buffers);
  is_loaded_.assign(buffers, false);
}

json GltfDocument::parse_json(std::string_view text) const {
  // A value takes about this many bytes, whatever it is, and each but the first follows one of
  // these characters.
  constexpr std::uint64_t kValue = 80;
  const auto values = std::count_if(text.begin(), text.end(),
                                    [](char c) { return c == ',' || c == '[' || c == '{'; });
  check_memory(name_, text.size() + kValue * static_cast<std::uint64_t>(values),
               "about " + std::to_string(values) + " values of JSON");
  return json::parse(text, nullptr, false);
}

void GltfDocument::parse_container(std::string_view bytes) {
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  const std::size_t length_in_header = take<std::uint32_t>(bytes.data() + 8);
  if (length_in_header > bytes.size()) {
    fail("byte 8", "the file says it has " + std::to_string(length_in_header) + " bytes; it has " +
                       std::to_string(bytes.size()));
  }
  bytes = bytes.substr(0, length_in_header);
  bool has_json = false;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t length = take<std::uint32_t>(bytes.data() + at);
    const auto type = take<std::uint32_t>(bytes.data() + at + 4);
    if (length > bytes.size() - at - 8) {
      fail("byte " + std::to_string(at),
           "a chunk of " + std::to_string(length) + " bytes is longer than the file");
    }
    const std::string_view chunk = bytes.substr(at + 8, length);
    if (type == kJson && !has_json) {
      root_ = parse_json(chunk);
      has_json = true;
    } else if (type == kBinary && !has_binary_) {
      binary_ = chunk;
      has_binary_ = true;
    }
    at += 8 + length;
  }
  if (!has_json) fail("byte 12", "there is no JSON chunk");
}

void GltfDocument::fail(const std::string& where, const std::string& what) const {
  throw std::runtime_error(name_ + ": " + where + ": " + what);
}

bool GltfDocument::has(const json& object, const char* key) const {
  return object.is_object() && object.contains(key);
}

std::size_t GltfDocument::count(const char* list) const {
  const auto found = root_.find(list);
  if (found == root_.end()) return 0;
  if (!found->is_array()) fail("/" + std::string(list), "is not an array");
  return found->size();
}

const json& GltfDocument::entry(const char* list, std::size_t index,
                                const std::string& from) const {
  if (index >= count(list)) {
    fail(from, std::to_string(index) + " is not below " + std::to_string(count(list)) +
                   ", the number of " + list);
  }
  const json& value = root_[list][index];
  if (!value.is_object()) fail(document_place(list, index), "is not an object");
  return value;
}

std::size_t GltfDocument::whole(const json& object, const char* key, const std::string& where,
                                std::size_t most, std::size_t otherwise) const {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > most) {
    fail(where + "/" + key,
         found->dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60) +
             " is not a whole number of at most " + std::to_string(most));
  }
  return static_cast<std::size_t>(found->get<std::uint64_t>());
}

std::vector<double> GltfDocument::numbers(const json& object, const char* key,
                                          const std::string& where, std::size_t number,
                                          std::vector<double> otherwise) const {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_array() || found->size() != number)
    fail(where + "/" + key, "is not an array of " + std::to_string(number) + " numbers");
  std::vector<double> values;
  for (const json& v : *found) {
    if (!v.is_number() || !std::isfinite(v.get<double>()))
      fail(where + "/" + key, "has an entry that is no finite number");
    values.push_back(v.get<double>());
  }
  return values;
}

std::string_view GltfDocument::buffer(std::size_t index) {
  const std::string where = document_place("buffers", index);
  const json& object = entry("buffers", index, where);
  if (!has(object, "uri")) {
    if (index != 0 || !has_binary_) fail(where, "has no uri, and there is no binary chunk");
    return binary_;
  }
  if (is_loaded_[index]) return buffers_[index];
  if (!object["uri"].is_string()) fail(where + "/uri", "is not a text");
  const auto& uri = object["uri"].get_ref<const std::string&>();
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    constexpr std::string_view kBase64 = ";base64";
    const std::string_view head = std::string_view(uri).substr(0, comma);
    if (comma == std::string::npos || !head.ends_with(kBase64) ||
        !decode_base64(std::string_view(uri).substr(comma + 1), buffers_[index]))
      fail(where + "/uri", "is not data in base 64");
  } else {
    buffers_[index] = open_(uri);
  }
  loaded_bytes_ += buffers_[index].size();
  check_memory(name_, loaded_bytes_, "its buffers");
  is_loaded_[index] = true;
  return buffers_[index];
}

GltfDocument::Rows GltfDocument::rows_of(std::size_t accessor,
                                         std::initializer_list<std::string_view> types,
                                         std::size_t most_rows) {
  const std::string where = document_place("accessors", accessor);
  const json& object = entry("accessors", accessor, where);
  if (has(object, "sparse")) fail(where + "/sparse", "is not read");
  if (!has(object, "bufferView")) fail(where, "has no bufferView (compressed data are not read)");
  Rows rows;
  const auto type = object.find("type");
  const std::string name =
      type != object.end() && type->is_string() ? type->get<std::string>() : "";
  if (std::find(types.begin(), types.end(), name) == types.end()) {
    std::string names;
    for (const std::string_view t : types) names += (names.empty() ? "" : ", ") + std::string(t);
    fail(where + "/type", "\"" + cut_utf8(name, 20) + "\" is not one of " + names);
  }
  rows.components = components_of(name);
  rows.component_type = static_cast<int>(whole(object, "componentType", where, 100'000, 0));
  const std::size_t number_size = size_of(rows.component_type);
  if (number_size == 0)
    fail(where + "/componentType", std::to_string(rows.component_type) + " is unknown");
  rows.count = whole(object, "count", where, most_rows, 0);
  const auto normalized = object.find("normalized");
  rows.is_normalized =
      normalized != object.end() && normalized->is_boolean() && normalized->get<bool>();

  const std::size_t view = whole(object, "bufferView", where, kMostBytes, 0);
  const std::string view_where = document_place("bufferViews", view);
  const json& view_object = entry("bufferViews", view, where + "/bufferView");
  const std::string_view bytes =
      buffer(whole(view_object, "buffer", view_where, kMostBytes, kMostBytes));
  const std::size_t view_offset = whole(view_object, "byteOffset", view_where, kMostBytes, 0);
  const std::size_t view_length = whole(view_object, "byteLength", view_where, kMostBytes, 0);
  if (view_offset > bytes.size() || view_length > bytes.size() - view_offset) {
    fail(view_where, "ends at byte " + std::to_string(view_offset + view_length) +
                         "; its buffer has " + std::to_string(bytes.size()));
  }
  const std::size_t offset = whole(object, "byteOffset", where, kMostBytes, 0);
  const std::size_t row_size = rows.components * number_size;
  rows.stride = whole(view_object, "byteStride", view_where, 252, 0);
  if (rows.stride == 0) rows.stride = row_size;
  const bool fits =
      rows.stride >= row_size && offset <= view_length &&
      (rows.count == 0 || (view_length - offset >= row_size &&
                           (view_length - offset - row_size) / rows.stride >= rows.count - 1));
  if (!fits) {
    fail(where, std::to_string(rows.count) + " rows of " + std::to_string(row_size) +
                    " bytes do not fit into the " + std::to_string(view_length) + " bytes of " +
                    view_where);
  }
  rows.bytes = bytes.substr(view_offset + offset);
  return rows;
}

GltfDocument::Values GltfDocument::read(std::size_t accessor,
                                        std::initializer_list<std::string_view> types,
                                        std::size_t most_rows) {
  const Rows rows = rows_of(accessor, types, most_rows);
  Values values{rows.count, rows.components, {}};
  values.numbers.reserve(rows.count * rows.components);
  const std::size_t size = size_of(rows.component_type);
  for (std::size_t i = 0; i < rows.count; ++i) {
    for (std::size_t k = 0; k < rows.components; ++k) {
      values.numbers.push_back(number_at(rows.bytes.data() + i * rows.stride + k * size,
                                         rows.component_type, rows.is_normalized));
    }
  }
  return values;
}

std::vector<std::uint32_t> GltfDocument::read_indices(std::size_t accessor, std::size_t most_rows) {
  const Rows rows = rows_of(accessor, {"SCALAR"}, most_rows);
  std::vector<std::uint32_t> indices(rows.count);
  for (std::size_t i = 0; i < rows.count; ++i) {
    const char* at = rows.bytes.data() + i * rows.stride;
    switch (rows.component_type) {
      case kUByte:
        indices[i] = take<std::uint8_t>(at);
        break;
      case kUShort:
        indices[i] = take<std::uint16_t>(at);
        break;
      case kUInt:
        indices[i] = take<std::uint32_t>(at);
        break;
      default:
        fail(document_place("accessors", accessor) + "/componentType",
             std::to_string(rows.component_type) +
                 " is not one of 5121, 5123, 5125, as indices are");
    }
  }
  return indices;
}

}  // namespace cousin::geometry
