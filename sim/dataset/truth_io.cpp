// SCENE_DIR/truth/ (POSE and CAMERA as in rig.json; frames are those of the capture)
//   config.toml        the resolved configuration
//   seed               a decimal number
//   shared_plants.json {"shared_plants": ["..."]}: other scenes show these plants too; may be
//   absent camera.json        {"views": [{"frame", "time_s", "camera": CAMERA, "camera_from_world":
//   POSE,
//                                  "camera_from_world_end": POSE, "exposure_s", "readout_s",
//                                  "aperture_radius_m", "focus_m": null = infinity}],
//                       "other_sensors": [{"sensor", "views"}] if the rig has more than one}
//   scene.json         name, rig, board, models (name, mesh file, part names, part of each
//                      triangle), materials, instances, lights, views. An instance with "part_of"
//                      is an organ of the specimen of that id, which then has "keypoint_carriers":
//                      ids, one a keypoint of its model. "labels" of a specimen, absent where it
//                      has none: {"maturity": "low", "variety": "akihime"}. Of an organ's motion
//                      what frames see is kept. Shading (vertex albedo and normals) is not kept:
//                      configuration and seed make it again. A light
//                      {"kind": "environment", "file": "environments/000000.exr", "scale": 1}
//                      names an equirectangular OpenEXR (R, G, B; row 0 at the zenith, column 0 at
//                      azimuth -pi) below truth/; "scale", 1 if absent, multiplies it.
//   scene_gt.json      BOP's, of the specimens by id; derived from scene.json and camera.json,
//                      never read: {"0": [{"cam_R_m2c": [9], "cam_t_m2c": [3, mm],
//                                          "obj_id": model + 1, "instance_id"}]}
//   scene_gt_info.json BOP's, there if images are: {"0": [{"bbox_obj": [x, y, w, h],
//                      "bbox_visib" (-1 four times if unseen), "px_count_all", "px_count_visib",
//                      "visib_fract", "instance_id"}]}
//   traits.json        {"instances": [{"instance", "traits": [{"name", "unit", "value"}]}],
//                       "views": likewise of what all views show together, and
//                       "frames": {"0": likewise of each}: leaf_area and visible_leaf_area of the
//                      specimens; both if planned, derived, never read
//   keypoints.json     {"models": [{"model", "keypoints": [{"name", "in_object_m": [3]}]}],
//                       "frames": {"0": [{"instance", "keypoint", "state", "u_px", "v_px",
//                      "depth_m"}]}}; frames if planned; state: visible, occluded, outside;
//                      numbers null where the lens makes no image
//   models/            obj_000001.ply, ...: in the object's frame, metres
//   sensors/NAME/      what another colour sensor of the rig sees: scene_gt.json,
//                      scene_gt_info.json, keypoints.json (no models) and images, each as here.
//                      Flow, disparity and leaf areas are of the first sensor alone
// Images, each only if it was planned. Of floats: .npy, .exr, or of depths .png with a .json beside
// (truth_format.h); a reader takes the one that is there:
//   depth/000000.npy   metres; likewise normal/ and position/ (three channels), coverage/
//   coverage/          also 000000_000003.npy: shares of pixels, of frame 0's fourth specimen
//   flow/              three channels: x, y in pixels to the next view; state there: 0 no surface,
//                      1 visible, 2 occluded, 3 outside; disparity/ the same to the rig's second
//                      camera, with x turned round: x here less x there
//   noise_free_depth/  000000.npy: metres, in the pixels of the rig's depth sensor;
//   invalid_reason/    000000.png: 8 bits, why these have no depth; 0 = they have
//   instance/          16-bit PNG, id + 1; 0 = none
//   part/              16-bit PNG, place in the model's part_names (0 where it has none);
//                      65535 = none
//   mask/              000000_000003.png: amodal, 255 inside, of frame 0's fourth specimen; none of
//                      a specimen that has no pixel (px_count_all 0)
//   mask_visib/        the same of what is seen; derived from instance/, never read

#include "sim/dataset/truth_io.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/environment_io.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/truth_format.h"
#include "sim/dataset/truth_json.h"
#include "sim/dataset/truth_sensors.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/exr_color.h"
#include "sim/imaging/image_io.h"
#include "sim/truth/specimens.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kJsonLimitBytes = std::size_t{1} << 29;

