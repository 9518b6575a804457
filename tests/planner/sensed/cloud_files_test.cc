// Readers of point clouds: every form of every format, and every kind of damage.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "leeway/planner/point_cloud.h"
#include "planner/sensed/cloud_source.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;

class CloudFiles : public testing::Test {
 protected:
  PointCloud load(const std::string& name, const std::string& contents) {
    return loadCloud(folder_.write(name, contents), 0.01, warnings_);
  }
  /// All of the three points, each with the given radius.
  void expectThree(const std::string& name, const std::string& contents) {
    const PointCloud cloud = load(name, contents);
    ASSERT_EQ(cloud.size(), 3U) << name;
    EXPECT_EQ(cloud.balls[0].center, Vector3d(1, 2, 3));
    EXPECT_EQ(cloud.balls[1].center, Vector3d(-0.5, 0.25, 8));
    EXPECT_EQ(cloud.balls[2].center, Vector3d(0, 0, 1024));
    EXPECT_EQ(cloud.balls[2].radius, 0.01);
    EXPECT_TRUE(cloud.filters.empty());
  }
  void expectError(const std::string& name, const std::string& contents, int line,
                   std::initializer_list<std::string> words) {
    SCOPED_TRACE(name + ": " + contents.substr(0, 200));
    const std::string path = folder_.write(name, contents);
    robots::expectInputError([&] { loadCloud(path, 0.01, warnings_); }, path, line, words);
  }
  Folder folder_;
  std::vector<std::string> warnings_;
};

const double kPoints[3][3] = {{1, 2, 3}, {-0.5, 0.25, 8}, {0, 0, 1024}};

template <class T>
void append(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string pcdHeader(const std::string& data, const std::string& count = "3") {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb x y z _\nSIZE 4 4 4 8 1\nTYPE U F F F U\n"
         "COUNT 1 1 1 1 4\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA " + data + "\n";
}

std::string pcdRecords() {
  std::string bytes;
  for (const auto& p : kPoints) {
    append<std::uint32_t>(bytes, 0xFFFFFFFF);
    append(bytes, static_cast<float>(p[0]));
    append(bytes, static_cast<float>(p[1]));
    append(bytes, p[2]);
    append<std::uint32_t>(bytes, 7);
  }
  return bytes;
}

/// The fields one after the other, in literal runs of LZF.
std::string pcdCompressed() {
  std::string fields;
  for (int i = 0; i < 3; ++i) append<std::uint32_t>(fields, 0xFFFFFFFF);
  for (const auto& p : kPoints) append(fields, static_cast<float>(p[0]));
  for (const auto& p : kPoints) append(fields, static_cast<float>(p[1]));
  for (const auto& p : kPoints) append(fields, p[2]);
  // The first twelve bytes are alike: one literal, and a reference to it.
  std::string data = {'\0', '\xFF', static_cast<char>(7U << 5U), static_cast<char>(11 - 9), '\0'};
  for (std::size_t at = 12; at < fields.size(); at += 32) {
    const std::string run = fields.substr(at, 32);
    data += static_cast<char>(run.size() - 1) + run;
  }
  std::string bytes;
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(data.size()));
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(fields.size()));
  return bytes + data;
}

