#include "sim/render/cycles/cycles_scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/render/scene_lights.h"

namespace cousin {
namespace {

using nlohmann::json;

static_assert(sizeof(float) == 4, "arrays are handed over as 32-bit floats");

json array_of(const Rgbf& c) { return {c.r, c.g, c.b}; }
json array_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
json array_of(const Pose& pose) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = to_matrix(pose);
  return std::vector<double>(m.data(), m.data() + 16);
}

template <class T>
std::string write_array(const std::filesystem::path& folder, const std::string& name,
                        const std::vector<T>& values) {
  std::ofstream out(folder / name, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(T)));
  out.close();
  if (!out) throw std::runtime_error((folder / name).string() + ": cannot be written");
  return name;
}

json json_of(const ObjectModel& model, std::size_t number, const std::filesystem::path& folder) {
  const std::string stem = "model_" + std::to_string(number);
  std::vector<float> vertices, normals, albedo;
  std::vector<std::uint32_t> triangles;
  for (const auto& v : model.mesh.vertices_m) {
    for (int k = 0; k < 3; ++k) vertices.push_back(static_cast<float>(v[k]));
  }
  for (const auto& t : model.mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const auto& n : model.vertex_normals) normals.insert(normals.end(), {n.x(), n.y(), n.z()});
  for (const Rgbf& c : model.vertex_albedo) albedo.insert(albedo.end(), {c.r, c.g, c.b});
  json spec = {{"name", model.name},
               {"vertices", write_array(folder, stem + "_vertices.f32", vertices)},
               {"triangles", write_array(folder, stem + "_triangles.u32", triangles)}};
  if (!normals.empty()) spec["normals"] = write_array(folder, stem + "_normals.f32", normals);
  if (!albedo.empty()) spec["albedo"] = write_array(folder, stem + "_albedo.f32", albedo);
  return spec;
}

json json_of(const Material& material) {
  static constexpr const char* kKinds[] = {"coated", "leaf", "conductor", "glass", "clear"};
  if (material.print || material.noise || material.back_albedo) {
    throw std::invalid_argument("Cycles: material \"" + material.name +
                                "\" has a print, noise or a back of its own, which are not handed "
                                "over");
  }
  return {{"name", material.name},
          {"kind", kKinds[static_cast<int>(material.kind)]},
          {"albedo", array_of(material.albedo)},
          {"transmittance", array_of(material.transmittance)},
          {"mean_free_path_m", array_of(material.mean_free_path_m)},
          {"ior", material.ior},
          {"roughness", material.roughness},
          {"vertex_albedo", false}};
}