std::string specimen_file(int frame, std::size_t specimen, const char* ending) {
  return six_digits(frame) + "_" + six_digits(static_cast<std::int64_t>(specimen)) + ending;
}

void check_images(const TruthImages& images, int frame, const std::vector<const Instance*>& order) {
  const std::string where = "truth: frame " + std::to_string(frame);
  if (!images.masks_full.empty() && images.masks_full.size() != images.visibility.size()) {
    throw std::invalid_argument(where + ": not one mask for each visibility");
  }
  for (const InstanceShares& shares : images.shares) {
    for (const PixelShare& p : shares.pixels) {
      if (p.x < 0 || p.y < 0 || p.x >= shares.width_px || p.y >= shares.height_px) {
        throw std::invalid_argument(where + ": instance " + std::to_string(shares.instance) +
                                    " has a share of a pixel outside the image");
      }
    }
  }
  bool in_order = images.shares.empty() || images.shares.size() == order.size();
  for (std::size_t k = 0; in_order && k < images.shares.size(); ++k)
    in_order = images.shares[k].instance == order[k]->id;
  if (!in_order) throw std::invalid_argument(where + ": shares are not of the specimens by id");
  if (images.visibility.empty()) return;
  bool same = images.visibility.size() == order.size();
  for (std::size_t k = 0; same && k < order.size(); ++k)
    same = images.visibility[k].instance == order[k]->id;
  if (!same) throw std::invalid_argument(where + ": visibility is not of the specimens by id");
}

void check_images(const std::vector<TrueView>& views, const std::vector<TruthImages>& images,
                  const std::vector<const Instance*>& order) {
  if (images.empty()) return;
  if (images.size() != views.size())
    throw std::invalid_argument("truth: not one image set for each view");
  for (std::size_t i = 0; i < images.size(); ++i) check_images(images[i], views[i].frame, order);
}

Image<std::uint16_t> instance_codes(const Image<std::int32_t>& instance, int frame) {
  Image<std::uint16_t> codes(instance.width(), instance.height());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::int32_t id = instance.data()[i];
    if (id < -1 || id > 65534) {
      throw std::invalid_argument("truth: frame " + std::to_string(frame) + ": instance " +
                                  std::to_string(id) +
                                  " is outside -1..65534, which a 16-bit PNG holds");
    }
    codes.data()[i] = static_cast<std::uint16_t>(id + 1);
  }
  return codes;
}

/// Flow and state as three channels; `sign_x` -1 makes disparity of flow.
Image<Eigen::Vector3f> match_channels(const ViewMatch& match, float sign_x) {
  Image<Eigen::Vector3f> channels(match.flow_px.width(), match.flow_px.height());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Eigen::Vector2f& flow = match.flow_px.data()[i];
    channels.data()[i] = {sign_x * flow.x(), flow.y(), static_cast<float>(match.state.data()[i])};
  }
  return channels;
}

ViewMatch match_of(const Image<Eigen::Vector3f>& channels, float sign_x, const fs::path& file) {
  ViewMatch match;
  match.flow_px = Image<Eigen::Vector2f>(channels.width(), channels.height());
  match.state = Image<PointState>(channels.width(), channels.height());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Eigen::Vector3f& c = channels.data()[i];
    if (!(c.z() == 0 || c.z() == 1 || c.z() == 2 || c.z() == 3)) {
      throw std::runtime_error(file.string() + ": state " + std::to_string(c.z()) +
                               " of a pixel is not 0, 1, 2 or 3");
    }
    match.flow_px.data()[i] = {sign_x * c.x(), c.y()};
    match.state.data()[i] = static_cast<PointState>(static_cast<int>(c.z()));
  }
  return match;
}

Image<float> share_image(const InstanceShares& shares) {
  Image<float> image(shares.width_px, shares.height_px);
  for (const PixelShare& p : shares.pixels) image(p.x, p.y) = p.share;
  return image;
}