std::string ply(const std::string& format, const std::string& count = "3") {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement camera 1\n" +
         "property list uchar int ids\nproperty float f\nelement vertex " + count +
         "\nproperty float x\nproperty uchar red\nproperty double y\nproperty float z\n" +
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string plyRecords(bool big_endian, bool has_face = true) {
  std::string bytes("\x02", 1);
  append<std::int32_t>(bytes, 1, big_endian);
  append<std::int32_t>(bytes, 2, big_endian);
  append(bytes, 0.5F, big_endian);
  for (const auto& p : kPoints) {
    append(bytes, static_cast<float>(p[0]), big_endian);
    bytes += '\x80';
    append(bytes, p[1], big_endian);
    append(bytes, static_cast<float>(p[2]), big_endian);
  }
  if (has_face) bytes += '\x03';
  for (std::int32_t corner = 0; has_face && corner < 3; ++corner) append(bytes, corner, big_endian);
  return bytes;
}

const std::string kPlyText = "2 1 2 0.5\n1 128 2 3\n-0.5 128 .25 8\n0 128 0 1.024e3\n3 0 1 2\n";

TEST_F(CloudFiles, EveryFormReadsTheSame) {
  expectThree("a.xyz", "1 2 3\n-0.5\t0.25  8\n\n0 0 1024\n");
  expectThree("a.txt", "# x y z i\r\n1 2 3 7\r\n-0.5 0.25 8 7\r\n0 0 1024 7\r\n");
  // Regression: names in a comment were ignored, and the columns taken as x, y and z.
  expectThree("d.txt", "# x y z\n# z y x\n3 2 1\n8 0.25 -0.5\n1024 0 0\n");
  expectThree("e.txt", "//Z Y Intensity X\n\n3 2 9 1\n8 .25 9 -.5\n1024 0 9 0\n");
  expectThree("d.csv", "# z, y, x\n3,2,1\n8,0.25,-0.5\n1024,0,0\n");
  expectThree("f.txt", "# z y x\n# by hand\n3 2 1\n# x y z\n8 0.25 -0.5\n1024 0 0\n");
  expectThree("l.txt", "# z is up, x forward, y left\n1 2 3\n-0.5 0.25 8\n0 0 1024\n");
  expectThree("j.txt", "# columns: x, y, z\n1 2 3\n-0.5 0.25 8\n0 0 1024\n");
  expectError("k.txt", "# columns: z, y, x\n# by hand\n1 2 3\n", 1, {"seems to name columns"});
  expectError("g.txt", "# z y x w\n1 2 3\n-0.5 0.25 8\n0 0 1024\n", 1, {"one word for each"});
  expectThree("h.txt", "# z y z\n1 2 3\n-0.5 0.25 8\n0 0 1024\n");
  expectThree("i.txt", "# x y z\nz y x\n3 2 1\n8 0.25 -0.5\n1024 0 0\n");
  expectThree("a.csv", "1,2,3\n-0.5, 0.25 ,8\n0,0,1024\n");
  expectThree("b.csv", "\xEF\xBB\xBF\"id\";Z;X;Y\n1;3;1;2\n2;8;-0.5;0.25\n3;1024;0;0\n");
  expectThree("a.ply", ply("ascii") + kPlyText);
  expectThree("b.ply", ply("binary_little_endian") + plyRecords(false));
  expectThree("C.PLY", ply("binary_big_endian") + plyRecords(true));
  expectThree("a.pcd",
              pcdHeader("ascii") + "9 1 2 3 0 0 0 0\n9 -.5 .25 8 0 0 0 0\n9 0 0 1024 0 0 0 0\n");
  expectThree("b.pcd", pcdHeader("binary") + pcdRecords());
  expectThree("c.pcd", pcdHeader("binary") + pcdRecords() + std::string(100, '\0'));
  expectThree("d.pcd", pcdHeader("binary_compressed") + pcdCompressed());
  ASSERT_EQ(warnings_.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NE(warnings_[i].find("the element 'face' (1) is left out"), std::string::npos);
  EXPECT_NE(warnings_[3].find("100 bytes of value 0 follow the 3 points"), std::string::npos);
}

/// A number that was cut is still a number.
TEST_F(CloudFiles, ALastLineWithoutItsEndIsTold) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n";
  const std::string pcd =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n";
  for (const auto& [name, head, line] : {std::tuple("a.xyz", std::string(), 2),
                                         {"A.CSV", std::string("x,y,z\n"), 3},
                                         {"a.ply", ply, 9},
                                         {"a.pcd", pcd, 9}}) {
    const bool commas = head.find("x,") == 0;
    const std::string points = commas ? "1,2,3\n4,5,0.25" : "1 2 3\n4 5 0.25";
    warnings_.clear();
    load(name, head + points + "\n");
    EXPECT_TRUE(warnings_.empty()) << name;
    load(name, head + points);
    ASSERT_EQ(warnings_.size(), 1U) << name;
    EXPECT_NE(warnings_[0].find(":" + std::to_string(line) + ": the last line does not end"),
              std::string::npos)
        << warnings_[0];
  }
}

TEST_F(CloudFiles, PointsThatAreNotNumbersAreDroppedAndCounted) {
  for (const char* file : {"1 2 3\nnan nan nan\n0 inf 0\n", "1 2 3\n-nan 0 0\n1 1 -inf\n"}) {
    const PointCloud cloud = load("a.xyz", file);
    ASSERT_EQ(cloud.size(), 1U);
    ASSERT_EQ(cloud.filters.size(), 1U);
    EXPECT_EQ(cloud.filters[0].name, "drop");
    EXPECT_EQ(cloud.filters[0].removed, 2U);
  }
  expectError("b.xyz", "nan nan nan\n", 0, {"1 points, none of which is a number"});
}

TEST_F(CloudFiles, AViewpointIsNotAppliedInSilence) {
  std::string text = pcdHeader("binary") + pcdRecords();
  text.replace(text.find("VIEWPOINT 0"), 11, "VIEWPOINT 1");
  load("a.pcd", text);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("a.pcd:9: VIEWPOINT is not applied"), std::string::npos);
}

