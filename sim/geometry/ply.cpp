#include <cmath>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/ply_rows.h"

namespace cousin::geometry {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& where, const std::string& what) {
  throw std::runtime_error(name + ": " + where + ": " + what);
}

std::uint32_t whole(double value, const PlyBody& body, const std::string& name) {
  if (!(value >= 0) || value > 4294967295.0 || value != std::floor(value))
    fail(name, body.where(), "expected a whole number of 0 or more");
  return static_cast<std::uint32_t>(value);
}

PlyElement read_element(const PlyElementHeader& header, PlyBody& body, const std::string& name) {
  body.require_rows(header);
  PlyElement element;
  element.name = header.name;
  element.count = header.count;
  for (const PlyProperty& p : header.properties) {
    if (p.is_list) {
      const bool is_indices = p.name == "vertex_indices" || p.name == "vertex_index";
      if (is_indices || (element.name == "face" && element.list.empty())) element.list = p.name;
    } else {
      element.columns.push_back(p.name);
      element.is_float.push_back(p.type == PlyType::f32 || p.type == PlyType::f64);
      element.values.emplace_back(element.count);
    }
  }
  if (!element.list.empty()) element.lists.resize(element.count);
  for (std::size_t row = 0; row < element.count; ++row) {
    std::size_t column = 0;
    for (const PlyProperty& p : header.properties) {
      if (!p.is_list) {
        element.values[column++][row] = body.number(p.type);
        continue;
      }
      const std::size_t length = body.list_length(p);
      const bool kept = p.name == element.list;
      for (std::size_t i = 0; i < length; ++i) {
        const double value = body.number(p.type);
        if (kept) element.lists[row].push_back(whole(value, body, name));
      }
    }
  }
  return element;
}

}  // namespace

const std::vector<double>* PlyElement::column(std::string_view column_name) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == column_name) return &values[i];
  }
  return nullptr;
}

const PlyElement* Ply::element(std::string_view element_name) const {
  for (const PlyElement& e : elements) {
    if (e.name == element_name) return &e;
  }
  return nullptr;
}

Ply parse_ply(std::string_view bytes, const std::string& name) {
  const PlyHeader header = parse_ply_header(bytes, name);
  PlyBody body(bytes, header.body, header.encoding, name);
  Ply ply;
  for (const PlyElementHeader& element : header.elements)
    ply.elements.push_back(read_element(element, body, name));
  return ply;
}

Mesh mesh_of_ply(const Ply& ply, const std::string& name) {
  const PlyElement* vertices = ply.element("vertex");
  if (!vertices) fail(name, "header", "there is no element \"vertex\"");
  const auto* x = vertices->column("x");
  const auto* y = vertices->column("y");
  const auto* z = vertices->column("z");
  if (!x || !y || !z) fail(name, "header", "vertices have no x, y and z");
  Mesh mesh;
  mesh.vertices_m.reserve(vertices->count);
  for (std::size_t i = 0; i < vertices->count; ++i) {
    mesh.vertices_m.emplace_back((*x)[i], (*y)[i], (*z)[i]);
    if (!mesh.vertices_m.back().allFinite())
      fail(name, "vertex " + std::to_string(i), "is not finite");
  }
  const PlyElement* faces = ply.element("face");
  if (!faces) return mesh;
  for (std::size_t i = 0; i < faces->lists.size(); ++i) {
    const auto& polygon = faces->lists[i];
    for (const std::uint32_t v : polygon) {
      if (v >= vertices->count) {
        fail(name, "face " + std::to_string(i),
             "vertex " + std::to_string(v) + " is not below " + std::to_string(vertices->count));
      }
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
      mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
  }
  return mesh;
}

}  // namespace cousin::geometry