InstanceShares shares_of(const Image<float>& image, int instance, const fs::path& file) {
  InstanceShares shares;
  shares.instance = instance;
  shares.width_px = image.width();
  shares.height_px = image.height();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float share = image(x, y);
      if (!(share >= 0 && share <= 1)) {
        throw std::runtime_error(file.string() + ": the share " + std::to_string(share) +
                                 " of pixel " + std::to_string(x) + ", " + std::to_string(y) +
                                 " is not in [0, 1]");
      }
      if (share == 0) continue;
      shares.pixels.push_back({x, y, share});
      shares.area_px += static_cast<double>(share);
    }
  }
  return shares;
}

Image<std::uint8_t> visible_mask(const Image<std::int32_t>& instance, int id) {
  Image<std::uint8_t> mask(instance.width(), instance.height());
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = instance.data()[i] == id ? 255 : 0;
  return mask;
}

/// A mask without a pixel has no file: of fifty plants a photograph shows ten.
void write_mask(const fs::path& file, const Image<std::uint8_t>& mask) {
  if (std::any_of(mask.begin(), mask.end(), [](std::uint8_t v) { return v != 0; }))
    write_png(file, mask);
}

/// Images of floats.
void write_float_images(const fs::path& dir, const TruthImages& images, int frame,
                        TruthFormat format) {
  const std::string name = "/" + six_digits(frame);
  if (!images.depth_m.empty()) write_truth_depth(dir, "depth" + name, images.depth_m, format);
  if (!images.noise_free_depth_m.empty())
    write_truth_depth(dir, "noise_free_depth" + name, images.noise_free_depth_m, format);
  if (!images.normal.empty()) write_truth_vectors(dir, "normal" + name, images.normal, format);
  if (!images.position_m.empty())
    write_truth_vectors(dir, "position" + name, images.position_m, format);
  if (!images.specimen_coverage.empty())
    write_truth_floats(dir, "coverage" + name, images.specimen_coverage, format);
  for (std::size_t k = 0; k < images.shares.size(); ++k) {
    write_truth_floats(dir, "coverage/" + specimen_file(frame, k, ""),
                       share_image(images.shares[k]), format);
  }
  if (!images.flow.state.empty())
    write_truth_vectors(dir, "flow" + name, match_channels(images.flow, 1), format);
  if (!images.stereo.state.empty())
    write_truth_vectors(dir, "disparity" + name, match_channels(images.stereo, -1), format);
}

void write_images(const fs::path& dir, const TruthImages& images, int frame,
                  const std::vector<const Instance*>& order, TruthFormat format) {
  write_float_images(dir, images, frame, format);
  const auto file = [&](const char* folder, const std::string& name) {
    fs::create_directories(dir / folder);
    return dir / folder / name;
  };
  const std::string png = six_digits(frame) + ".png";
  if (!images.part.empty()) write_png(file("part", png), images.part);
  if (!images.instance.empty()) {
    write_png(file("instance", png), instance_codes(images.instance, frame));
    for (std::size_t k = 0; k < order.size(); ++k) {
      write_mask(file("mask_visib", specimen_file(frame, k, ".png")),
                 visible_mask(images.instance, order[k]->id));
    }
  }
  for (std::size_t k = 0; k < images.masks_full.size(); ++k) {
    write_mask(file("mask", specimen_file(frame, k, ".png")), images.masks_full[k]);
  }
  if (!images.invalid_reason.empty()) write_png(file("invalid_reason", png), images.invalid_reason);
}

/// dir/folder/name by `read` if it is there, checked against the camera; else empty.
template <class Read>
auto read_if_there(const fs::path& dir, const std::string& relative, const TrueView& view,
                   const Read& read) {
  decltype(read(dir)) image;
  if (relative.empty() || !fs::exists(dir / relative)) return image;
  const fs::path file = resolve_inside(dir, relative);
  image = read(file);
  if (image.width() != view.camera.width_px || image.height() != view.camera.height_px) {
    throw std::runtime_error(file.string() + " (frame " + std::to_string(view.frame) +
                             "): the image is " + std::to_string(image.width()) + " x " +
                             std::to_string(image.height()) + " pixels; its camera has " +
                             std::to_string(view.camera.width_px) + " x " +
                             std::to_string(view.camera.height_px));
  }
  return image;
}