TEST_F(CloudFiles, DamagedColumnsNameTheirLine) {
  expectError("a.xyz", "", 0, {"holds no point"});
  expectError("a.xyz", "# nothing\n", 0, {"holds no point"});
  expectError("a.xyz", "1 2 3\n1 2\n", 2, {"2 columns", "3, as the first"});
  expectError("a.xyz", "1 2\n", 1, {"2 of x, y and z"});
  expectError("a.xyz", "1 2 3\n1 2 1e\n", 2, {"'1e'", "a number"});
  expectError("a.xyz", "1 2 3\n0 1e10 0\n", 2, {"10000000000 is too large", "1000000000"});
  expectError("a.xyz", "12\nwater\n", 1, {"1 of x, y and z"});
  expectError("a.csv", "1,2,3\n1,,3\n", 2, {"'' stands where a coordinate is expected"});
  expectError("a.xyz", "1\t2\t3\t4\n1\t\t3\t4\n", 2, {"'' stands where a coordinate is expected"});
  expectError("a.xyz", "\t1\t2\t3\n", 1, {"'' stands where a coordinate is expected"});
  expectError("a.xyz", "1 2 3\n1\t\t2\t3\n", 2, {"4 columns", "3, as the first"});
  expectError("a.csv", "x,y,depth\n1,2,3\n", 1, {"no column is named 'z'"});
  expectError("a.csv", std::string("1,2,3\n\0,2,3\n", 12), 0, {"byte 6", "value 0"});
}

TEST_F(CloudFiles, AColumnStandsOnce) {
  expectError("a.xyz", "x y z x\n1 2 3 4\n", 1, {"two columns are named 'x'"});
  expectError("a.csv", "x,y,Y,z\n1,2,3,4\n", 1, {"two columns are named 'y'"});
}

