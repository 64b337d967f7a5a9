#include "benchmarks/loop/stage_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "benchmarks/report/drawn_number.h"
#include "benchmarks/report/pictures.h"
#include "sim/geometry/measure.h"
#include "sim/imaging/image_io.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr int kNumbersQuality = 92;  ///< of the JPEG file

Image<Rgb8> crop(const Image<Rgb8>& image, int x0, int y0, int x1, int y1) {
  x0 = std::clamp(x0, 0, image.width() - 1);
  y0 = std::clamp(y0, 0, image.height() - 1);
  x1 = std::clamp(x1, x0 + 1, image.width());
  y1 = std::clamp(y1, y0 + 1, image.height());
  Image<Rgb8> result(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) result(x - x0, y - y0) = image(x, y);
  }
  return result;
}

Image<Rgb8> enlarged(const Image<Rgb8>& image, int factor) {
  Image<Rgb8> result(image.width() * factor, image.height() * factor);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) result(x, y) = image(x / factor, y / factor);
  }
  return result;
}

/// The view's image about its outlines, enlarged, with the outlines drawn in.
Image<Rgb8> with_outlines(const Image<Rgb8>& image,
                          const std::vector<const Silhouette*>& silhouettes) {
  float left = 1e9F, top = 1e9F, right = -1e9F, bottom = -1e9F;
  for (const Silhouette* s : silhouettes) {
    for (const OutlinePoint& p : s->outline) {
      left = std::min(left, p.pixel_px.x());
      right = std::max(right, p.pixel_px.x());
      top = std::min(top, p.pixel_px.y());
      bottom = std::max(bottom, p.pixel_px.y());
    }
  }
  constexpr int kMargin = 12, kZoom = 3;
  const int x0 = std::max(0, static_cast<int>(left) - kMargin),
            y0 = std::max(0, static_cast<int>(top) - kMargin);
  Image<Rgb8> picture = enlarged(
      crop(image, x0, y0, static_cast<int>(right) + kMargin, static_cast<int>(bottom) + kMargin),
      kZoom);
  for (const Silhouette* s : silhouettes) {
    for (std::size_t i = 0; i < s->outline.size(); ++i) {
      const Eigen::Vector2f a = s->outline[i].pixel_px,
                            b = s->outline[(i + 1) % s->outline.size()].pixel_px;
      const Rgb8 color = s->outline[i].on_object ? Rgb8{255, 0, 160} : Rgb8{0, 200, 255};
      for (int k = 0; k < 12; ++k) {
        const Eigen::Vector2f p = a + (b - a) * (static_cast<float>(k) / 12);
        const int x =
            static_cast<int>(std::lround((p.x() - static_cast<float>(x0) + 0.5F) * kZoom - 0.5F));
        const int y =
            static_cast<int>(std::lround((p.y() - static_cast<float>(y0) + 0.5F) * kZoom - 0.5F));
        if (picture.contains(x, y)) picture(x, y) = color;
      }
    }
  }
  return picture;
}

constexpr Rgb8 kBoxColor{255, 0, 160}, kPointColor{0, 200, 255}, kCutColor{255, 230, 0};

/// The place NAME_x, NAME_y, NAME_z of traits; NaN if they have it not.
Eigen::Vector3d place_of(const SpecimenTraits& traits, const std::string& name) {
  Eigen::Vector3d place_m = Eigen::Vector3d::Constant(kNaN);
  for (const Trait& trait : traits.traits) {
    for (int k = 0; k < 3; ++k) {
      if (trait.name == name + "_" + "xyz"[k]) place_m[k] = trait.value;
    }
  }
  return place_m;
}

