#include "benchmarks/app/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <sstream>
#include <string_view>
#include <vector>

#include "benchmarks/app/command_line_help.h"
#include "benchmarks/app/command_line_mistakes.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

void add_set(CLI::App& verb, Options& o) {
  verb.add_option("--set", o.sets, "Configuration key=value; repeatable. `--keys` lists the keys")
      ->type_size(1)
      ->allow_extra_args(false);
  verb.add_flag("--keys", o.keys,
                "List the configuration keys with defaults and limits, and leave");
}

void add_config(CLI::App& verb, Options& o) {
  verb.add_option("--config", o.config,
                  "TOML file as a result's config.toml; --set comes after it");
}

void add_stages(CLI::App& verb, Options& o) {
  verb.add_option("--stage-time-limit", o.stage_time_limit_s,
                  "Seconds after which a PROGRAM of --stage is ended, with all that it started")
      ->check(CLI::Range(1e-3, 1e9))
      ->capture_default_str();
  verb.add_option(
      "--method", o.method,
      "of seeds ours (default), paper, splats, splats_paper, sensor_depth, depth_only; see "
      "`cousin methods`");
  verb.add_option("--stage", o.stages,
                  "NAME=dir:PATH or NAME=exec:PROGRAM in place of a stage; repeatable")
      ->type_size(1)
      ->allow_extra_args(false);
}

constexpr const char* kLpipsOfViews =
    "--pipeline scene: TorchScript network that images are scored by too: LPIPS, or any of two "
    "images of 1 x 3 x height x width from -1 to 1";
constexpr const char* kCalibrateHelp =
    "Calibrate cameras from images of a board, and say what the calibration is worth. Writes\n"
    "calibration.json, report.html (coverage, residuals, uncertainty, what to shoot next) and\n"
    "opencv/, ros/, kalibr/, mrcal/ and colmap/ files; exit code 1 and no such files where the\n"
    "images do not determine the cameras or the lens model does not fit.\n\n"
    "FOLDER holds photographs of one camera (PNG, JPEG), or left* and right* of a stereo head;\n"
    "a dataset of `cousin render boards` names its own board. Boards:\n"
    "  chessboard:6x4:0.030             inner corners, side of a square in metres\n"
    "  charuco:11x8:0.022:0.73:DICT_4X4_50\n"
    "                                   squares, side, marker over square, dictionary\n"
    "  aprilgrid:6x6:0.022:0.3          tags, side of a tag, space over tag (Kalibr's)\n"
    "  circles:8x6:0.030[:0.3]          discs, distance of centres, radius over distance\n"
    "  acircles:4x11:0.018[:0.42]       discs in staggered rows, distance of rows\n"
    "--set rolling_shutter=true solves for the line delay of a moving camera: from a dataset's "
    "time\n"
    "stamps, or of a folder that is a video with --set frame_rate_hz=30. A depth camera's dataset\n"
    "compares the registration that the device reports with the one found.\n"
    "Lens models: pinhole, opencv5, opencv8, opencv12, kannala_brandt4, splined_stereographic.\n"
    "See docs/calibration.md.";

void add_calibrate(CLI::App& verb, Options& o) {
  verb.add_option("FOLDER", o.arguments, "Dataset, or folder of photographs")->expected(0, 1);
  verb.add_option("--board", o.board, "The board, as above; a dataset's own if not given");
  verb.add_option("--model", o.model, "Lens model; default opencv5");
  verb.add_option("--solver", o.solver, "ceres (default where built in), opencv or mrcal");
  verb.add_option("--fix", o.fixed, "Parameters that stay 0 or at their start, such as k3,p1,p2");
  add_config(verb, o);
  add_set(verb, o);
}

constexpr const char* kLedgerHelp =
    "Say what a real capture will give before it is measured, and keep what came of it.\n\n"
    "  ledger show                            predictions, outcomes, and what they are worth\n"
    "  ledger predict ID SET WHAT LOW HIGH    with --unit and --why\n"
    "  ledger outcome ID VALUE COMMAND        what the command printed\n"
    "  ledger seen SET                        with --why: its results are known already\n\n"
    "The file only grows. An outcome counts where its line's commit is after its prediction's.";
