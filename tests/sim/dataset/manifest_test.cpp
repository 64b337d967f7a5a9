#include "sim/dataset/manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

// FIPS 180-4 examples and NIST's long message.
TEST(Sha256, MatchesTheStandardVectors) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_hex("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjkl"
                       "mnopqklmnopqrlmnopqrs"
                       "mnopqrstnopqrstu"),
            "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(sha256_hex(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileEqualsThatOfItsBytes) {
  const TemporaryFolder folder;
  const std::string bytes(3'000'001, 'q');  // more than one buffer
  write_file(folder.path() / "f", bytes);
  EXPECT_EQ(sha256_hex_of_file(folder.path() / "f"), sha256_hex(bytes));
  EXPECT_THAT(error_of([&] { sha256_hex_of_file(folder.path() / "absent"); }),
              testing::HasSubstr("absent"));
}

const Manifest kHeader{.program_version = "0.1.0", .config_hash = "c0ffee", .pipeline = "seeds"};
const std::vector<fs::path> kFiles = {"000000/rig.json", "000000/rgb/000000.png",
                                      "000000/truth/seed", "000001/rig.json", "000001/truth/seed"};

void make_dataset(const fs::path& dataset) {
  for (const fs::path& file : kFiles) write_file(dataset / file, "bytes of " + file.string());
  write_file(dataset / "timings.json", "{}");
}

std::vector<std::string> problems_of(const fs::path& dataset) {
  std::vector<std::string> lines;
  for (const VerifyProblem& problem : verify(dataset))
    lines.push_back(problem.path + ": " + problem.what);
  return lines;
}

TEST(Manifest, ListsEveryFileButManifestsTimingsAndListsOfWorkBegun) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  write_file(folder.path() / "manifest.0-of-2.json", "{}");
  write_file(folder.path() / "000000/.rig.json.77.0.part", "of a killed run");
  write_file(folder.path() / ".cousin.render", "= render c0ffee 0.1.0\n");
  write_manifest(folder.path(), kHeader);
  const Manifest manifest = read_manifest(folder.path()).value();
  EXPECT_EQ(manifest.pipeline, "seeds");
  EXPECT_EQ(manifest.config_hash, "c0ffee");
  ASSERT_EQ(manifest.files.size(), kFiles.size());
  EXPECT_EQ(manifest.files[0].first, "000000/rgb/000000.png");
  EXPECT_EQ(manifest.files[0].second, sha256_hex("bytes of 000000/rgb/000000.png"));
  EXPECT_THAT(problems_of(folder.path()), testing::IsEmpty());
}

TEST(Manifest, AFoldersHashIsOfNamesAndBytes) {
  const TemporaryFolder folder;
  EXPECT_EQ(sha256_hex_of_folder(folder.path() / "none"), "absent");
  const std::string empty = sha256_hex_of_folder(folder.path());
  write_file(folder.path() / "a.txt", "one");
  const std::string one = sha256_hex_of_folder(folder.path());
  EXPECT_NE(one, empty);
  write_file(folder.path() / "a.txt", "two");
  const std::string two = sha256_hex_of_folder(folder.path());
  EXPECT_NE(two, one);
  std::filesystem::rename(folder.path() / "a.txt", folder.path() / "b.txt");
  EXPECT_NE(sha256_hex_of_folder(folder.path()), two);
}

TEST(Manifest, ShardsInAnyOrderMergeToTheBytesOfOneRun) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  write_manifest(folder.path(), kHeader);
  const std::string whole = read_file(folder.path() / "manifest.json");
  fs::remove(folder.path() / "manifest.json");
  write_shard_manifest(folder.path(), kHeader, 2, 3, {kFiles[4]});
  write_shard_manifest(folder.path(), kHeader, 0, 3, {kFiles[3], kFiles[0]});
  EXPECT_FALSE(fs::exists(folder.path() / "manifest.json"));
  // An absolute path and a file that an earlier shard has too are fine.
  write_shard_manifest(folder.path(), kHeader, 1, 3,
                       {folder.path() / kFiles[1], kFiles[2], kFiles[0]});
  EXPECT_EQ(read_file(folder.path() / "manifest.json"), whole);
  EXPECT_THAT(problems_of(folder.path()), testing::IsEmpty());
}

