#include "scenes/boards/boards_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/boards/board_video.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 2;    ///< from view to view
constexpr double kRest_s = 0.8;  ///< a hand keeps the board still this long before and after

int add_material(Scene& scene, const char* name, const std::vector<double>& albedo,
                 const std::vector<double>& dark, double scale_m) {
  Material material;
  material.name = name;
  material.albedo = to_rgb(color_vector(albedo));
  material.roughness = 0.6;
  material.ior = 1.4;
  if (scale_m > 0) material.noise = NoiseTexture{to_rgb(color_vector(dark)), scale_m, 5};
  scene.materials.push_back(std::move(material));
  return static_cast<int>(scene.materials.size()) - 1;
}

/// A box about a middle; outward.
Mesh box(const Vector3d& middle_m, const Vector3d& half_m) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k) {
    const Vector3d sign(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    mesh.vertices_m.emplace_back(middle_m + sign.cwiseProduct(half_m));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Instance& add_thing(Scene& scene, const char* name, Mesh mesh, int material) {
  ObjectModel model;
  model.name = name;
  model.mesh = std::move(mesh);
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = instance.category = name;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = material;
  scene.models.push_back(std::move(model));
  scene.instances.push_back(std::move(instance));
  return scene.instances.back();
}

/// Upright, face towards -y: the print's x stays, its y goes up.
Pose upright(const Vector3d& at_m) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitX())), at_m};
}

double least_z(const Mesh& mesh) {
  double least = 0;
  for (const Vector3d& v : mesh.vertices_m) least = std::min(least, v.z());
  return least;
}

double half_height_m(const BoardsSceneConfig& config) {
  return 0.5 * print_size_m(config.target).y() + config.body.margin_m;
}

/// Where the board rests, or of a hand-held one where the light is aimed.
Pose resting_place(const BoardsSceneConfig& config, const Mesh& board) {
  const auto& place = config.setting.place;
  if (config.place == "table")
    return {Eigen::Quaterniond::Identity(), {0, 0, place.table_m - least_z(board) + 2e-4}};
  return upright({0, 0, std::max(place.stand_m, half_height_m(config) + 0.1)});
}

/// A panel or lamp that faces the board, off to its upper right or left.
Lamp make_lamp(const Pose& world_from_board, const Vector3d& direction, double distance_m,
               double half_m, double radiance) {
  const Vector3d towards = world_from_board.rotation * -direction.normalized();
  const Vector3d u = Vector3d::UnitX().cross(towards).normalized();
  const auto grey = static_cast<float>(radiance);
  return {world_from_board.translation_m - distance_m * towards,
          u * half_m,
          towards.cross(u).normalized() * half_m,
          {grey, grey, grey}};
}

void add_light(Scene& scene, const BoardsSceneConfig& config, const Pose& world_from_board) {
  const auto& c = config.setting.light;
  const auto room = [&](double radiance) {
    const auto v = static_cast<float>(radiance);
    scene.lights.emplace_back(Sky{{v, v, v}, {v, v, v}, {0.7F * v, 0.7F * v, 0.7F * v}});
  };
  if (config.light == "soft") {
    room(c.soft_room);
    scene.lights.emplace_back(make_lamp(world_from_board, {0.5, 0.9, 1.3}, 2.5, 0.8, c.soft_panel));
  } else if (config.light == "hard") {
    room(c.hard_room);
    scene.lights.emplace_back(
        make_lamp(world_from_board, {-0.35, 0.55, 1.0}, 2.0, 0.03, c.hard_lamp));
  } else {
    ClearSky sky;
    const double e = c.sun_elevation_rad;
    sky.to_sun = {0.3 * std::cos(e), -std::sqrt(0.91) * std::cos(e), std::sin(e)};
    sky.turbidity = c.sun_turbidity;
    sky.scale = c.sun_scale;
    sky.ground_albedo = to_rgb(color_vector(config.setting.place.floor_albedo));
    scene.lights.emplace_back(sky);
  }
}