constexpr const char* kImportHelp =
    "Make a dataset of another program's or a camera's capture.\n\n"
    "  rgbd         rgb/ and depth/ (16-bit PNG, or floats in metres), or files such as\n"
    "               a_rgb.png and a_depth.png, with intrinsics.json or --intrinsics\n"
    "  stereo       left/ and right/ (or image_2 and image_3, cam0 and cam1, im0.png and im1.png)\n"
    "               with stereo.yaml, calib.txt or --intrinsics\n"
    "  tum          a TUM RGB-D sequence: rgb.txt, depth.txt, groundtruth.txt\n"
    "  nerfstudio   transforms.json of nerfstudio, instant-ngp or Blender, with its images\n"
    "  colmap       a workspace: images/ and a sparse model, text or binary\n"
    "  phenomenal   a turntable cabin's calibration and silhouettes\n"
    "  folder       photographs of one camera, without poses\n"
    "  video        a video of one camera: its sharpest frames, evenly spread (needs ffmpeg)\n"
    "  coco         labelled photographs: annotations beside their images; labels are truth\n"
    "  yolo         the same as data.yaml names them, or images/ and labels/\n\n"
    "folder and video without --intrinsics: the focal length is that of EXIF, else found by\n"
    "self-calibration (needs colmap), else assumed; a warning says which, and how sure it is.\n"
    "rosbag2: scripts/rosbag2_to_rgbd.py makes a folder for rgbd. docs/import.md has an example "
    "of\n"
    "each; docs/formats.md says what is read.";

void add_import(CLI::App& verb, Options& o) {
  verb.add_option("SOURCE", o.arguments, "File or folder")->expected(1, 1)->required();
  verb.add_option("--format", o.format,
                  "rgbd, stereo, tum, nerfstudio, colmap, phenomenal, folder, video; with labels "
                  "coco or yolo")
      ->required();
  verb.add_option("--intrinsics", o.intrinsics,
                  "For folder, video, tum and rgbd: a YAML file (OpenCV, ROS, Kalibr), a "
                  ".cameramodel, a rig.json or \"fx,fy,cx,cy[,k1,k2,p1,p2,k3]\"; for rgbd also a "
                  "file of a colour and a depth camera; for stereo a file of two cameras");
  verb.add_option("--depth-unit", o.depth_unit_m,
                  "For rgbd, tum and nerfstudio: metres a unit of the depth images, as 0.001 of "
                  "millimetres; default: what rgbd's intrinsics say, tum 0.0002, nerfstudio 0.001")
      ->check(CLI::Range(1e-6, 1.0));
  verb.add_option("--length-unit", o.length_unit_m,
                  "For stereo and rgbd: metres a unit of the distance between the two cameras, as "
                  "0.001 of millimetres; default: 1, or as the format says")
      ->check(CLI::Range(1e-6, 1.0));
  verb.add_option("--frames", o.frames, "For video: how many frames; 0 = 60")
      ->check(CLI::Range(0, 1000));
}

constexpr const char* kBoardHelp =
    "Write a board as a PDF in its true size, with a ruler to check the print and two pages on "
    "how\n"
    "to use it; or the board alone as SVG. BOARD is seeds (the plate that seeds are measured on),\n"
    "charuco_a4, chessboard_a4, aprilgrid_a4, circles_a4, acircles_a4 and the like, or kind and\n"
    "sizes as `cousin calibrate --board` takes them, which reads the same name.";

constexpr const char* kExportHelp =
    "Write a dataset as other programs read it; the dataset stays the source of truth.\n\n"
    "  Labels of the first sensor's pictures (render with --truth visibility,instance,keypoints)\n"
    "  bop          train|val|test/000000 with masks, poses and depth, models in mm, true pinhole\n"
    "               cameras\n"
    "  coco         annotations/train.json, ...: boxes, masks, keypoints, visible_fraction\n"
    "  yolo         data.yaml, images/ and labels/ for --task detect, segment or pose\n"
    "  Posed pictures, a folder a scene (--true-cameras where the rig knows no poses)\n"
    "  colmap       images/, sparse/0 binary, sparse_txt text\n"
    "  nerfstudio   images/, transforms.json\n"
    "  tum          rgb.txt, depth.txt, groundtruth.txt, camera.yaml\n"
    "  Calibrations, a folder a scene\n"
    "  opencv       SENSOR.yaml of FileStorage, with R and T from the first camera\n"
    "  ros          SENSOR.yaml of camera_info\n"
    "  kalibr       camchain.yaml\n"
    "  mrcal        SENSOR.cameramodel\n"
    "  Scenes, by Blender, which must be installed\n"
    "  gltf, blend  000000.glb or .blend: meshes, materials, lights, the first view's camera\n\n"
    "`cousin export kit` writes no dataset but the simulator's own seeds and fruits for a 3D\n"
    "printer: STL files in millimetres and a table of their exact traits; --seed draws others.\n\n"
    "docs/formats.md says what each can and cannot hold.";