/// The image with boxes of its first sensor, and crosses where each measured point and cut is seen.
Image<Rgb8> with_boxes(Image<Rgb8> image, int frame, const Camera& camera,
                       const Estimate& estimate) {
  const auto dot = [&](int x, int y, Rgb8 color) {
    if (image.contains(x, y)) image(x, y) = color;
  };
  for (const DetectedBox& box : estimate.boxes) {
    if (box.frame != frame || box.sensor != 0) continue;
    const Eigen::Vector2i low = (box.low_px.array() + 0.5).floor().cast<int>(),
                          high = (box.high_px.array() - 0.5).ceil().cast<int>();
    for (int x = low.x(); x <= high.x(); ++x) {
      dot(x, low.y(), kBoxColor);
      dot(x, high.y(), kBoxColor);
    }
    for (int y = low.y(); y <= high.y(); ++y) {
      dot(low.x(), y, kBoxColor);
      dot(high.x(), y, kBoxColor);
    }
  }
  for (const SpecimenTraits& traits : estimate.traits) {
    if (traits.frame != frame || traits.status != TraitStatus::ok) continue;
    for (const auto& [name, color] : {std::pair("point", kPointColor), {"cut", kCutColor}}) {
      const Eigen::Vector3d place_m = place_of(traits, name);
      if (!place_m.allFinite()) continue;
      const auto pixel = project(camera, place_m);
      if (!pixel) continue;
      const int x = static_cast<int>(std::lround(pixel->x())),
                y = static_cast<int>(std::lround(pixel->y()));
      for (int k = -4; k <= 4; ++k) {
        dot(x + k, y, color);
        dot(x, y + k, color);
      }
    }
  }
  return image;
}

/// The image with each specimen's number at its middle, as specimens.csv has it.
Image<Rgb8> with_numbers(Image<Rgb8> image, const SceneTruth& truth, const TrueView& view) {
  const int dot_px = std::max(1, image.width() / 480);
  for (const Instance* object : specimens_of(truth.scene)) {
    const Mesh mesh = mesh_in_world(truth.scene, *object);
    if (mesh.triangles.empty()) continue;
    const auto pixel = project_rolling(view, mass_properties(mesh).centroid_m);
    if (pixel && image.contains(static_cast<int>(pixel->x()), static_cast<int>(pixel->y())))
      write_number(image, object->id, *pixel, dot_px);
  }
  return image;
}

/// The image with a cross at each keypoint of its first sensor.
Image<Rgb8> with_keypoints(Image<Rgb8> image, int frame, const Keypoints& keypoints) {
  for (const KeypointDetection& object : keypoints) {
    if (object.frame != frame || object.sensor != 0) continue;
    for (const DetectedKeypoint& point : object.points) {
      if (!point.pixel_px.allFinite()) continue;
      const int x = static_cast<int>(std::lround(point.pixel_px.x())),
                y = static_cast<int>(std::lround(point.pixel_px.y()));
      for (int k = -4; k <= 4; ++k) {
        if (image.contains(x + k, y)) image(x + k, y) = kPointColor;
        if (image.contains(x, y + k)) image(x, y + k) = kPointColor;
      }
    }
  }
  return image;
}

/// Frames of the first, middle and last third that have a colour image of the first sensor.
std::vector<const Frame*> shown_frames(const SimulatedRun& run) {
  const std::size_t count = run.capture.frames.size();
  std::vector<const Frame*> shown;
  for (const std::size_t i : std::set{count / 6, count / 2, 5 * count / 6}) {
    if (i < count && !run.capture.frames[i].sensors[0].color.empty())
      shown.push_back(&run.capture.frames[i]);
  }
  return shown;
}

}  // namespace

SplatModel without_directions(SplatModel model) {
  model.sh_degree = 0;
  for (Splat& splat : model.splats) splat.sh_rest = {};
  return model;
}

void show_splats(const SimulatedRun&, const Estimate& estimate, ReportScene& scene) {
  scene.splats = without_directions(estimate.splats);
}

void show_boxes(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) {
  if (estimate.boxes.empty()) return;
  for (const Frame* frame : shown_frames(run)) {
    const SensorFrame& seen = frame->sensors[0];
    scene.pictures.push_back(
        {"Boxes in view " + std::to_string(frame->id),
         "magenta: boxes; crosses: where measured points (blue) and cuts (yellow) are seen",
         encode_png(enlarged(with_boxes(seen.color, frame->id, seen.reported, estimate), 2))});
  }
}