/// Suns and lamps as they are, everything else that shines from afar as one picture.
json lights_of(const Scene& scene, const std::filesystem::path& folder) {
  const SceneLights lights = make_lights(scene, Eigen::Vector3d::Zero());
  if (!lights.beams.empty())
    throw std::invalid_argument("Cycles: scene \"" + scene.name + "\" has a projector");
  json suns = json::array(), lamps = json::array();
  for (const auto& sun : lights.suns) {
    const Eigen::Vector3d to_sun = sun.to_sun.cast<double>();
    const Eigen::Vector3d irradiance = sun.irradiance.cast<double>();
    suns.push_back({{"to_sun", array_of(to_sun)},
                    {"irradiance", array_of(irradiance)},
                    {"angular_radius_rad", std::asin(static_cast<double>(sun.sin_radius))}});
  }
  for (const Light& light : scene.lights) {
    const auto* lamp = std::get_if<Lamp>(&light);
    if (!lamp) continue;
    if (std::abs(lamp->axis_u_m.normalized().dot(lamp->axis_v_m.normalized())) > 1e-6)
      throw std::invalid_argument("Cycles: a lamp's axes are not at right angles");
    lamps.push_back({{"centre_in_world_m", array_of(lamp->centre_in_world_m)},
                     {"axis_u_m", array_of(lamp->axis_u_m)},
                     {"axis_v_m", array_of(lamp->axis_v_m)},
                     {"radiance", array_of(lamp->radiance)}});
  }
  json sky = nullptr;
  if (!lights.skies.empty() || !lights.pictures.empty()) {
    // Blender's picture: rows from the nadir up, columns by falling azimuth.
    constexpr int kWidth = 1024, kHeight = 512;
    std::vector<float> pixels;
    for (int y = 0; y < kHeight; ++y) {
      const float elevation = std::numbers::pi_v<float> * ((y + 0.5F) / kHeight - 0.5F);
      for (int x = 0; x < kWidth; ++x) {
        const float azimuth = std::numbers::pi_v<float> * (1 - 2 * (x + 0.5F) / kWidth);
        const Eigen::Vector3f c =
            sky_radiance(lights, {std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
        pixels.insert(pixels.end(), {c.x(), c.y(), c.z()});
      }
    }
    sky = {{"width_px", kWidth},
           {"height_px", kHeight},
           {"pixels", write_array(folder, "sky.f32", pixels)}};
  }
  return {{"suns", suns}, {"lamps", lamps}, {"sky", sky}};
}

json camera_of(const TrueView& view) {
  const Camera& c = view.camera;
  json spec = {{"width_px", c.width_px},
               {"height_px", c.height_px},
               {"fx_px", c.fx_px},
               {"fy_px", c.fy_px},
               {"cx_px", c.cx_px},
               {"cy_px", c.cy_px},
               {"world_from_camera", array_of(inverse(view.camera_from_world))},
               {"near_m", 1e-4},
               {"far_m", 1e5}};
  if (c.model == LensModel::pinhole) {
    spec["model"] = "pinhole";
    return spec;
  }
  if (c.model != LensModel::kannala_brandt4) {
    throw std::invalid_argument("Cycles: has no lens \"" + std::string(to_string(c.model)) +
                                "\"; pinhole and kannala_brandt4 can be expressed");
  }
  const double centre_px = std::max(std::abs(c.cx_px - (c.width_px - 1) / 2.0),
                                    std::abs(c.cy_px - (c.height_px - 1) / 2.0));
  if (std::abs(c.fx_px - c.fy_px) > 1e-9 * c.fx_px || centre_px > 1e-9) {
    throw std::invalid_argument(
        "Cycles: its fisheye needs equal focal lengths and a principal point in the middle");
  }
  // Cycles: theta = -(k0 + k1 r + ... + k4 r^4), r in millimetres on the sensor; ours: r as a
  // polynomial of theta. The inverse is fitted over the image by least squares.
  const double pixel_mm = 1.0 / c.fx_px;  // focal length of 1 mm
  const double r_max = std::hypot(c.width_px, c.height_px) / 2 * pixel_mm;
  Eigen::MatrixXd powers(200, 4);
  Eigen::VectorXd angles(200);
  for (int i = 0; i < 200; ++i) {
    const double r = r_max * (i + 1) / 200;
    const auto d = unproject(c, {c.cx_px + r * c.fx_px, c.cy_px});
    if (!d) throw std::invalid_argument("Cycles: the lens has no ray at the image's corner");
    angles[i] = std::atan2(std::hypot(d->x(), d->y()), d->z());
    for (int k = 0; k < 4; ++k) powers(i, k) = std::pow(r, k + 1);
  }
  const Eigen::Vector4d k = powers.colPivHouseholderQr().solve(angles);
  spec["model"] = "fisheye";
  spec["pixel_mm"] = pixel_mm;
  spec["fov_rad"] = 2 * angles[199] * 1.01;
  spec["polynomial"] = {0.0, -k[0], -k[1], -k[2], -k[3]};
  return spec;
}

}  // namespace

json write_cycles_scene(const Scene& scene, const TrueView& view, const CyclesConfig& config,
                        const std::filesystem::path& folder) {
  validate(scene);
  validate(view.camera);
  std::filesystem::create_directories(folder);
  json models = json::array(), materials = json::array(), instances = json::array();
  for (std::size_t i = 0; i < scene.models.size(); ++i)
    models.push_back(json_of(scene.models[i], i, folder));
  for (const Material& material : scene.materials) materials.push_back(json_of(material));
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    auto& material = materials[static_cast<std::size_t>(instance.material)];
    if (!scene.models[static_cast<std::size_t>(instance.model)].vertex_albedo.empty())
      material["vertex_albedo"] = true;
    // Blender's index is a 15-bit number: the place in the list, from 1, may be more.
    instances.push_back(
        {{"name", instance.name},
         {"model", instance.model},
         {"material", instance.material},
         {"index", i + 1},
         {"world_from_object", array_of(world_from_object(instance, view.time_s))}});
  }
  if (scene.instances.size() > 32767)
    throw std::invalid_argument("Cycles: tells at most 32767 instances apart");
  json spec = lights_of(scene, folder);
  spec["models"] = models;
  spec["materials"] = materials;
  spec["instances"] = instances;
  spec["camera"] = camera_of(view);
  spec["settings"] = {{"threads", config.threads}, {"max_bounces", config.max_bounces}};
  return spec;
}

}  // namespace cousin