/// A number from `least` to `most`; CLI11's range alone takes NaN for one.
CLI::Validator number(double least, double most) {
  return CLI::Range(least, most) & CLI::Validator(
                                       [](const std::string& text) {
                                         return text.find_first_of("nN") == std::string::npos
                                                    ? std::string()
                                                    : "is no number";
                                       },
                                       "");
}

void add_category(CLI::App& verb, Options& o, const std::string& of) {
  verb.add_option("--category", o.category,
                  of + "label of the specimens that their classes are named by, as maturity or "
                       "variety; without it the dataset's categories");
}

void add_export(CLI::App& verb, Options& o) {
  verb.add_option("DATASET", o.arguments, "Dataset, simulated or imported; or kit")
      ->expected(1, 1)
      ->required();
  verb.add_option("--format", o.format,
                  "bop, coco, yolo, colmap, nerfstudio, tum, opencv, ros, kalibr, mrcal, gltf or "
                  "blend");
  verb.add_flag("--undistort", o.undistort,
                "Pictures, labels and cameras as a pinhole camera in the same place would have "
                "them");
  verb.add_flag("--true-cameras", o.true_cameras,
                "True lenses and poses in place of what the rig reports");
  verb.add_option("--split", o.split,
                  "bop, coco, yolo: shares of train, val and test. Scenes of the same plants stay "
                  "together")
      ->capture_default_str();
  verb.add_option("--masks", o.masks, "coco: rle or polygon, both of the very pixels")
      ->capture_default_str();
  verb.add_option("--task", o.task, "yolo: detect, segment or pose")->capture_default_str();
  add_category(verb, o, "coco, yolo: ");
  verb.add_option("--least-visible", o.least_visible,
                  "coco, yolo: leave out objects of which a smaller share is seen")
      ->check(number(0, 1))
      ->capture_default_str();
}

/// A whole number in decimal digits, from `least` to `most`; others are refused with both.
template <class Number>
CLI::Validator whole_number(Number least, Number most) {
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  return {[least, most, range](std::string& text) -> std::string {
            Number value{};
            const auto [end, error] =
                std::from_chars(text.data(), text.data() + text.size(), value);
            const bool is_whole = error == std::errc{} && end == text.data() + text.size();
            if (is_whole && value >= least && value <= most) return {};
            return "\"" + text + "\" is not a whole number from " + range;
          },
          most == std::numeric_limits<Number>::max() ? "" : range};
}

/// "cousin help VERB" as "cousin VERB --help", and "cousin help" as "cousin --help".
std::vector<const char*> without_help_verb(int argc, const char* const* argv) {
  std::vector<const char*> words(argv, argv + argc);
  if (words.size() < 2 || std::string_view(words[1]) != "help") return words;
  words.erase(words.begin() + 1);
  words.push_back("--help");
  return words;
}

/// An unset variable of a shell gives an empty word. @throws CLI::ValidationError naming the option
void refuse_empty_words(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& word : option->results()) {
      if (word.empty()) throw CLI::ValidationError(option->get_name(), "its value is empty");
    }
  }
}

/// Options that are given, of the program and of its verb.
std::vector<std::string> given_options(const CLI::App& app) {
  std::vector<const CLI::App*> apps = {&app};
  for (const CLI::App* verb : app.get_subcommands()) apps.push_back(verb);
  std::vector<std::string> given;
  for (const CLI::App* each : apps) {
    for (const CLI::Option* option : each->get_options()) {
      if (option->count() > 0 && !option->get_lnames().empty())
        given.push_back("--" + option->get_lnames().front());
    }
  }
  return given;
}