int add_board(Scene& scene, const BoardsSceneConfig& config, ObjectModel model) {
  const int first = static_cast<int>(scene.materials.size());
  for (Material& material : board_materials(config.body))
    scene.materials.push_back(std::move(material));
  Instance board;
  board.id = static_cast<int>(scene.instances.size());
  board.name = "board";
  board.category = std::string(to_string(config.target.kind));
  board.is_specimen = true;
  board.model = static_cast<int>(scene.models.size());
  board.material = first;
  board.part_materials = {first, first + 1, first + 2};
  board.traits = board_traits(config.target, config.flaws, model);
  scene.models.push_back(std::move(model));
  scene.instances.push_back(std::move(board));
  return scene.instances.back().id;
}

/// The bar that holds the board, in the board's frame: behind it and down to `length_m` below its
/// middle.
Mesh bar(const BoardsSceneConfig& config, const Mesh& board, double length_m) {
  constexpr double kHalf_m = 0.0125;
  return box({0, -0.5 * length_m, least_z(board) - kHalf_m - 2e-4},
             {kHalf_m, 0.5 * length_m, kHalf_m * (config.place == "hand" ? 0.6 : 1)});
}

/// The plate that a stand's bar is welded to, on the floor, in the board's frame.
void add_foot(Mesh& bar, const Mesh& board, double floor_y_m) {
  constexpr double kHalf_m = 0.006;
  const Mesh plate = box({0, floor_y_m + kHalf_m, least_z(board) - 0.0125}, {0.18, kHalf_m, 0.14});
  const auto first = static_cast<std::uint32_t>(bar.vertices_m.size());
  bar.vertices_m.insert(bar.vertices_m.end(), plate.vertices_m.begin(), plate.vertices_m.end());
  for (const auto& t : plate.triangles)
    bar.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void add_room(Scene& scene, const BoardsSceneConfig& config, double wall_y_m) {
  const auto& c = config.setting.place;
  constexpr double kHalf_m = 8;
  add_thing(scene, "floor", box({0, 0, -0.05}, {kHalf_m, kHalf_m, 0.05}),
            add_material(scene, "floor", c.floor_albedo, c.floor_albedo, 0));
  if (config.place == "table") {
    add_thing(scene, "table", box({0, 0, c.table_m - 0.02}, {0.8, 0.45, 0.02}),
              add_material(scene, "wood", c.table_albedo, c.table_dark, 0.03));
    return;
  }
  if (config.light == "sun") return;  // outdoors
  add_thing(scene, "wall", box({0, wall_y_m + 0.05, 1.5}, {kHalf_m, 0.05, 1.5}),
            add_material(scene, "paint", c.wall_albedo, c.wall_dark, 0.25));
}

View make_view(double time_s, const Pose& rig_from_world, const Vector3d& focus_in_world_m) {
  View view;
  view.time_s = time_s;
  view.rig_from_world = view.rig_from_world_end = rig_from_world;
  view.focus_in_world_m = focus_in_world_m;
  return view;
}

/// The camera goes around the board.
void add_views_around(Scene& scene, const BoardsSceneConfig& config, const Pose& world_from_board,
                      const Rng& rng) {
  const double lowest_m = config.place == "table" ? config.setting.place.table_m + 0.05 : 0.15;
  const auto is_free = [&](const Pose& camera_from_board) {
    return (world_from_board * centre_in_world_m(camera_from_board)).z() > lowest_m;
  };
  const auto rig_from_world = [&](const Pose& camera_from_board) {
    return inverse(config.eye_from_rig) * camera_from_board * inverse(world_from_board);
  };
  const Vector3d& focus_m = world_from_board.translation_m;
  if (config.plan != "video") {
    const std::vector<Pose> poses = board_poses(config, is_free, rng);
    for (std::size_t i = 0; i < poses.size(); ++i)
      scene.views.push_back(
          make_view(kStep_s * static_cast<double>(i), rig_from_world(poses[i]), focus_m));
    return;
  }
  const auto& video = config.setting.video;
  const double length_s = (config.views - 1) / video.rate_hz + config.readout_s;
  BoardsSceneConfig stations = config;
  stations.views = PosePath::pose_count(length_s, video.pose_step_s);
  const PosePath path(board_poses(stations, is_free, rng), video.pose_step_s);
  for (int i = 0; i < config.views; ++i) {
    const double time_s = i / video.rate_hz;
    View view = make_view(time_s, rig_from_world(path.at(time_s)), focus_m);
    view.rig_from_world_end = rig_from_world(path.at(time_s + config.readout_s));
    scene.views.push_back(view);
  }
}

/// The board goes about before a camera that stays; things from `first` on are held together.
/// @return how far it goes from the camera
double add_views_of_held(Scene& scene, const BoardsSceneConfig& config,
                         const std::vector<int>& held, const Rng& rng) {
  const Pose camera_from_world =
      look_at({0, 0, config.setting.place.stand_m}, {0, 1, config.setting.place.stand_m});
  const Pose rig_from_world = inverse(config.eye_from_rig) * camera_from_world;
  const Pose world_from_camera = inverse(camera_from_world);
  const auto is_free = [&](const Pose& camera_from_board) {
    const Vector3d middle = (world_from_camera * camera_from_board).translation_m;
    return middle.z() > 0.1 + half_height_m(config);
  };
  const std::vector<Pose> poses = board_poses(config, is_free, rng);
  double farthest_m = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose world_from_board = world_from_camera * poses[i];
    const double time_s = kStep_s * static_cast<double>(i);
    for (const int id : held) {
      Instance& instance = scene.instances[static_cast<std::size_t>(id)];
      instance.motion.push_back({time_s - kRest_s, world_from_board});
      instance.motion.push_back({time_s + kRest_s, world_from_board});
      if (i == 0) instance.world_from_object = world_from_board;
    }
    farthest_m = std::max(farthest_m, world_from_board.translation_m.y());
    scene.views.push_back(make_view(time_s, rig_from_world, world_from_board.translation_m));
  }
  return farthest_m + half_height_m(config);
}

}  // namespace