TEST_F(CloudFiles, DamagedPlysNameTheirPlace) {
  const std::string whole = ply("ascii") + kPlyText;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    return text.replace(text.find(from), from.size(), to);
  };
  expectError("a.ply", "", 1, {"is empty; \"ply\" would be accepted"});
  expectError("a.ply", "ply\nformat ascii 1.0\n", 2, {"ends within its header"});
  expectError("a.ply", with("ascii", "utf8"), 2, {"'utf8'", "ascii"});
  expectError("a.ply", with("format ascii 1.0\n", ""), 13, {"'end_header'; a format before it"});
  expectError("a.ply", with("vertex 3", "vertex three"), 7, {"'three'; the number of elements"});
  expectError("a.ply", with("vertex 3", "vertex -3"), 7, {"'-3'"});
  expectError("a.ply", with("element vertex", "element point"), 1, {"no element vertex"});
  expectError("a.ply", with("property double y", "property double w"), 7, {"no property 'y'"});
  expectError("a.ply", with("property double y", "property real y"), 10, {"'real'"});
  expectError("a.ply", with("property double y", "properties"), 10, {"'properties'"});
  expectError("a.ply", with("vertex 3", "vertex 9"), 20, {"ends here, after 4 of 9"});
  expectError("a.ply", with("1 128 2 3", "1 128 2"), 16, {"the line ends too early"});
  expectError("a.ply", with("1 128 2 3", "1 128 2 3 4"), 16, {"'4' cannot be used here"});
  expectError("a.ply", with("1 128 2 3", "1 128 2e400 3"), 16, {"too large"});
  expectError("a.ply", with("property double y", "property double x"), 7, {"two properties 'x'"});
  expectError("a.ply", with("end_header", "element vertex 1\nend_header"), 14,
              {"element vertex stands twice"});
  expectError("a.ply", with("element", "format ascii 1.0\nelement"), 4, {"format stands twice"});
  const std::string header = ply("binary_little_endian");
  const std::string binary = header + plyRecords(false);
  expectError("a.ply", binary.substr(0, binary.size() - 14), 0,
              {"byte", "ends here, after 2 of 3 rows of the element 'vertex'"});
  expectError("a.ply", binary.substr(0, binary.size() - 1), 0, {"a list of 3 entries"});
  expectError("a.ply", binary.substr(0, binary.size() - 13), 0,
              {"ends here, after 0 of 1 rows of the element 'face'"});
  expectError("a.ply", ply("binary_little_endian", "2000000000") + plyRecords(false, false), 0,
              {"ends here, after 3 of 2000000000"});
  // Regression: points that the header does not count were lost where an element follows them.
  expectError("a.ply", with("vertex 3", "vertex 2").replace(whole.find("face 1"), 6, "face 0"), 18,
              {"'0' follows the last element"});
  expectError("a.ply", with("vertex 3", "vertex 2"), 18, {"'128'"});
  expectError("a.ply", header + plyRecords(false) + std::string(13, '\0'), 0,
              {"13 bytes follow the last element"});
  std::string list = binary;
  list[header.size()] = '\xFF';
  expectError("a.ply", list, 0, {"a list of 255 entries"});
  expectError("b.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n1 2 3\n\n4 5 6\n",
              10, {"'4' follows the last element"});
}

TEST_F(CloudFiles, DamagedPcdsNameTheirPlace) {
  const auto with = [&](const std::string& data, const std::string& from, const std::string& to) {
    std::string text = pcdHeader(data) + pcdRecords();
    return text.replace(text.find(from), from.size(), to);
  };
  expectError("a.pcd", "", 1, {"ends within its header", "DATA"});
  expectError("a.pcd", with("binary", "DATA binary", "DATA zip"), 11, {"'zip'"});
  expectError("a.pcd", with("binary", "HEIGHT 1\n", ""), 10, {"no HEIGHT"});
  expectError("a.pcd", with("binary", "HEIGHT 1", "HEIGHT 2"), 10,
              {"POINTS is 3", "6, is expected"});
  expectError("a.pcd", with("binary", "HEIGHT", "DEPTH"), 8, {"'DEPTH'"});
  expectError("a.pcd", with("binary", "WIDTH 3", "WIDTH -3"), 7, {"'-3'"});
  expectError("a.pcd", with("binary", "SIZE 4 4 4 8 1", "SIZE 4 4 4 8"), 4, {"SIZE has 4", "5"});
  expectError("a.pcd", with("binary", "SIZE 4 4 4 8 1", "SIZE 4 2 4 8 1"), 5, {"'x'", "2 bytes"});
  expectError("a.pcd", with("binary", "U F F F U", "U F Q F U"), 5, {"'y'", "'Q'"});
  expectError("a.pcd", with("binary", "1 1 1 1 4", "1 1 1 1 0"), 6, {"COUNT of 0"});
  expectError("a.pcd", with("binary", "1 1 1 1 4", "1 1 1 1 2000000000"), 6,
              {"COUNT of 2000000000"});
  expectError("a.pcd", with("binary", "rgb x y z", "rgb x y w"), 3, {"no field 'z'"});
  expectError("a.pcd", with("binary", "VERSION 0.7", "WIDTH 7"), 7, {"WIDTH stands twice"});
  expectError("a.pcd", with("binary", "FIELDS rgb", "FIELDS x"), 3, {"two fields are named 'x'"});
  const std::string binary = pcdHeader("binary") + pcdRecords();
  expectError("a.pcd", binary.substr(0, binary.size() - 1), 0, {"byte", "2 of 3 points of 24"});
  expectError("a.pcd", pcdHeader("binary", "2147483647") + pcdRecords(), 0, {"3 of 2147483647"});
  expectError("a.pcd", binary + "x", 0, {"more than 3 points"});
  const std::string text = pcdHeader("ascii");
  expectError("a.pcd", text + "9 1 2 3 0 0 0 0\n", 13, {"ends after 1 of 3 points"});
  expectError("a.pcd", text + "9 1 2 3 0 0 0\n", 12, {"7 numbers", "8"});
  const std::string compressed = pcdHeader("binary_compressed") + pcdCompressed();
  expectError("a.pcd", compressed.substr(0, compressed.size() - 1), 0, {"compressed bytes"});
  expectError("a.pcd", pcdHeader("binary_compressed") + "1234", 0, {"two sizes"});
  std::string damaged = compressed;
  damaged[damaged.size() - pcdCompressed().size() + 4] += 1;
  expectError("a.pcd", damaged, 0, {"3 points of 20 bytes"});
  damaged = compressed;
  damaged[damaged.size() - pcdCompressed().size() + 11] = 9;  // a reference before the first byte
  expectError("a.pcd", damaged, 0, {"damaged"});
}