TEST(Manifest, ShardsOfDifferentRunsDoNotMerge) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  write_shard_manifest(folder.path(), kHeader, 0, 2, {kFiles[0]});
  Manifest other = kHeader;
  other.config_hash = "decaf";
  EXPECT_THAT(error_of([&] { write_shard_manifest(folder.path(), other, 1, 2, {kFiles[1]}); }),
              testing::HasSubstr("different runs"));
  EXPECT_FALSE(fs::exists(folder.path() / "manifest.json"));
  EXPECT_THROW(write_shard_manifest(folder.path(), kHeader, 2, 2, {}), std::invalid_argument);
  EXPECT_THAT(error_of([&] { write_shard_manifest(folder.path(), kHeader, 1, 2, {"../outside"}); }),
              testing::HasSubstr(".."));
}

TEST(Verify, NamesMissingChangedAndExtraFiles) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  write_manifest(folder.path(), kHeader);
  write_file(folder.path() / "000000/rig.json", "changed");
  fs::remove(folder.path() / "000000/rgb/000000.png");
  fs::remove(folder.path() / "000000/truth/seed");  // the folder truth/ is still there
  write_file(folder.path() / "000001/extra.txt", "");
  EXPECT_THAT(
      problems_of(folder.path()),
      testing::ElementsAre("000000/rgb/000000.png: missing", "000000/rig.json: changed",
                           "000000/truth/seed: missing", "000001/extra.txt: not in the manifest"));
}

TEST(Verify, ADatasetWithoutTruthIsValid) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  write_manifest(folder.path(), kHeader);
  fs::remove_all(folder.path() / "000000/truth");
  fs::remove_all(folder.path() / "000001/truth");
  EXPECT_THAT(problems_of(folder.path()), testing::IsEmpty());
}

TEST(Verify, PathsThatEscapeAreProblemsAndAreNotRead) {
  const TemporaryFolder folder;
  make_dataset(folder.path());
  fs::create_symlink("/etc/hostname", folder.path() / "000001/link");
  const std::string hash(64, '0');
  write_file(folder.path() / "manifest.json",
             R"({"schema": 1, "program_version": "", "config_hash": "", "pipeline": "",
           "files": {"../x": ")" +
                 hash + R"(", "/etc/passwd": ")" + hash + R"(", "000001/link": ")" + hash +
                 R"("}})");
  const std::vector<std::string> problems = problems_of(folder.path());
  EXPECT_THAT(problems, testing::IsSupersetOf({"../x: escapes the dataset",
                                               "/etc/passwd: escapes the dataset",
                                               "000001/link: escapes the dataset"}));
  EXPECT_THAT(error_of([&] { write_manifest(folder.path(), kHeader); }),
              testing::HasSubstr("symbolic link"));
}

TEST(Verify, MalformedManifestsAreErrors) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    write_file(folder.path() / "manifest.json", text);
    return error_of([&] { verify(folder.path()); });
  };
  EXPECT_THAT(error("{"), testing::HasSubstr("manifest.json: not JSON"));
  EXPECT_THAT(error("{}"), testing::HasSubstr("lacks the key \"schema\""));
  const std::string head =
      R"({"schema": 1, "program_version": "", "config_hash": "", "pipeline": "", "files": )";
  EXPECT_THAT(error(head + "[]}"), testing::HasSubstr("/files"));
  EXPECT_THAT(error(head + R"({"a": "12"}})"),
              testing::HasSubstr("/files/a = \"12\" is not a SHA-256"));
  EXPECT_THAT(error(head + R"({}, "more": 1})"), testing::HasSubstr("unknown key \"more\""));
  EXPECT_THAT(error_of([&] { verify(folder.path() / "absent"); }),
              testing::HasSubstr("not a folder"));
}

TEST(Verify, WithoutAManifestTheFilesAreRead) {
  const TemporaryFolder folder;
  write_capture(folder.path() / "000000", sample_capture());
  EXPECT_THAT(problems_of(folder.path()), testing::IsEmpty());
  fs::remove(folder.path() / "000000/ir_left/000010.png");
  const std::vector<VerifyProblem> problems = verify(folder.path());
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].path, "000000");
  EXPECT_THAT(problems[0].what,
              testing::HasSubstr("ir_left/000010.png (frame 10): the image is missing"));
}

}  // namespace
}  // namespace cousin
