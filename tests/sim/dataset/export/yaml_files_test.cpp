// Every YAML that we write, as readers of YAML 1.1 take it: by its rules for numbers, and by PyYAML
// where that is installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <charconv>
#include <cstdlib>
#include <regex>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/yaml_text.h"
#include "tests/sim/dataset/small_dataset.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Words that are numbers to C++ and text to YAML 1.1 [yaml.org/type/float.html, int.html].
std::vector<std::string> numbers_that_are_text(const std::string& yaml) {
  static const std::regex kNumber(R"([-+]?(0|[1-9][0-9]*)|[-+]?[0-9]+\.[0-9]*([eE][-+][0-9]+)?)");
  static const std::regex kWord(R"([^\s,\[\]:{}"]+)");
  std::vector<std::string> wrong;
  for (std::sregex_iterator at(yaml.begin(), yaml.end(), kWord), end; at != end; ++at) {
    const std::string word = at->str();
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || stop != word.data() + word.size()) continue;
    if (!std::regex_match(word, kNumber)) wrong.push_back(word);
  }
  return wrong;
}

/// Numbers of every size, as a lens has them.
Camera small_numbers() {
  Camera camera = SmallDataset{}.camera;
  camera.model = LensModel::opencv5;
  camera.distortion = {-2e-4, 3e-5, 1e-7, -1.5e-6, 0};
  return camera;
}

/// All YAML of all exports of a dataset, and of cameras with names that YAML takes for other
/// things.
std::vector<fs::path> write_all(const fs::path& folder) {
  write_small_dataset(folder / "data", {.camera = small_numbers(), .scenes = 2});
  for (const ExportFormat& format : export_formats()) {
    for (const YoloTask task : {YoloTask::detect, YoloTask::segment, YoloTask::pose}) {
      if (format.name != "yolo" && task != YoloTask::detect) continue;
      ExportOptions options{.undistort = format.name == "bop", .task = task};
      export_dataset(folder / "data", format, options,
                     folder / "out" / (format.name + std::string(to_string(task))), "test",
                     [](const std::string&, int, int) {});
    }
  }
  for (const char* name :
       {"no", "On", "null", "1_000", "12:30", "a b", "0x1f", "\"q\\", "é\n", ""}) {
    const CalibratedCamera camera{name, small_numbers(), {}};
    const fs::path at = folder / "out" /
                        ("name" + std::to_string(std::string(name).size()) + "_" +
                         std::to_string(static_cast<unsigned char>(name[0])));
    write_file(at / "ros.yaml", ros_camera_info(camera));
    write_file(at / "opencv.yaml", opencv_yaml(camera, camera));
    write_file(at / "kalibr.yaml", kalibr_camchain({camera}));
    write_file(at / "name.txt", name);
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "out")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  return files;
}

TEST(YamlFiles, NoNumberIsTextToReadersOfYaml11) {
  EXPECT_THAT(numbers_that_are_text("data: [2e-04, 1, -0.5, 1.0e+20]"),
              testing::ElementsAre("2e-04"));
  const TemporaryFolder folder;
  const std::vector<fs::path> files = write_all(folder.path());
  EXPECT_GT(files.size(), 30U);
  for (const fs::path& file : files)
    EXPECT_THAT(numbers_that_are_text(read_file(file)), testing::IsEmpty()) << file;
}

TEST(YamlFiles, PyYamlReadsNumbersAsNumbersAndNamesAsTheyAre) {
  if (std::system("python3 -c 'import yaml' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3 has no yaml (Debian: python3-yaml)";
  const TemporaryFolder folder;
  write_all(folder.path());
  write_file(folder.path() / "check.py", R"(
import os, sys, yaml
class Loader(yaml.SafeLoader): pass
Loader.add_constructor('tag:yaml.org,2002:opencv-matrix', lambda l, n: l.construct_mapping(n, deep=True))
def is_number(text):
    try: float(text)
    except ValueError: return False
    return True
def check(value, key, file):
    if isinstance(value, dict):
        for k, v in value.items(): check(v, k, file)
    elif isinstance(value, list):
        for v in value: check(v, key, file)
    elif isinstance(value, str) and key not in ('camera_name', 'rostopic') and is_number(value):
        sys.exit(f'{file}: {key}: {value!r} is text')
count = 0
for at, _, names in os.walk(sys.argv[1]):
    for name in names:
        if not name.endswith('.yaml'): continue
        file = os.path.join(at, name)
        tree = yaml.load(open(file, encoding='utf-8'), Loader)
        if not isinstance(tree, dict): sys.exit(f'{file}: not a mapping')
        check(tree, '', file)
        count += 1
        if name == 'data.yaml':
            for split in ('train', 'val'):
                if not os.path.isdir(os.path.join(at, tree[split])): sys.exit(f'{file}: no {split}')
        known = os.path.join(at, 'name.txt')
        if not os.path.exists(known): continue
        name_there = open(known, encoding='utf-8', newline='').read()
        if 'camera_name' in tree and tree['camera_name'] != name_there:
            sys.exit(f'{file}: camera_name {tree["camera_name"]!r}, not {name_there!r}')
        if 'cam0' in tree and tree['cam0']['rostopic'] != f'/{name_there}/image_raw':
            sys.exit(f'{file}: rostopic {tree["cam0"]["rostopic"]!r}')
print(count)
)");
  const std::string command = "python3 '" + (folder.path() / "check.py").string() + "' '" +
                              (folder.path() / "out").string() + "' > '" +
                              (folder.path() / "said").string() + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(folder.path() / "said");
  EXPECT_GT(std::stoi("0" + read_file(folder.path() / "said")), 30);
}

TEST(YamlFiles, NumbersReadBackEqualAndTextIsRefusedUnlessItIsUtf8) {
  EXPECT_EQ(yaml_number(2e-4), "2.0e-04");
  EXPECT_EQ(yaml_number(1e22), "1.0e+22");
  EXPECT_EQ(yaml_number(-1.5e-7), "-1.5e-07");
  EXPECT_EQ(yaml_number(500), "500");
  EXPECT_THROW(yaml_number(std::nan("")), std::invalid_argument);
  EXPECT_EQ(yaml_name("rgb_left-2"), "rgb_left-2");
  EXPECT_EQ(yaml_name("off"), "\"off\"");
  EXPECT_EQ(yaml_quoted("\u2028"), "\"\\u2028\"");
  EXPECT_THAT(error_of([] { yaml_quoted("Gr\xfcn"); }), HasSubstr("\"Gr\\xfcn\" is not UTF-8"));
}

}  // namespace
}  // namespace cousin
