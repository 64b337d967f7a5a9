#include "sim/truth/scene_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>

namespace cousin {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& what, double value,
                       const char* limit) {
  std::ostringstream text;
  text << where << ": " << what << " = " << value << " " << limit;
  throw std::invalid_argument(text.str());
}
[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw std::invalid_argument(where + ": " + what);
}

void check_share(const std::string& where, const char* field, const Rgbf& color) {
  for (const float v : {color.r, color.g, color.b}) {
    if (!(v >= 0 && v <= 1)) fail(where, field, static_cast<double>(v), "is not in [0, 1]");
  }
}

void check_noise(const std::string& where, const std::string& field, double scale_m, int octaves) {
  const std::string scale = field + ".scale_m", count = field + ".octaves";
  if (!(scale_m > 0 && scale_m < 1e6)) fail(where, scale.c_str(), scale_m, "is not in (0, 1e6)");
  if (octaves < 1 || octaves > 12) fail(where, count.c_str(), octaves, "is not in 1..12");
}

float largest_sum(const Rgbf& a, const Rgbf& b) {
  return std::max({a.r + b.r, a.g + b.g, a.b + b.b});
}

void check_pose(const std::string& where, const char* what, const Pose& pose) {
  if (!pose.translation_m.allFinite() || !pose.rotation.coeffs().allFinite())
    fail(where, std::string(what) + " is not finite");
  if (!(std::abs(pose.rotation.norm() - 1) <= 1e-6))
    fail(where, std::string(what) + "'s rotation is not of unit norm within 1e-6");
}

/// Sums over 2^20 samples of light in float, and its squares in double, stay finite.
constexpr float kMostLight = 1e20F;

void check_light(const std::string& where, const char* field, const Rgbf& color) {
  for (const float v : {color.r, color.g, color.b}) {
    if (!(v >= 0 && v <= kMostLight))
      fail(where, field, static_cast<double>(v), "is not in [0, 1e20]");
  }
}

void check_picture(const std::string& where, const char* field, const Image<Rgbf>& picture) {
  if (picture.empty()) fail(where, std::string(field) + ": its picture has no pixels");
  if (picture.size() > std::size_t{1} << 24) {
    fail(where, std::string(field) + ": pixels of its picture", static_cast<double>(picture.size()),
         "are above 2^24");
  }
  for (const Rgbf& color : picture) check_light(where, field, color);
}

void check_camera(const std::string& where, const Camera& camera) {
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    fail(where, error.what());  // the camera does not know whose it is
  }
}

struct LightCheck {
  const std::string& where;

