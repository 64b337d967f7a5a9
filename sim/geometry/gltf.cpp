#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/geometry/gltf_document.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin::geometry {
using nlohmann::json;
namespace {

constexpr std::size_t kMostNodes = 1'000'000;
constexpr std::size_t kNone = ~std::size_t{0};

std::string at_place(const char* list, std::size_t index) {
  return "/" + std::string(list) + "/" + std::to_string(index);
}

/// Walks the nodes of a glTF scene and gathers their triangles.
class GltfScene {
 public:
  GltfScene(GltfDocument& document, std::size_t most_triangles)
      : d_(document), most_triangles_(most_triangles) {}

  MeshFile read() {
    if (d_.count("nodes") > kMostNodes) d_.fail("/nodes", "has more than 1000000 entries");
    is_reached_.assign(d_.count("nodes"), false);
    // glTF's y is up and its z looks at the viewer; ours is z up.
    Eigen::Affine3d z_up = Eigen::Affine3d::Identity();
    z_up.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    for (const std::size_t node : roots()) push(node, z_up, "/scenes");
    // Depth first, by a list of our own: files may nest as deep as they like.
    while (!todo_.empty()) {
      const Todo next = todo_.back();
      todo_.pop_back();
      visit(next);
    }
    if (user_.mesh.triangles.empty()) d_.fail("/", "there are no triangles");
    user_.is_in_metres = true;
    if (!has_colours_) user_.vertex_albedo.clear();
    name_parts(user_);
    MeshFile file{std::move(user_), {}};
    for (const std::string& what : passed_over_) file.warnings.push_back(d_.name() + ": " + what);
    return file;
  }

 private:
  struct Todo {
    std::size_t node;
    Eigen::Affine3d world_from_node;
  };

  std::vector<std::size_t> roots() {
    std::vector<std::size_t> list;
    if (d_.count("scenes") > 0) {
      const std::size_t scene = d_.whole(d_.root(), "scene", "", kMostNodes, 0);
      if (d_.count("scenes") > 1 && !d_.has(d_.root(), "scene")) {
        passed_over_.insert("no scene is the file's own: the first of " +
                            std::to_string(d_.count("scenes")) + " is read");
      }
      const json& object = d_.entry("scenes", scene, "/scene");
      return indices(object, "nodes", at_place("scenes", scene));
    }
    std::vector<bool> is_child(d_.count("nodes"), false);
    for (std::size_t i = 0; i < is_child.size(); ++i) {
      for (const std::size_t child :
           indices(d_.entry("nodes", i, ""), "children", at_place("nodes", i)))
        if (child < is_child.size()) is_child[child] = true;
    }
    for (std::size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) list.push_back(i);
    }
    return list;
  }

  std::vector<std::size_t> indices(const json& object, const char* key,
                                   const std::string& where) const {
    std::vector<std::size_t> list;
    if (!d_.has(object, key)) return list;
    const json& values = object[key];
    if (!values.is_array()) d_.fail(where + "/" + key, "is not an array");
    for (const json& v : values) {
      if (!v.is_number_unsigned()) d_.fail(where + "/" + key, "has an entry that is no index");
      list.push_back(static_cast<std::size_t>(v.get<std::uint64_t>()));
    }
    return list;
  }

  void push(std::size_t node, const Eigen::Affine3d& parent, const std::string& from) {
    const json& object = d_.entry("nodes", node, from);
    const std::string where = at_place("nodes", node);
    if (is_reached_[node]) d_.fail(where, "is reached twice; nodes form a tree");
    is_reached_[node] = true;
    todo_.push_back({node, parent * placement(object, where)});
  }