Scene build_boards_scene(const BoardsSceneConfig& config, Rng rng) {
  validate(config);
  Scene scene;
  scene.name = "boards";
  scene.rig = config.rig;
  scene.board = to_text(config.target);
  ObjectModel model = board_model(config.target, config.flaws, config.body);
  const Pose rest = resting_place(config, model.mesh);
  const bool is_held = config.place == "hand";
  Mesh holder;
  if (is_held) holder = bar(config, model.mesh, half_height_m(config) + 0.45);
  if (config.place == "stand") {
    holder = bar(config, model.mesh, rest.translation_m.z());
    add_foot(holder, model.mesh, -rest.translation_m.z());
  }
  const int board = add_board(scene, config, std::move(model));
  scene.instances[static_cast<std::size_t>(board)].world_from_object = rest;
  std::vector<int> held = {board};
  if (!holder.vertices_m.empty()) {
    const int metal =
        add_material(scene, "bar", config.body.plate_albedo, config.body.plate_albedo, 0);
    Instance& bar_instance = add_thing(scene, "bar", std::move(holder), metal);
    bar_instance.world_from_object = rest;
    held.push_back(bar_instance.id);
  }
  double wall_y_m = config.setting.place.wall_m;
  if (is_held) {
    wall_y_m += add_views_of_held(scene, config, held, rng.fork("views"));
  } else {
    add_views_around(scene, config, rest, rng.fork("views"));
  }
  add_room(scene, config, wall_y_m);
  Pose lit = rest;
  if (is_held) lit.translation_m.y() = wall_y_m - config.setting.place.wall_m;
  add_light(scene, config, lit);
  validate(scene);
  return scene;
}

}  // namespace cousin
