#include <cmath>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/ply_rows.h"
#include "sim/geometry/polygon.h"
#include "sim/types/memory_limit.h"

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

bool is_float(PlyType type) { return type == PlyType::f32 || type == PlyType::f64; }

/// The list of a face's corners: the one of their two names, or the only one there is.
std::string corners_of(const PlyElementHeader& header, const std::string& name) {
  std::vector<const PlyProperty*> lists;
  for (const PlyProperty& p : header.properties) {
    if (!p.is_list) continue;
    if (p.name == "vertex_indices" || p.name == "vertex_index") return p.name;
    lists.push_back(&p);
  }
  if (lists.size() == 1 && !is_float(lists.front()->type)) return lists.front()->name;
  if (header.count > 0)
    fail(name, "header", "faces have no list \"vertex_indices\" or \"vertex_index\"");
  return "";
}

/// Asks for what the rows will take, a list's own block with it.
void check_rows(const PlyElementHeader& header, const std::string& name) {
  std::uint64_t row = 0;
  for (const PlyProperty& p : header.properties) row += p.is_list ? 64 : sizeof(double);
  check_memory(name, bytes_times(header.count, row),
               std::to_string(header.count) + " rows of its element " + header.name);
}

PlyElement read_element(const PlyElementHeader& header, PlyBody& body, const std::string& name) {
  body.require_rows(header);
  check_rows(header, name);
  PlyElement element;
  element.name = header.name;
  element.count = header.count;
  if (header.name == "face") element.list = corners_of(header, name);
  for (const PlyProperty& p : header.properties) {
    if (p.is_list) continue;
    element.columns.push_back(p.name);
    element.is_float.push_back(is_float(p.type));
    element.values.emplace_back(element.count);
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
  ply.comments = header.comments;
  ply.bytes_left = body.left_but_blanks();
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
  const PlyElement* strips = ply.element("tristrips");
  if (strips && strips->count > 0)
    fail(name, "header", "triangle strips (element tristrips) are not read; save faces");
  if (!faces) return mesh;
  for (std::size_t i = 0; i < faces->lists.size(); ++i) {
    const auto& polygon = faces->lists[i];
    for (const std::uint32_t v : polygon) {
      if (v >= vertices->count) {
        fail(name, "face " + std::to_string(i),
             "vertex " + std::to_string(v) + " is not below " + std::to_string(vertices->count));
      }
    }
    if (polygon.size() < 3) continue;  // a point or a line
    const PolygonTriangles cut = triangles_of_polygon(mesh.vertices_m, polygon);
    if (!cut.problem.empty()) fail(name, "face " + std::to_string(i), cut.problem);
    mesh.triangles.insert(mesh.triangles.end(), cut.triangles.begin(), cut.triangles.end());
  }
  return mesh;
}

}  // namespace cousin::geometry