/// The same of an image of floats, of any of its formats.
Image<float> floats_if_there(const fs::path& dir, const std::string& stem, const TrueView& view) {
  return read_if_there(dir, float_file(dir, stem), view,
                       [](const fs::path& f) { return read_floats(f); });
}
Image<Eigen::Vector3f> vectors_if_there(const fs::path& dir, const std::string& stem,
                                        const TrueView& view) {
  return read_if_there(dir, float_file(dir, stem), view,
                       [](const fs::path& f) { return read_float_vectors(f); });
}
Image<float> depth_if_there(const fs::path& dir, const std::string& stem, const TrueView& view) {
  const std::string relative = float_file(dir, stem, depth_endings());
  return read_if_there(dir, relative, view,
                       [&](const fs::path&) { return read_truth_depth(dir, relative); });
}

void read_shares(const fs::path& dir, const TrueView& view,
                 const std::vector<const Instance*>& order, TruthImages& images) {
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::string stem = "coverage/" + specimen_file(view.frame, k, "");
    const Image<float> image = floats_if_there(dir, stem, view);
    if (image.empty()) continue;
    images.shares.push_back(shares_of(image, order[k]->id, dir / float_file(dir, stem)));
  }
  if (!images.shares.empty() && images.shares.size() != order.size()) {
    throw std::runtime_error((dir / "coverage").string() + " (frame " + std::to_string(view.frame) +
                             "): " + std::to_string(images.shares.size()) +
                             " images of shares; the scene has " + std::to_string(order.size()) +
                             " specimens");
  }
}

void read_matches(const fs::path& dir, const TrueView& view, TruthImages& images) {
  const auto read = [&](const std::string& stem, float sign_x) {
    const Image<Eigen::Vector3f> channels = vectors_if_there(dir, stem, view);
    return channels.empty() ? ViewMatch{} : match_of(channels, sign_x, dir / float_file(dir, stem));
  };
  images.flow = read("flow/" + six_digits(view.frame), 1);
  images.stereo = read("disparity/" + six_digits(view.frame), -1);
}

void read_depth_sensor(const fs::path& dir, const TrueView& view, TruthImages& images) {
  images.noise_free_depth_m =
      depth_if_there(dir, "noise_free_depth/" + six_digits(view.frame), view);
  images.invalid_reason = read_if_there(dir, "invalid_reason/" + six_digits(view.frame) + ".png",
                                        view, [](const fs::path& f) { return read_png8(f); });
}

/// Masks of all specimens; those without a pixel have no file.
void read_masks(const fs::path& dir, const TrueView& view, TruthImages& images) {
  const auto png8 = [](const fs::path& f) { return read_png8(f); };
  for (std::size_t k = 0; k < images.visibility.size(); ++k) {
    const std::string name = "mask/" + specimen_file(view.frame, k, ".png");
    Image<std::uint8_t> mask = read_if_there(dir, name, view, png8);
    if (mask.empty() && images.visibility[k].pixels_full > 0) {
      throw std::runtime_error((dir / name).string() + " (frame " + std::to_string(view.frame) +
                               "): the mask is missing; scene_gt_info.json counts " +
                               std::to_string(images.visibility[k].pixels_full) + " pixels");
    }
    if (mask.empty()) mask = Image<std::uint8_t>(view.camera.width_px, view.camera.height_px);
    images.masks_full.push_back(std::move(mask));
  }
}

/// What the truth images of a sensor take in memory, by the sizes that camera.json says.
/// @param sensor  its name; empty: the first
/// @param bytes  of the sensors before
/// @return of them and this one
std::uint64_t check_image_memory(const fs::path& truth_dir, const std::string& sensor,
                                 const std::vector<TrueView>& views, std::size_t specimens,
                                 std::uint64_t bytes) {
  struct Kind {
    const char* folder;
    std::uint64_t pixel_bytes;  ///< of what is kept
  };
  constexpr std::array<Kind, 10> kKinds = {{{"depth", 4},
                                            {"normal", 12},
                                            {"position", 12},
                                            {"coverage", 4},
                                            {"part", 2},
                                            {"instance", 4},
                                            {"flow", 9},
                                            {"disparity", 9},
                                            {"noise_free_depth", 4},
                                            {"invalid_reason", 1}}};
  const fs::path dir = truth_dir / sensor_folder(sensor);
  for (const TrueView& view : views) {
    const std::uint64_t pixels = bytes_times(static_cast<std::uint64_t>(view.camera.width_px),
                                             static_cast<std::uint64_t>(view.camera.height_px));
    std::uint64_t of_pixel = 0;
    for (const Kind& kind : kKinds) {
      const std::string stem = std::string(kind.folder) + "/" + six_digits(view.frame);
      if (!float_file(dir, stem, depth_endings()).empty()) of_pixel += kind.pixel_bytes;
    }
    if (fs::is_directory(dir / "mask")) of_pixel += specimens;
    bytes = bytes_plus(bytes, bytes_times(pixels, of_pixel));
    check_memory(truth_dir / "camera.json", bytes,
                 "the truth images up to frame " + std::to_string(view.frame));
  }
  return bytes;
}