/// Verbs name results by the last part of a path, which "data/" and "." do not have.
std::string with_last_name(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  const std::filesystem::path last = std::filesystem::path(path).filename();
  return last == "." || last == ".." ? std::filesystem::weakly_canonical(path).string() : path;
}

/// The words without a name.
void takes(CLI::App& verb, Options& o, const char* name, const char* help, int least, int most) {
  verb.add_option(name, o.arguments, help)->expected(least, most)->required(least > 0);
}

constexpr const char* kMeasureHelp =
    "Measure seeds on a printed board, from photographs or a video of a phone: a table in\n"
    "millimetres, with 95 % intervals, and a page with every seed numbered.\n\n"
    "`cousin board seeds` prints the board and how to use it. SOURCE is a video, a folder of\n"
    "photographs of one board, a dataset, or a folder of such folders and videos. No calibration\n"
    "is needed: the focal length is EXIF's or assumed, and the board tells it better.\n\n"
    "specimens.csv has a row a seed and trait: sample, seed, trait, unit, value, low, high. Seeds\n"
    "that are seen and not measured are rows with a reason.";

void add_measure(CLI::App& verb, Options& o) {
  verb.add_option("SOURCE", o.arguments, "Videos and folders; with --group each is a group")
      ->expected(0, 1000);
  verb.add_option("--ruler", o.ruler,
                  "What a ruler or caliper reads for the printed 100 mm, as 99.7; of another "
                  "length 149.6/150. Without it a scale of 100 % +- 0.5 % is assumed");
  verb.add_option("--ruler-sigma", o.ruler_sigma_mm,
                  "Standard deviation of that reading in millimetres")
      ->check(number(0.001, 10))
      ->capture_default_str();
  verb.add_option("--group", o.group,
                  "What the sources are, as cultivar: the table has a column of that name, and "
                  "groups are compared with the first");
  verb.add_option("--expect", o.expect,
                  "Exit code 1 if of some sample fewer seeds are measured; 0 = any number")
      ->check(whole_number(0, 10000))
      ->capture_default_str();
  verb.add_option("--frames", o.frames, "Of a video: how many frames; 0 = 60")
      ->check(whole_number(0, 1000));
  verb.add_option("--intrinsics", o.intrinsics,
                  "The lens, where it is known: a YAML file (OpenCV, ROS, Kalibr), a .cameramodel, "
                  "a rig.json or \"fx,fy,cx,cy[,k1,k2,p1,p2,k3]\"");
  verb.add_option("--method", o.method, "ours (default) or another of `cousin methods`");
  add_config(verb, o);
  add_set(verb, o);
}

constexpr const char* kFitSensorHelp =
    "Fit a sensor preset to your own recordings of a flat wall and of even light. Writes\n"
    "preset.toml, scores and report.html; exit code 1 and no preset if the model is rejected.\n\n"
    "FOLDER holds\n"
    "  wall_0.60m/*.png   16-bit depth of a flat wall, a folder a distance: at least 4 "
    "distances\n"
    "                     of 4 frames, camera and wall at rest, the wall turned by about 5 "
    "degrees\n"
    "  dark/*.png         raw linear frames with the lens covered, grey PNG of 8 or 16 bits\n"
    "  flat_*/*.png       raw frames of an even field, at least 3 brightnesses of 2 frames\n"
    "  recordings.toml    optional: depth_unit_m, focal_px, baseline_m, distance_sigma_m,\n"
    "                     region_px, albedo, light, color_bits; [\"wall_0.60m\"] with "
    "distance_m,\n"
    "                     distance_sigma_m, albedo, light\n"
    "Either the walls or dark and flat fields may be missing. See docs/fit_sensor.md.";