  Eigen::Affine3d placement(const json& object, const std::string& where) const {
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    if (d_.has(object, "matrix")) {
      const std::vector<double> m = d_.numbers(object, "matrix", where, 16, {});
      place.matrix() = Eigen::Map<const Eigen::Matrix4d>(m.data());  // column by column
      if (place.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
        d_.fail(where + "/matrix", "is no affine map");
      return place;
    }
    const auto t = d_.numbers(object, "translation", where, 3, {0, 0, 0});
    const auto q = d_.numbers(object, "rotation", where, 4, {0, 0, 0, 1});
    const auto s = d_.numbers(object, "scale", where, 3, {1, 1, 1});
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    if (!(std::abs(rotation.norm() - 1) < 0.01))
      d_.fail(where + "/rotation", "has the norm " + std::to_string(rotation.norm()) + ", not 1");
    place.translate(Eigen::Vector3d(t[0], t[1], t[2]));
    place.rotate(rotation.normalized());
    place.scale(Eigen::Vector3d(s[0], s[1], s[2]));
    return place;
  }

  void visit(const Todo& todo) {
    const std::string where = at_place("nodes", todo.node);
    const json& object = d_.entry("nodes", todo.node, where);
    if (d_.has(object, "mesh")) add_mesh(object, todo.world_from_node, where);
    std::vector<std::size_t> children = indices(object, "children", where);
    std::reverse(children.begin(), children.end());  // the first is visited first
    for (const std::size_t child : children) push(child, todo.world_from_node, where + "/children");
  }

  std::string name_of(const json& node, const json& mesh) const {
    for (const json* object : {&node, &mesh}) {
      const auto name = object->find("name");
      if (name != object->end() && name->is_string()) {
        std::string text = cut_utf8(name->get_ref<const std::string&>(), 200);
        if (!text.empty()) return text;
      }
    }
    return "";
  }

  void add_mesh(const json& node, const Eigen::Affine3d& world_from_node,
                const std::string& where) {
    const std::size_t index = d_.whole(node, "mesh", where, kMostNodes, kNone);
    const json& mesh = d_.entry("meshes", index, where + "/mesh");
    const std::string mesh_where = at_place("meshes", index);
    refuse_other_shapes(node, where, mesh, mesh_where);
    if (!d_.has(mesh, "primitives") || !mesh["primitives"].is_array())
      d_.fail(mesh_where + "/primitives", "is not an array");
    const std::size_t before = user_.mesh.triangles.size();
    for (std::size_t k = 0; k < mesh["primitives"].size(); ++k) {
      const json& primitive = mesh["primitives"][k];
      const std::string place = mesh_where + "/primitives/" + std::to_string(k);
      if (!primitive.is_object()) d_.fail(place, "is not an object");
      add_primitive(primitive, world_from_node, place);
    }
    if (user_.mesh.triangles.size() == before) return;
    if (user_.part_names.size() == 65535) d_.fail(where, "more than 65535 nodes have triangles");
    user_.triangle_part.resize(user_.mesh.triangles.size(),
                               static_cast<std::uint16_t>(user_.part_names.size()));
    user_.part_names.push_back(name_of(node, mesh));
  }

  /// What gives a mesh another shape or place than its vertices and its node do.
  void refuse_other_shapes(const json& node, const std::string& where, const json& mesh,
                           const std::string& mesh_where) const {
    if (d_.has(node, "skin"))
      d_.fail(where + "/skin", "is not read; save the mesh as it stands, without its skeleton");
    if (d_.has(node, "extensions") && d_.has(node["extensions"], "EXT_mesh_gpu_instancing"))
      d_.fail(where + "/extensions/EXT_mesh_gpu_instancing",
              "is not read; save each copy as a node");
    const bool of_node = d_.has(node, "weights");
    const json& holder = of_node ? node : mesh;
    if (!d_.has(holder, "weights")) return;
    const std::string place = (of_node ? where : mesh_where) + "/weights";
    if (!holder["weights"].is_array()) d_.fail(place, "is not an array");
    for (const json& weight : holder["weights"]) {
      if (!weight.is_number() || weight.get<double>() != 0)
        d_.fail(place, "is not 0: morph targets are not read; save the mesh as it stands");
    }
  }

  /// Nodes may share a mesh: a small file can ask for many vertices. Lists grow by doubling.
  void check_room(std::size_t more) const {
    const std::uint64_t vertices = std::uint64_t{user_.mesh.vertices_m.size()} + more;
    check_memory(d_.name(), 3 * vertices * (sizeof(Eigen::Vector3d) + sizeof(Rgbf)),
                 std::to_string(vertices) + " vertices");
  }

  void add_primitive(const json& primitive, const Eigen::Affine3d& world_from_node,
                     const std::string& where) {
    const std::size_t mode = d_.whole(primitive, "mode", where, 6, 4);
    if (mode < 4) return;  // points and lines
    if (!d_.has(primitive, "attributes") || !d_.has(primitive["attributes"], "POSITION"))
      d_.fail(where, "has no POSITION");
    const json& attributes = primitive["attributes"];
    const std::size_t position = d_.whole(attributes, "POSITION", where, kMostNodes, kNone);
    const std::size_t most_vertices = std::min(kMaxElements, 3 * most_triangles_);
    const auto points = d_.read(
        position, {"VEC3"}, most_vertices - std::min(most_vertices, user_.mesh.vertices_m.size()));
    check_room(points.count);
    const auto first = static_cast<std::uint32_t>(user_.mesh.vertices_m.size());
    for (std::size_t i = 0; i < points.count; ++i) {
      const Eigen::Vector3d p =
          world_from_node * Eigen::Vector3d(static_cast<double>(points.numbers[3 * i]),
                                            static_cast<double>(points.numbers[3 * i + 1]),
                                            static_cast<double>(points.numbers[3 * i + 2]));
      if (!p.allFinite()) d_.fail(where, "vertex " + std::to_string(i) + " is not finite");
      user_.mesh.vertices_m.push_back(p);
    }
    add_colours(primitive, points.count, where);
    std::vector<std::uint32_t> corners;
    if (d_.has(primitive, "indices")) {
      corners = d_.read_indices(d_.whole(primitive, "indices", where, kMostNodes, kNone),
                                3 * kMaxElements);
    } else {
      corners.resize(points.count);
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
    }
    for (const std::uint32_t corner : corners) {
      if (corner < points.count) continue;
      d_.fail(where + "/indices", std::to_string(corner) + " is not below " +
                                      std::to_string(points.count) + ", the number of vertices");
    }
    if (mode == 4 && corners.size() % 3 != 0) {
      d_.fail(where, std::to_string(corners.size()) +
                         " corners are no whole number of triangles (mode 4)");
    }
    const bool is_mirrored = world_from_node.linear().determinant() < 0;
    add_triangles(corners, mode, first, is_mirrored);
    if (user_.mesh.triangles.size() > most_triangles_) {
      d_.fail(where,
              "more than " + std::to_string(most_triangles_) + " triangles, which is the limit");
    }
  }

  /// Lists, strips (5) and fans (6).
  void add_triangles(const std::vector<std::uint32_t>& corners, std::size_t mode,
                     std::uint32_t first, bool is_mirrored) {
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      if (is_mirrored) std::swap(b, c);
      user_.mesh.triangles.push_back({first + a, first + b, first + c});
    };
    const std::size_t step = mode == 4 ? 3 : 1;
    for (std::size_t i = 0; i + 2 < corners.size(); i += step) {
      if (mode == 6) {
        add(corners[0], corners[i + 1], corners[i + 2]);
      } else if (mode == 5 && i % 2 == 1) {
        add(corners[i + 1], corners[i], corners[i + 2]);
      } else {
        add(corners[i], corners[i + 1], corners[i + 2]);
      }
    }
  }