void read_images(const fs::path& dir, const TrueView& view, TruthImages& images) {
  const auto png16 = [](const fs::path& f) { return read_png16(f); };
  const std::string name = six_digits(view.frame), png = name + ".png";
  images.depth_m = depth_if_there(dir, "depth/" + name, view);
  images.normal = vectors_if_there(dir, "normal/" + name, view);
  images.position_m = vectors_if_there(dir, "position/" + name, view);
  images.specimen_coverage = floats_if_there(dir, "coverage/" + name, view);
  images.part = read_if_there(dir, "part/" + png, view, png16);
  const Image<std::uint16_t> codes = read_if_there(dir, "instance/" + png, view, png16);
  if (!codes.empty()) {
    images.instance = Image<std::int32_t>(codes.width(), codes.height());
    for (std::size_t i = 0; i < codes.size(); ++i)
      images.instance.data()[i] = static_cast<std::int32_t>(codes.data()[i]) - 1;
  }
  if (fs::is_directory(dir / "mask")) read_masks(dir, view, images);
}

/// All images of a sensor, whose folders are in `dir`.
void read_all_images(const fs::path& dir, const std::vector<TrueView>& views,
                     const std::vector<const Instance*>& order, std::vector<TruthImages>& images) {
  for_each_frame(images.size(), [&](std::size_t i) {
    read_images(dir, views[i], images[i]);
    read_shares(dir, views[i], order, images[i]);
    read_matches(dir, views[i], images[i]);
  });
}

std::uint64_t read_seed(const fs::path& file) {
  const std::string text = read_file(file, 64);
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  const bool rest_is_newline =
      std::string_view(end, static_cast<std::size_t>(text.data() + text.size() - end)) == "\n" ||
      end == text.data() + text.size();
  if (error != std::errc{} || !rest_is_newline)
    throw std::runtime_error(file.string() + ": not a number in 0..2^64-1");
  return seed;
}

}  // namespace

void write_truth(const fs::path& scene_dir, const SceneTruth& truth, TruthFormat format) {
  validate(truth.scene);
  const std::vector<const Instance*> order = specimens_of(truth.scene);
  check_images(truth.views, truth.images, order);
  for (const SensorViews& other : truth.other_sensors)
    check_images(other.views, other.images, order);
  const fs::path dir = scene_dir / "truth";
  fs::create_directories(dir / "models");
  for (std::size_t i = 0; i < truth.scene.models.size(); ++i)
    write_ply(dir / mesh_file(i), truth.scene.models[i].mesh);
  for (std::size_t i = 0; i < truth.scene.lights.size(); ++i) {
    if (const auto* environment = std::get_if<Environment>(&truth.scene.lights[i]))
      write_exr_color(dir / environment_file(i), environment->radiance);
  }
  for_each_frame(truth.images.size(), [&](std::size_t i) {
    write_images(dir, truth.images[i], truth.views[i].frame, order, format);
  });
  for (const SensorViews& other : truth.other_sensors) {
    if (other.images.empty()) continue;
    for_each_frame(other.images.size(), [&](std::size_t i) {
      write_images(dir / sensor_folder(other.sensor), other.images[i], other.views[i].frame, order,
                   format);
    });
    write_sensor_labels(dir, truth.scene, other);
  }
  write_file(dir / "config.toml", truth.config_toml);
  write_file(dir / "seed", std::to_string(truth.seed) + "\n");
  if (!truth.shared_plants.empty())
    write_file(dir / "shared_plants.json", shared_plants_to_json(truth.shared_plants));
  write_file(dir / "camera.json", views_to_json(truth.views, truth.other_sensors));
  write_file(dir / "scene.json", scene_to_json(truth.scene));
  write_file(dir / "scene_gt.json", scene_gt_to_json(truth.scene, truth.views));
  write_file(dir / "traits.json", true_traits_to_json(truth.scene, truth.views, truth.images));
  write_file(dir / "keypoints.json", keypoints_to_json(truth.scene, truth.views, truth.images));
  if (!truth.images.empty())
    write_file(dir / "scene_gt_info.json", scene_gt_info_to_json(truth.views, truth.images));
}