void add_global(CLI::App& app, Options& o) {
  app.name("cousin");
  app.formatter(std::make_shared<HelpText>());
  app.footer(
      "`cousin help VERB` says what a verb takes. Exit codes: 0 done; 1 a gate failed; 2 wrong "
      "usage "
      "or\nconfiguration; 3 bad input data; 4 something inside failed.");
  app.set_version_flag("--version", std::string("cousin ") + COUSIN_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option("--seed", o.seed, "Seed of every random stream")
      ->check(whole_number<std::uint64_t>(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option("--threads", o.threads, "Threads; 0 = all cores. Results do not depend on it")
      ->check(whole_number(0, 1024))
      ->capture_default_str();
  app.add_option("--out", o.out, "Output folder");
  app.add_option(
         "--memory-limit", o.memory_limit_gib,
         "GiB that one input (a file, or all images of a capture) may take in memory; 0 = 8, "
         "or half of this machine's memory if that is less")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_flag("--json", o.json, "Print results as JSON");
  app.add_flag("--quiet", o.quiet, "Print nothing but results and errors");
}

void add_render(CLI::App& verb, Options& o) {
  takes(verb, o, "SCENE", "Scene, see `cousin scenes`", 1, 1);
  verb.add_option("--scenes", o.scenes, "How many scenes")
      ->check(whole_number(1, 999999))
      ->capture_default_str();
  verb.add_option("--frames", o.frames, "Views of each scene; 0 = the scene's own")
      ->check(whole_number(0, 100000));
  verb.add_option("--shard", o.shard, "i/n: part i (from 0) of n of the list of scenes and frames");
  verb.add_flag("--plan", o.plan,
                "Print what will be rendered and written, what is left out and why, and leave");
  add_config(verb, o);
  verb.add_option("--streams", o.streams,
                  "Images of the rig: all (default), or of color,raw,infrared,depth those "
                  "listed; no pass of the others runs");
  verb.add_option(
      "--truth", o.truth,
      "Truth images: all, none, or of depth,normal,instance,part,position,coverage,visibility,"
      "shares,keypoints,leaf_area,flow,disparity,noise_free_depth,invalid_reason those listed; "
      "default: visibility, and of a depth sensor noise_free_depth,invalid_reason, of boards "
      "keypoints");
  verb.add_option("--for", o.truth_for,
                  "Also the truth that `cousin export --format` coco, yolo or bop needs");
  verb.add_option(
          "--truth-format", o.truth_format,
          "Files of truth images of floats. npy: float32, numpy.load; exr: OpenEXR, packed, "
          "channels Z or X Y Z, which not every reader knows; png16: depth and "
          "noise_free_depth as 16-bit PNG, 0 = none, rounded to steps of 0.1 mm, or of 1, "
          "10, 100, 1000 mm where the image reaches beyond 6.5 m, 65 m, ...; the file's "
          ".json says depth_scale, millimetres a step; other images are npy")
      ->capture_default_str();
  add_set(verb, o);
}

void add_perceive(CLI::App& verb, Options& o) {
  takes(verb, o, "DATASET", "Dataset folder", 0, 1);
  verb.add_option("--pipeline", o.pipeline,
                  "As `cousin methods` lists them before the /; the dataset's own if not given; "
                  "needed for a real capture");
  verb.add_option("--lpips", o.lpips, kLpipsOfViews);
  add_stages(verb, o);
  add_config(verb, o);
  add_set(verb, o);
}

void add_score(CLI::App& verb, Options& o) {
  takes(verb, o, "DATASET ESTIMATE",
        "Dataset folder, and a folder of estimates, or a detector's results: a JSON file of COCO "
        "results (Ultralytics' predictions.json) or a folder of YOLO's text files",
        2, 2);
  verb.add_option("--class-map", o.class_map,
                  "Of detections: what the file's classes are in the dataset, 0=low,1=high; "
                  "default: the dataset's classes in their order");
  add_category(verb, o, "Of detections: ");
  verb.add_option("--confidence", o.confidence,
                  "Of detections: precision, recall and pictures are of those from here on")
      ->check(number(0, 1))
      ->capture_default_str();
  verb.add_flag("--align", o.align,
                "Of estimates without traits.json: turn, move and scale them so that camera "
                "centres come nearest to the true ones");
  verb.add_option("--gate", o.gates,
                  "'metric<=x' or 'metric>=x': exit code 1 if it does not hold; repeatable")
      ->type_size(1)
      ->allow_extra_args(false);
}

void add_run(CLI::App& verb, Options& o) {
  takes(verb, o, "SCENE", "Scene, see `cousin scenes`", 1, 1);
  verb.add_option("--scenes", o.scenes, "How many scenes")
      ->check(whole_number(1, 9999))
      ->capture_default_str();
  verb.add_option("--frames", o.frames, "Views of each scene; 0 = the scene's own")
      ->check(whole_number(0, 100000));
  verb.add_option("--pipeline", o.pipeline,
                  "As `cousin methods` lists them before the /; the scene's own if not given. Its "
                  "keys --set names with \"pipeline.\" before them");
  verb.add_option("--pipeline-config", o.pipeline_config,
                  "TOML file of the pipeline's keys, as config.toml of an estimate; --config is "
                  "the scene's, whose table [pipeline] comes after it");
  verb.add_flag("--align", o.align,
                "--pipeline scene: turn, move and scale the estimate so that camera centres come "
                "nearest to the true ones, as poses by COLMAP need");
  verb.add_option("--lpips", o.lpips, kLpipsOfViews);
  verb.add_flag("--plan", o.plan, "Print what will run, what is left out and why, and leave");
  verb.add_flag("--attribution", o.attribution, "Also put truth in place of each seam in turn");
  verb.add_option("--gate", o.gates,
                  "'metric<=x' or 'metric>=x': exit code 1 if it does not hold; repeatable")
      ->type_size(1)
      ->allow_extra_args(false);
  add_stages(verb, o);
  add_config(verb, o);
  add_set(verb, o);
}

void add_fit_sensor(CLI::App& verb, Options& o) {
  takes(verb, o, "FOLDER", "Folder of recordings", 1, 1);
  verb.add_option("--rig", o.rig,
                  "Preset that the numbers go into, see `cousin rigs`, or the path of a TOML file")
      ->required();
}

void add_bench(CLI::App& verb, Options& o) {
  takes(verb, o, "SUITE", COUSIN_SUITE_NAMES "; none = all", 0, -1);
  verb.add_flag("--quick", o.quick,
                "Smaller samples: each suite ends within ten minutes, same columns");
  verb.add_flag("--attribution", o.attribution, "Put truth in place of each seam in turn");
  verb.add_option(
          "--runs", o.runs,
          "Of each point: seeds and calibration, 5 unless given; trays a light of seedlings, "
          "3 unless given. Runs that were finished in the same --out are taken as they "
          "are")
      ->check(whole_number(1, 1000));
  verb.add_option("--shard", o.shard, "i/n: only part i (from 0) of n of the suite's jobs");
  verb.add_option("--lpips", o.lpips,
                  "TorchScript network that images of `seeds` and `seedlings` are scored by too: "
                  "LPIPS, or any of two images of 1 x 3 x height x width from -1 to 1");
  verb.add_option(
      "--only", o.only,
      "Only jobs whose names hold this text, or one of several, as \"_ours,_ngp\": the page is of "
      "them alone");
  verb.add_flag(
      "--list", o.list,
      "Print the jobs that --only and --shard choose, with what --out holds of each "
      "(finished, begun), and run none; --json adds the levels of their factors and their keys");
  verb.add_option(
      "--captures", o.captures,
      "Folder that keeps what `seeds` renders (15 GB in full): a later run with another "
      "--out measures the same images again. Remove it when the simulator's code "
      "changes. --attribution needs more truth and renders its own");
  add_set(verb, o);
}

void add_ledger(CLI::App& verb, Options& o) {
  takes(verb, o, "WORDS", "As above; none: show", 0, 6);
  verb.add_option("--file", o.ledger_file, "The ledger")->capture_default_str();
  verb.add_option("--unit", o.ledger_unit, "Of a prediction: SI, 1 for ratios");
  verb.add_option("--why", o.ledger_why, "Of a prediction or a seen set: the reason");
}

/// Verbs whose words are needed unless they only list their keys.
struct KeyedVerbs {
  CLI::App* perceive = nullptr;
  CLI::App* calibrate = nullptr;
  CLI::App* measure = nullptr;
};

KeyedVerbs add_verbs(CLI::App& app, Options& o) {
  const auto verb = [&](const char* name, const char* help) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&o, name] { o.verb = name; });
    sub->footer(closing_text(name));
    return sub;
  };

  verb("scenes", "List the scenes");
  verb("rigs", "List the sensor presets and what backs them");
  verb("methods", "List the methods of each pipeline and which are built in");
  verb("doctor", "Say what this machine lacks");

  add_render(*verb("render", "Write a dataset: images, reported calibration and truth"), o);
  CLI::App* perceive =
      verb("perceive", "Run a pipeline on a simulated or real dataset; reads no truth");
  add_perceive(*perceive, o);
  add_score(*verb("score", "Score estimates, ours or anybody's, against a dataset's truth"), o);
  add_run(*verb("run", "Render, perceive, score and report in one go"), o);
  CLI::App* measure = verb("measure", kMeasureHelp);
  add_measure(*measure, o);
  CLI::App* board = verb("board", kBoardHelp);
  takes(*board, o, "BOARD", "A board's name, or its kind and sizes", 1, 1);
  board->add_option("--paper", o.paper,
                    "a5, a4, letter, legal, a3, tabloid, a2, a1, a0; the smallest that it fits on "
                    "if not given");
  CLI::App* calibrate = verb("calibrate", kCalibrateHelp);
  add_calibrate(*calibrate, o);

  add_fit_sensor(*verb("fit-sensor", kFitSensorHelp), o);
  add_bench(*verb("bench", "The papers' tables, error against time, stability cases"), o);
  add_import(*verb("import", kImportHelp), o);

  add_export(*verb("export", kExportHelp), o);

  takes(*verb("verify", "Re-hash a dataset"), o, "DATASET", "Dataset folder", 1, 1);
  takes(
      *verb("report", "Make the HTML report of a folder of scores, or an index of folders of them"),
      o, "FOLDER", "Folder of a run or benchmark", 1, 1);

  add_ledger(*verb("ledger", kLedgerHelp), o);
  return {perceive, calibrate, measure};
}