  void operator()(const Sun& sun) const {
    const std::string name = where + " (sun)";
    if (!sun.to_sun.allFinite() || !(sun.to_sun.norm() > 1e-6))
      fail(name, "to_sun.norm", sun.to_sun.norm(), "is zero or not finite");
    if (!(sun.angular_radius_rad > 0 && sun.angular_radius_rad < 1))
      fail(name, "angular_radius_rad", sun.angular_radius_rad, "is not in (0, 1)");
    check_light(name, "irradiance", sun.irradiance);
    const double sine = std::sin(sun.angular_radius_rad);
    const double most =
        static_cast<double>(std::max({sun.irradiance.r, sun.irradiance.g, sun.irradiance.b}));
    const double radiance = most / (std::numbers::pi * sine * sine);
    if (!(radiance <= 1e30)) fail(name, "radiance of its disk", radiance, "is above 1e30");
  }
  void operator()(const Sky& sky) const {
    const std::string name = where + " (sky)";
    check_light(name, "zenith", sky.zenith);
    check_light(name, "horizon", sky.horizon);
    check_light(name, "ground", sky.ground);
  }
  void operator()(const Lamp& lamp) const {
    const std::string name = where + " (lamp)";
    if (!lamp.centre_in_world_m.allFinite()) fail(name, "centre_in_world_m is not finite");
    if (!lamp.axis_u_m.allFinite() || !lamp.axis_v_m.allFinite())
      fail(name, "an axis is not finite");
    const double area_m2 = 4 * lamp.axis_u_m.cross(lamp.axis_v_m).norm();
    if (!(area_m2 >= 1e-24 && area_m2 <= 1e24))
      fail(name, "area between its axes, m2", area_m2, "is not in [1e-24, 1e24]");
    check_light(name, "radiance", lamp.radiance);
  }
  void operator()(const ClearSky& sky) const {
    const std::string name = where + " (clear sky)";
    if (!sky.to_sun.allFinite() || !(sky.to_sun.norm() > 1e-6))
      fail(name, "to_sun.norm", sky.to_sun.norm(), "is zero or not finite");
    if (!(sky.to_sun.z() >= 0)) fail(name, "to_sun.z", sky.to_sun.z(), "is below the horizon");
    if (!(sky.turbidity >= 1.7 && sky.turbidity <= 10))
      fail(name, "turbidity", sky.turbidity, "is not in [1.7, 10]");
    if (!(sky.angular_radius_rad > 0 && sky.angular_radius_rad <= 0.1))
      fail(name, "angular_radius_rad", sky.angular_radius_rad, "is not in (0, 0.1]");
    if (!(sky.scale >= 0 && sky.scale < 1e12))
      fail(name, "scale", sky.scale, "is not in [0, 1e12)");
    check_share(name, "ground_albedo", sky.ground_albedo);
  }
  void operator()(const Projector& projector) const {
    const std::string name = where + " (projector)";
    check_camera(name, projector.lens);
    check_picture(name, "intensity", projector.intensity);
    if (projector.intensity.width() != projector.lens.width_px ||
        projector.intensity.height() != projector.lens.height_px) {
      fail(name, "its picture and its lens differ in size");
    }
    check_pose(name, "its pose", projector.world_from_projector);
  }
  void operator()(const Environment& environment) const {
    check_picture(where + " (environment)", "radiance", environment.radiance);
  }
};

void check_model(const ObjectModel& model, const std::string& where) {
  const std::size_t vertices = model.mesh.vertices_m.size();
  const std::size_t triangles = model.mesh.triangles.size();
  for (std::size_t i = 0; i < vertices; ++i) {
    if (!model.mesh.vertices_m[i].allFinite())
      fail(where, "vertex " + std::to_string(i) + " is not finite");
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    for (const std::uint32_t index : model.mesh.triangles[i]) {
      if (index >= vertices) {
        fail(where, "triangle " + std::to_string(i) + ": a triangle's index is beyond the " +
                        std::to_string(vertices) + " vertices");
      }
    }
  }
  if (!model.vertex_albedo.empty() && model.vertex_albedo.size() != vertices)
    fail(where, "vertex_albedo has another size than the vertices");
  for (const Rgbf& color : model.vertex_albedo) check_share(where, "vertex_albedo", color);
  if (!model.vertex_normals.empty() && model.vertex_normals.size() != vertices)
    fail(where, "vertex_normals has another size than the vertices");
  for (const Eigen::Vector3f& normal : model.vertex_normals) {
    if (!normal.allFinite()) fail(where, "a vertex normal is not finite");
  }
  if (!model.triangle_part.empty() && model.triangle_part.size() != triangles)
    fail(where, "triangle_part has another size than the triangles");
}