void write_truth_images(const fs::path& scene_dir, const Scene& scene, int frame,
                        const TruthImages& images, TruthFormat format, const std::string& sensor) {
  const std::vector<const Instance*> order = specimens_of(scene);
  check_images(images, frame, order);
  write_images(scene_dir / "truth" / sensor_folder(sensor), images, frame, order, format);
}

SensorTruth truth_of_sensor(const SceneTruth& truth, std::size_t sensor) {
  if (sensor == 0) return {truth.views, truth.images};
  const SensorViews& other = truth.other_sensors.at(sensor - 1);
  return {other.views, other.images};
}

std::vector<std::size_t> sensors_with_truth(const SceneTruth& truth) {
  std::vector<std::size_t> sensors = {0};
  for (std::size_t s = 0; s < truth.other_sensors.size(); ++s) {
    if (!truth.other_sensors[s].images.empty()) sensors.push_back(s + 1);
  }
  return sensors;
}

SceneTruth read_truth(const fs::path& scene_dir) {
  const fs::path dir = scene_dir / "truth";
  const auto text = [&](const char* name) {
    return read_file(resolve_inside(dir, name), kJsonLimitBytes);
  };
  const auto name = [&](const char* file) { return (dir / file).string(); };
  SceneTruth truth;
  truth.config_toml = text("config.toml");
  truth.seed = read_seed(dir / "seed");
  if (fs::exists(dir / "shared_plants.json")) {
    truth.shared_plants =
        shared_plants_from_json(text("shared_plants.json"), name("shared_plants.json"));
  }
  truth.views = views_from_json(text("camera.json"), name("camera.json"), truth.other_sensors);
  SceneFiles files;
  truth.scene = scene_from_json(text("scene.json"), name("scene.json"), files);
  for_each_frame(files.meshes.size(), [&](std::size_t i) {
    truth.scene.models[i].mesh = read_mesh(resolve_inside(dir, files.meshes[i]));
  });
  for (const EnvironmentFile& e : files.environments)
    truth.scene.lights[e.light] = read_environment(resolve_inside(dir, e.file), e.scale);
  keypoints_from_json(text("keypoints.json"), name("keypoints.json"), truth.scene);
  true_traits_from_json(text("traits.json"), name("traits.json"), truth.scene);
  try {
    validate(truth.scene);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(name("scene.json") + ": " + error.what());
  }
  if (!fs::exists(dir / "scene_gt_info.json")) return truth;
  truth.images.resize(truth.views.size());
  scene_gt_info_from_json(text("scene_gt_info.json"), name("scene_gt_info.json"), truth.views,
                          truth.images);
  keypoint_views_from_json(text("keypoints.json"), name("keypoints.json"), truth.scene, truth.views,
                           truth.images);
  const std::vector<const Instance*> order = specimens_of(truth.scene);
  std::uint64_t bytes = check_image_memory(dir, "", truth.views, order.size(), 0);
  read_all_images(dir, truth.views, order, truth.images);
  for (SensorViews& other : truth.other_sensors) {
    if (other.sensor == kDepthSensor) {
      for_each_frame(truth.views.size(), [&](std::size_t i) {
        read_depth_sensor(dir, other.views[i], truth.images[i]);
      });
    }
    read_sensor_labels(dir, truth.scene, other);
    if (other.images.empty()) continue;
    bytes = check_image_memory(dir, other.sensor, other.views, order.size(), bytes);
    read_all_images(resolve_inside(dir, sensor_folder(other.sensor)), other.views, order,
                    other.images);
  }
  return truth;
}

}  // namespace cousin
