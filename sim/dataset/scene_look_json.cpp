#include "sim/dataset/scene_look_json.h"

#include <array>
#include <string_view>

namespace cousin {
namespace {

constexpr std::size_t kMaxPixels = std::size_t{1} << 24;
constexpr int kMaxSide = 65535;

constexpr std::array kSurfaceNames = {"coated", "leaf", "conductor", "glass", "clear"};

Json array_of(const Rgbf& color) {
  return {static_cast<double>(color.r), static_cast<double>(color.g), static_cast<double>(color.b)};
}

Rgbf read_color(const JsonNode& node) {
  const Eigen::Vector3d v = node.vector<3>();
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

Json json_of(const Image<Rgbf>& picture) {
  Json pixels = Json::array();
  for (const Rgbf& p : picture) {
    for (const float v : {p.r, p.g, p.b}) pixels.push_back(static_cast<double>(v));
  }
  return {{"width_px", picture.width()}, {"height_px", picture.height()}, {"pixels", pixels}};
}

Image<Rgbf> read_picture(const JsonNode& node) {
  node.expect_keys({"width_px", "height_px", "pixels"});
  const int width = static_cast<int>(node["width_px"].integer(1, kMaxSide));
  const int height = static_cast<int>(node["height_px"].integer(1, kMaxSide));
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (count > kMaxPixels) node.fail("has more than 2^24 pixels");
  const std::vector<double> values = node["pixels"].numbers(3 * count, 3 * count);
  Image<Rgbf> picture(width, height);
  for (std::size_t i = 0; i < count; ++i) {
    picture.data()[i] = {static_cast<float>(values[3 * i]), static_cast<float>(values[3 * i + 1]),
                         static_cast<float>(values[3 * i + 2])};
  }
  return picture;
}

SurfaceKind read_kind(const JsonNode& node) {
  const std::string name = node.text(16);
  for (std::size_t i = 0; i < kSurfaceNames.size(); ++i) {
    if (name == kSurfaceNames[i]) return static_cast<SurfaceKind>(i);
  }
  node.fail("is not one of coated, leaf, conductor, glass, clear");
}

}  // namespace

Json to_json(const Material& material) {
  const Material usual;
  Json json = {{"name", material.name},
               {"albedo", array_of(material.albedo)},
               {"ior", material.ior},
               {"roughness", material.roughness},
               {"ink_albedo", array_of(material.ink_albedo)}};
  if (material.print) json["print"] = to_json(*material.print);
  if (material.print_bend_m != usual.print_bend_m) json["print_bend_m"] = material.print_bend_m;
  if (material.kind != usual.kind)
    json["kind"] = kSurfaceNames[static_cast<std::size_t>(material.kind)];
  if (material.transmittance != usual.transmittance)
    json["transmittance"] = array_of(material.transmittance);
  if (material.back_albedo) json["back_albedo"] = array_of(*material.back_albedo);
  if (material.mean_free_path_m != usual.mean_free_path_m)
    json["mean_free_path_m"] = array_of(material.mean_free_path_m);
  if (material.noise) {
    json["noise"] = {{"other_albedo", array_of(material.noise->other_albedo)},
                     {"scale_m", material.noise->scale_m},
                     {"octaves", material.noise->octaves}};
  }
  if (material.infrared_albedo != usual.infrared_albedo)
    json["infrared_albedo"] = static_cast<double>(material.infrared_albedo);
  if (material.infrared_transmittance != usual.infrared_transmittance)
    json["infrared_transmittance"] = static_cast<double>(material.infrared_transmittance);
  if (material.infrared_noise) {
    json["infrared_noise"] = {
        {"other_albedo", static_cast<double>(material.infrared_noise->other_albedo)},
        {"scale_m", material.infrared_noise->scale_m},
        {"octaves", material.infrared_noise->octaves}};
  }
  return json;
}

Material read_material(const JsonNode& node) {
  node.expect_keys(
      {"name", "albedo", "ior", "roughness", "ink_albedo"},
      {"print", "print_bend_m", "kind", "transmittance", "back_albedo", "mean_free_path_m", "noise",
       "infrared_albedo", "infrared_transmittance", "infrared_noise"});
  Material material;
  material.name = node["name"].text();
  material.albedo = read_color(node["albedo"]);
  material.ior = node["ior"].number(1, 10);
  material.roughness = node["roughness"].number(0, 1);
  material.ink_albedo = read_color(node["ink_albedo"]);
  if (node.has("print")) material.print = read_board(node["print"]);
  if (node.has("print_bend_m")) material.print_bend_m = node["print_bend_m"].number(0, 1);
  if (node.has("kind")) material.kind = read_kind(node["kind"]);
  if (node.has("transmittance")) material.transmittance = read_color(node["transmittance"]);
  if (node.has("back_albedo")) material.back_albedo = read_color(node["back_albedo"]);
  if (node.has("mean_free_path_m"))
    material.mean_free_path_m = read_color(node["mean_free_path_m"]);
  if (node.has("noise")) {
    const JsonNode noise = node["noise"];
    noise.expect_keys({"other_albedo", "scale_m", "octaves"});
    material.noise = {read_color(noise["other_albedo"]), noise["scale_m"].number(0),
                      static_cast<int>(noise["octaves"].integer(1, 12))};
  }
  if (node.has("infrared_noise")) {
    const JsonNode noise = node["infrared_noise"];
    noise.expect_keys({"other_albedo", "scale_m", "octaves"});
    material.infrared_noise = {static_cast<float>(noise["other_albedo"].number(0, 1)),
                               noise["scale_m"].number(0),
                               static_cast<int>(noise["octaves"].integer(1, 12))};
  }
  const auto share = [&](const char* key, float usual) {
    return node.has(key) ? static_cast<float>(node[key].number(0, 1)) : usual;
  };
  material.infrared_albedo = share("infrared_albedo", material.infrared_albedo);
  material.infrared_transmittance =
      share("infrared_transmittance", material.infrared_transmittance);
  return material;
}

std::string environment_file(std::size_t light) {
  return "environments/" + six_digits(static_cast<std::int64_t>(light)) + ".exr";
}

Json to_json(const Light& light, std::size_t index) {
  struct Writer {
    std::size_t index;
    Json operator()(const Sun& sun) const {
      return {{"kind", "sun"},
              {"to_sun", to_json(sun.to_sun)},
              {"angular_radius_rad", sun.angular_radius_rad},
              {"irradiance", array_of(sun.irradiance)}};
    }
    Json operator()(const Sky& sky) const {
      return {{"kind", "sky"},
              {"zenith", array_of(sky.zenith)},
              {"horizon", array_of(sky.horizon)},
              {"ground", array_of(sky.ground)}};
    }
    Json operator()(const Lamp& lamp) const {
      return {{"kind", "lamp"},
              {"centre_in_world_m", to_json(lamp.centre_in_world_m)},
              {"axis_u_m", to_json(lamp.axis_u_m)},
              {"axis_v_m", to_json(lamp.axis_v_m)},
              {"radiance", array_of(lamp.radiance)}};
    }
    Json operator()(const ClearSky& sky) const {
      return {{"kind", "clear_sky"},
              {"to_sun", to_json(sky.to_sun)},
              {"turbidity", sky.turbidity},
              {"has_sun", sky.has_sun},
              {"angular_radius_rad", sky.angular_radius_rad},
              {"scale", sky.scale},
              {"ground_albedo", array_of(sky.ground_albedo)}};
    }
    Json operator()(const Projector& projector) const {
      return {{"kind", "projector"},
              {"world_from_projector", to_json(projector.world_from_projector)},
              {"lens", to_json(projector.lens)},
              {"intensity", json_of(projector.intensity)}};
    }
    Json operator()(const Environment&) const {
      return {{"kind", "environment"}, {"file", environment_file(index)}};
    }
  };
  return std::visit(Writer{index}, light);
}

Light read_light(const JsonNode& node, std::size_t index, std::vector<EnvironmentFile>& files) {
  const std::string kind = node["kind"].text(16);
  if (kind == "sun") {
    node.expect_keys({"kind", "to_sun", "angular_radius_rad", "irradiance"});
    return Sun{node["to_sun"].vector<3>(), node["angular_radius_rad"].number(0, 1),
               read_color(node["irradiance"])};
  }
  if (kind == "sky") {
    node.expect_keys({"kind", "zenith", "horizon", "ground"});
    return Sky{read_color(node["zenith"]), read_color(node["horizon"]), read_color(node["ground"])};
  }
  if (kind == "lamp") {
    node.expect_keys({"kind", "centre_in_world_m", "axis_u_m", "axis_v_m", "radiance"});
    return Lamp{node["centre_in_world_m"].vector<3>(), node["axis_u_m"].vector<3>(),
                node["axis_v_m"].vector<3>(), read_color(node["radiance"])};
  }
  if (kind == "clear_sky") {
    node.expect_keys(
        {"kind", "to_sun", "turbidity", "has_sun", "angular_radius_rad", "scale", "ground_albedo"});
    return ClearSky{node["to_sun"].vector<3>(), node["turbidity"].number(1, 100),
                    node["has_sun"].boolean(),  node["angular_radius_rad"].number(0, 1),
                    node["scale"].number(0),    read_color(node["ground_albedo"])};
  }
  if (kind == "projector") {
    node.expect_keys({"kind", "world_from_projector", "lens", "intensity"});
    return Projector{read_pose(node["world_from_projector"]),
                     read_camera(node["lens"], "projector"), read_picture(node["intensity"])};
  }
  if (kind == "environment") {
    if (node.has("radiance")) {
      node.expect_keys({"kind", "radiance"});
      return Environment{read_picture(node["radiance"])};
    }
    node.expect_keys({"kind", "file"}, {"scale"});
    const double scale = node.has("scale") ? node["scale"].number(0, 1e20) : 1;
    files.push_back({index, node["file"].text(), scale});
    return Environment{};
  }
  node["kind"].fail("is not one of sun, sky, lamp, clear_sky, projector, environment");
}

}  // namespace cousin