void check_instance(const Instance& instance, const Scene& scene, const std::string& where) {
  if (instance.model < 0 || instance.model >= static_cast<int>(scene.models.size()))
    fail(where, "no such model");
  if (instance.material < 0 || instance.material >= static_cast<int>(scene.materials.size()))
    fail(where, "no such material");
  const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
  if (!instance.part_materials.empty() &&
      instance.part_materials.size() != model.part_names.size()) {
    fail(where, "part_materials.size", static_cast<double>(instance.part_materials.size()),
         "is not the number of its model's parts");
  }
  for (const int material : instance.part_materials) {
    if (material < 0 || material >= static_cast<int>(scene.materials.size()))
      fail(where, "no such part material", material, "in the scene");
    if (scene.materials[static_cast<std::size_t>(material)].kind == SurfaceKind::clear)
      fail(where, "part material", material, "is clear: water is an instance of its own");
  }
  for (const std::uint16_t part : model.triangle_part) {
    if (!instance.part_materials.empty() && part >= instance.part_materials.size())
      fail(where, "no material of part", part, "of its model");
  }
  for (std::size_t i = 0; i < instance.labels.size(); ++i) {
    if (instance.labels[i].name.empty() || instance.labels[i].value.empty())
      fail(where, "a label has an empty name or value");
    if (i > 0 && instance.labels[i].name <= instance.labels[i - 1].name)
      fail(where,
           "its labels are not sorted by name, each once: \"" + instance.labels[i].name + "\"");
  }
  check_pose(where, "its pose", instance.world_from_object);
  for (std::size_t i = 0; i < instance.motion.size(); ++i) {
    const TimedPose& step = instance.motion[i];
    check_pose(where, "a pose of its motion", step.world_from_object);
    if (!std::isfinite(step.time_s) || (i > 0 && !(step.time_s > instance.motion[i - 1].time_s)))
      fail(where, "its motion is not sorted by finite times");
  }
}

/// Links between organs and specimens. @param by_id  every instance of the scene
void check_links(const Instance& instance, const std::map<int, const Instance*>& by_id,
                 const Scene& scene, const std::string& where) {
  const auto find = [&](int id) -> const Instance* {
    const auto found = by_id.find(id);
    return found == by_id.end() ? nullptr : found->second;
  };
  const auto model_of = [&](const Instance& of) -> const ObjectModel& {
    return scene.models[static_cast<std::size_t>(of.model)];
  };
  if (instance.part_of != -1) {
    const Instance* whole = find(instance.part_of);
    if (!whole) fail(where, "part_of", instance.part_of, "is no instance of the scene");
    if (whole->part_of != -1 || whole == &instance)
      fail(where, "part_of", instance.part_of, "is an organ itself: links have no chains");
    if (!whole->is_specimen) fail(where, "part_of", instance.part_of, "is no specimen");
    if (instance.is_specimen || !instance.traits.empty() || !instance.labels.empty() ||
        !instance.keypoint_carriers.empty())
      fail(where, "is an organ, and so no specimen, without traits, labels and keypoint_carriers");
    if (model_of(instance).part_names != model_of(*whole).part_names)
      fail(where, "its model's part_names are not those of its specimen \"" + whole->name + "\"");
  }
  const auto& carriers = instance.keypoint_carriers;
  if (!carriers.empty() && carriers.size() != model_of(instance).keypoints.size()) {
    fail(where, "keypoint_carriers.size", static_cast<double>(carriers.size()),
         "is not the number of its model's keypoints");
  }
  for (const int id : carriers) {
    const Instance* carrier = find(id);
    if (!carrier || (carrier != &instance && carrier->part_of != instance.id))
      fail(where, "a keypoint's carrier", id, "is neither itself nor one of its organs");
  }
}

}  // namespace