void parse_words(CLI::App& app, const std::vector<const char*>& words, const KeyedVerbs& keyed,
                 Options& o) {
  app.parse(static_cast<int>(words.size()), words.data());
  o.given = given_options(app);
  refuse_empty_words(app);
  for (const CLI::App* sub : app.get_subcommands()) refuse_empty_words(*sub);
  if (!o.out.empty() && !writes_files(o.verb))
    throw CLI::ValidationError("--out", "`cousin " + o.verb + "` writes no files");
  // What keys these have does not depend on what they are given.
  for (const auto& [sub, name] :
       {std::pair(keyed.perceive, "DATASET"), std::pair(keyed.calibrate, "FOLDER"),
        std::pair(keyed.measure, "SOURCE")}) {
    if (sub->parsed() && o.arguments.empty() && !o.keys) throw CLI::RequiredError(name);
  }
}

}  // namespace

ParsedOptions parse_options(int argc, const char* const* argv) {
  ParsedOptions result;
  Options& o = result.options;
  CLI::App app{
      "Cousin: a simulation-first testbed for plant perception. Scenes whose every dimension is "
      "known are\n"
      "photographed by virtual cameras, measured, and scored against the truth."};
  add_global(app, o);
  const KeyedVerbs keyed = add_verbs(app, o);
  const std::vector<const char*> words = without_help_verb(argc, argv);
  const auto leave_without_verb = [&] {
    result.leave = true;
    result.text = first_steps(app);
    result.code = ExitCode::usage;
    return result;
  };
  if (words.size() < 2) return leave_without_verb();
  try {
    parse_words(app, words, keyed, o);
  } catch (const CLI::ParseError& error) {
    result.leave = true;
    // CLI11 shows the program's help where an unknown word stands beside --help.
    const std::vector<std::string> unused = app.remaining(true);
    if (error.get_exit_code() != 0 && app.get_subcommands().empty() && unused.empty() &&
        dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
      return leave_without_verb();
    const bool is_unknown = app.get_subcommands().empty() && !unused.empty();
    if (error.get_exit_code() == 0 && !is_unknown) {  // --help and --version
      std::ostringstream out;
      app.exit(error, out, out);
      result.text = out.str();
    } else {
      result.text = explain(app, error);
      result.code = ExitCode::usage;
    }
  }
  for (std::string& argument : o.arguments) argument = with_last_name(argument);
  return result;
}

}  // namespace cousin