  /// Linear. What else makes the look of a material is passed over, and a warning says so.
  std::vector<double> base_colour(const json& primitive, const std::string& where) {
    const std::vector<double> white = {1, 1, 1, 1};
    if (!d_.has(primitive, "material")) return white;
    const std::size_t index = d_.whole(primitive, "material", where, kMostNodes, kNone);
    const json& material = d_.entry("materials", index, where + "/material");
    const std::string place = at_place("materials", index);
    if (d_.has(material, "extensions") &&
        d_.has(material["extensions"], "KHR_materials_pbrSpecularGlossiness")) {
      const json& old = material["extensions"]["KHR_materials_pbrSpecularGlossiness"];
      if (d_.has(old, "diffuseTexture")) pass_over_texture();
      if (d_.has(old, "diffuseFactor")) {
        has_colours_ = true;
        return d_.numbers(old, "diffuseFactor", place, 4, white);
      }
    }
    const bool is_given = d_.has(material, "pbrMetallicRoughness");
    const json none = json::object();
    const json& pbr = is_given ? material["pbrMetallicRoughness"] : none;
    if (d_.has(pbr, "baseColorTexture")) pass_over_texture();
    const double metallic = d_.has(pbr, "metallicFactor") && pbr["metallicFactor"].is_number()
                                ? pbr["metallicFactor"].get<double>()
                                : 1;
    // A texture may hold any share of metal.
    if (is_given && metallic > 0 && !d_.has(pbr, "metallicRoughnessTexture")) {
      passed_over_.insert(
          place + " is a metal (metallicFactor " +
          std::string(d_.has(pbr, "metallicFactor") ? "is given" : "is 1 where it is absent") +
          "): its colour is taken as that of a matt surface");
    }
    has_colours_ |= d_.has(pbr, "baseColorFactor");
    return d_.numbers(pbr, "baseColorFactor", place, 4, white);
  }

  void pass_over_texture() {
    passed_over_.insert(
        "its textures are not read: a surface has its material's and its vertices' "
        "colour alone");
  }

  /// COLOR_0 times the material's base colour, both linear; white where neither is given.
  void add_colours(const json& primitive, std::size_t vertices, const std::string& where) {
    const std::vector<double> base = base_colour(primitive, where);
    const auto channel = [&](double value) {
      return static_cast<float>(std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0);
    };
    const json& attributes = primitive["attributes"];
    if (!d_.has(attributes, "COLOR_0")) {
      user_.vertex_albedo.insert(user_.vertex_albedo.end(), vertices,
                                 {channel(base[0]), channel(base[1]), channel(base[2])});
      return;
    }
    has_colours_ = true;
    const auto colours = d_.read(d_.whole(attributes, "COLOR_0", where, kMostNodes, kNone),
                                 {"VEC3", "VEC4"}, kMaxElements);
    if (colours.count != vertices) {
      d_.fail(where + "/attributes/COLOR_0", std::to_string(colours.count) + " colours for " +
                                                 std::to_string(vertices) + " vertices");
    }
    for (std::size_t i = 0; i < vertices; ++i) {
      const float* c = &colours.numbers[i * colours.components];
      user_.vertex_albedo.push_back({channel(base[0] * static_cast<double>(c[0])),
                                     channel(base[1] * static_cast<double>(c[1])),
                                     channel(base[2] * static_cast<double>(c[2]))});
    }
  }

  GltfDocument& d_;
  std::size_t most_triangles_;
  UserMesh user_;
  std::vector<Todo> todo_;
  std::vector<bool> is_reached_;
  std::set<std::string> passed_over_;  ///< each once, for the warnings
  bool has_colours_ = false;
};

}  // namespace

MeshFile parse_gltf(std::string_view bytes, const std::string& name, const OpenFile& open,
                    std::size_t most_triangles) {
  GltfDocument document(bytes, name, open);
  return GltfScene(document, most_triangles).read();
}

}  // namespace cousin::geometry