void validate(const Material& m) {
  const std::string where = "material \"" + m.name + "\"";
  check_share(where, "albedo", m.albedo);
  check_share(where, "transmittance", m.transmittance);
  check_share(where, "ink_albedo", m.ink_albedo);
  if (m.back_albedo) check_share(where, "back_albedo", *m.back_albedo);
  if (m.kind == SurfaceKind::leaf) {
    for (const Rgbf& side : {m.albedo, m.back_albedo.value_or(m.albedo)}) {
      const float sum = largest_sum(side, m.transmittance);
      if (!(sum <= 1.00001F))
        fail(where, "albedo + transmittance", static_cast<double>(sum), "is above 1");
    }
  }
  const bool is_glass = m.kind == SurfaceKind::glass || m.kind == SurfaceKind::clear;
  if (!(m.ior >= 1 && m.ior <= 10) || (is_glass && m.ior == 1))
    fail(where, "ior", m.ior, is_glass ? "is not in (1, 10]" : "is not in [1, 10]");
  if (!(m.roughness >= 0.05 && m.roughness <= 1))
    fail(where, "roughness", m.roughness, "is not in [0.05, 1]");
  for (const float v : {m.mean_free_path_m.r, m.mean_free_path_m.g, m.mean_free_path_m.b}) {
    if (!(v >= 0 && v <= 1e6F))
      fail(where, "mean_free_path_m", static_cast<double>(v), "is not in [0, 1e6]");
    if (v > 0 && m.kind != SurfaceKind::coated)
      fail(where, "mean_free_path_m", static_cast<double>(v), "needs a surface that is coated");
  }
  if (m.noise) {
    check_share(where, "noise.other_albedo", m.noise->other_albedo);
    check_noise(where, "noise", m.noise->scale_m, m.noise->octaves);
  }
  if (m.infrared_noise) {
    const InfraredTexture& t = *m.infrared_noise;
    const float sum = t.other_albedo + m.infrared_transmittance;
    if (!(t.other_albedo >= 0 && sum <= 1.00001F)) {
      fail(where, "infrared_noise.other_albedo", static_cast<double>(t.other_albedo),
           "is negative or above 1 - infrared_transmittance");
    }
    check_noise(where, "infrared_noise", t.scale_m, t.octaves);
  }
  if (!(m.infrared_albedo >= 0 && m.infrared_albedo <= 1))
    fail(where, "infrared_albedo", static_cast<double>(m.infrared_albedo), "is not in [0, 1]");
  const float infrared = m.infrared_albedo + m.infrared_transmittance;
  if (!(m.infrared_transmittance >= 0 && infrared <= 1.00001F)) {
    fail(where, "infrared_transmittance", static_cast<double>(m.infrared_transmittance),
         "is negative or above 1 - infrared_albedo");
  }
}

void validate(const Light& light, const std::string& where) {
  std::visit(LightCheck{where}, light);
}

void validate(const TrueView& view) {
  const std::string where = "view of frame " + std::to_string(view.frame);
  check_camera(where, view.camera);
  check_pose(where, "its pose", view.camera_from_world);
  check_pose(where, "its pose at the end", view.camera_from_world_end);
  if (!std::isfinite(view.time_s)) fail(where, "time_s", view.time_s, "is not finite");
  const auto positive = [&](const char* field, double value) {
    if (!(value >= 0 && std::isfinite(value)))
      fail(where, field, value, "is negative or not finite");
  };
  positive("exposure_s", view.exposure_s);
  positive("readout_s", view.readout_s);
  positive("aperture_radius_m", view.aperture_radius_m);
  if (!(view.focus_m > 0)) fail(where, "focus_m", view.focus_m, "is not above 0");
}

void validate(const Scene& scene) {
  const std::string prefix = "scene \"" + scene.name + "\", ";
  for (const ObjectModel& model : scene.models)
    check_model(model, prefix + "model \"" + model.name + "\"");
  for (const Material& material : scene.materials) validate(material);
  std::set<int> ids;
  for (const Instance& instance : scene.instances) {
    const std::string where = prefix + "instance \"" + instance.name + "\"";
    if (instance.id < 0 || !ids.insert(instance.id).second)
      fail(where, "its id is negative or not unique");
    check_instance(instance, scene, where);
  }
  std::map<int, const Instance*> by_id;
  for (const Instance& instance : scene.instances) by_id[instance.id] = &instance;
  for (const Instance& instance : scene.instances)
    check_links(instance, by_id, scene, prefix + "instance \"" + instance.name + "\"");
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    validate(scene.lights[i], prefix + "light " + std::to_string(i));
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const std::string where = prefix + "view " + std::to_string(i);
    check_pose(where, "its pose", scene.views[i].rig_from_world);
    check_pose(where, "its pose at the end", scene.views[i].rig_from_world_end);
    if (!scene.views[i].focus_in_world_m.allFinite()) fail(where, "its focus is not finite");
    if (!std::isfinite(scene.views[i].time_s)) fail(where, "its time is not finite");
  }
}

}  // namespace cousin