TEST_F(CloudFiles, WhatIsLeftOutIsWarnedOf) {
  const std::string mesh =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  EXPECT_EQ(loadCloud(folder_.write("m.ply", mesh), 0.01, warnings_).size(), 3U);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("m.ply:7: the element 'face' (1) is left out"), std::string::npos)
      << warnings_[0];
  warnings_.clear();
  const std::string padded = pcdHeader("binary") + pcdRecords() + std::string(24, '\0');
  EXPECT_EQ(loadCloud(folder_.write("p.pcd", padded), 0.01, warnings_).size(), 3U);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("24 bytes of value 0 follow the 3 points"), std::string::npos)
      << warnings_[0];
}

TEST_F(CloudFiles, OtherFilesAreRefused) {
  expectError("a.las", "LASF", 0, {"'.las'", ".ply, .pcd, .xyz"});
  expectError("a.xyz", "version https://git-lfs.github.com/spec/v1\n", 0, {"Git LFS"});
  robots::expectInputError([&] { loadCloud(folder_.path("b.xyz"), 0.01, warnings_); },
                           folder_.path("b.xyz"), 0, {"there is no such file", "a point cloud"});
}

TEST(Lzf, RunsAndReferences) {
  EXPECT_EQ(decompressLzf(std::string("\x02"
                                      "abc",
                                      4),
                          3),
            "abc");
  // Three bytes again from two back, which overlap what they make.
  EXPECT_EQ(decompressLzf(std::string("\x01"
                                      "ab\x20\x01",
                                      5),
                          5),
            "ababa");
  for (const std::string& damaged : {std::string("\x03"
                                                 "abc",
                                                 4),
                                     std::string("\x01"
                                                 "ab\x20",
                                                 4),
                                     std::string("\x01"
                                                 "ab\xE0",
                                                 4),
                                     std::string("\x01"
                                                 "ab\x20\x02",
                                                 5),
                                     std::string("\x20\x00", 2)})
    EXPECT_FALSE(decompressLzf(damaged, 5));
  EXPECT_FALSE(decompressLzf(std::string("\x02"
                                         "abc",
                                         4),
                             2));
  EXPECT_FALSE(decompressLzf(std::string("\x02"
                                         "abc",
                                         4),
                             4));
  EXPECT_FALSE(decompressLzf("", std::size_t{1} << 62U));
}

}  // namespace
}  // namespace leeway::planner