void show_keypoints(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) {
  if (estimate.keypoints.empty()) return;
  for (const Frame* frame : shown_frames(run)) {
    scene.pictures.push_back(
        {"Keypoints in view " + std::to_string(frame->id), "blue crosses",
         encode_png(with_keypoints(frame->sensors[0].color, frame->id, estimate.keypoints))});
  }
}

namespace {

/// Both side by side, so that one depth has one colour.
Image<float> beside(const Image<float>& left, const Image<float>& right) {
  constexpr int kGap_px = 8;
  Image<float> both(left.width() + kGap_px + right.width(), left.height(),
                    std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < left.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) both(x, y) = left(x, y);
    for (int x = 0; x < right.width(); ++x) both(left.width() + kGap_px + x, y) = right(x, y);
  }
  return both;
}

}  // namespace

void show_depths(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) {
  if (!estimate.clusters.cloud.empty()) return;
  const auto shown = shown_frames(run);
  for (std::size_t i = 0; i < estimate.depths.size() && i < run.truth.images.size(); ++i) {
    const FrameDepth& depth = estimate.depths[i];
    const Image<float>& truth = run.truth.images[i].depth_m;
    const bool is_shown = std::any_of(shown.begin(), shown.end(),
                                      [&](const Frame* frame) { return frame->id == depth.frame; });
    if (!is_shown || depth.depth_m.empty() || truth.height() != depth.depth_m.height()) continue;
    scene.pictures.push_back({"Depth in view " + std::to_string(depth.frame),
                              "measured, and true: near red, far blue, none grey",
                              encode_png(depth_in_color(beside(depth.depth_m, truth)))});
  }
}

void show_cloud(const SimulatedRun&, const Estimate& estimate, ReportScene& scene) {
  scene.cloud = estimate.cloud;
}

std::vector<ReportPicture> outline_pictures(const Capture& capture, const Estimate& estimate) {
  std::vector<ReportPicture> pictures;
  std::map<int, std::vector<const Silhouette*>> by_frame;
  for (const Silhouette& s : estimate.silhouettes) {
    if (!s.outline.empty()) by_frame[s.frame].push_back(&s);
  }
  const auto& frames = capture.frames;
  const std::size_t count = frames.size();
  for (const std::size_t i : std::set{count / 6, 5 * count / 6}) {
    if (i >= count || !by_frame.contains(frames[i].id)) continue;
    if (frames[i].sensors[0].color.empty()) continue;
    pictures.push_back(
        {"Outlines found in view " + std::to_string(frames[i].id),
         "magenta; blue where something else cuts them; 3 times enlarged",
         encode_png(with_outlines(frames[i].sensors[0].color, by_frame[frames[i].id]))});
  }
  return pictures;
}

void show_outlines(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) {
  for (ReportPicture& picture : outline_pictures(run.capture, estimate))
    scene.pictures.push_back(std::move(picture));
}

Mesh all_surfaces(const Estimate& estimate) {
  std::vector<Mesh> measured;
  for (const Surface& surface : estimate.surfaces) {
    if (!surface.mesh.triangles.empty()) measured.push_back(surface.mesh);
  }
  return merged(measured);
}

void show_surfaces(const SimulatedRun&, const Estimate& estimate, ReportScene& scene) {
  if (!estimate.surfaces.empty())
    scene.measured = all_surfaces(estimate);  // else stems' tubes stay
}

void show_numbers(const SimulatedRun& run, const Estimate&, ReportScene& scene) {
  const auto& frames = run.capture.frames;
  const std::size_t middle = frames.size() / 2;
  if (middle >= frames.size() || middle >= run.truth.views.size()) return;
  if (frames[middle].sensors[0].color.empty() || specimens_of(run.truth.scene).empty()) return;
  scene.pictures.push_back(
      {"Specimens by number, view " + std::to_string(frames[middle].id),
       "the numbers of specimens.csv (instance), each at its specimen's true middle",
       encode_jpeg(
           with_numbers(frames[middle].sensors[0].color, run.truth, run.truth.views[middle]),
           kNumbersQuality)});
}

}  // namespace cousin
