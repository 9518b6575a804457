// What the command keeps on disk, and that no answer depends on it.

#include <cmath>
#include <iterator>
#include <sstream>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

/// A bumpy ball as Wavefront OBJ.
std::string ballObj(double radius) {
  constexpr int kRings = 14, kSectors = 24;
  std::ostringstream text;
  text.precision(17);
  for (int i = 0; i <= kRings; ++i)
    for (int j = 0; j < kSectors; ++j) {
      const double a = 3.14159265358979 * i / kRings, b = 2 * 3.14159265358979 * j / kSectors;
      const double r = radius * (1 + 0.05 * ((i * 7 + j * 3) % 5)) * std::sin(a);
      text << "v " << r * std::cos(b) << ' ' << r * std::sin(b) << ' ' << radius * std::cos(a)
           << '\n';
    }
  const auto at = [](int i, int j) { return 1 + i * kSectors + j % kSectors; };
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSectors; ++j)
      text << "f " << at(i, j) << ' ' << at(i + 1, j) << ' ' << at(i + 1, j + 1) << ' '
           << at(i, j + 1) << '\n';
  return text.str();
}

class Cache : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("ball.obj", ballObj(0.1));
    write("bone.obj", ballObj(0.04));
    std::string urdf = kUrdf;
    const std::string box = R"(<box size="0.4 0.04 0.04"/>)";
    urdf.replace(urdf.rfind(box), box.size(), R"(<mesh filename="bone.obj" scale="4 1 1"/>)");
    write("bony.urdf", urdf);
    write("ball.yaml", R"(leeway: 1
robot: {urdf: bony.urdf, srdf: arm.srdf, group: arm}
start: right
goal: left
objects:
  - {name: ball, position: [0.9, 0, 0], mesh: {file: ball.obj}}
limits: {time: 20}
seed: 7
)");
  }

  /// `plan ball.yaml` and what stands before or after it, without the times.
  json plan(const std::string& environment, const std::string& options = "") const {
    const Answer answer = shell(environment + " '" + leeway::commandFile() +
                                "' plan ball.yaml --json --output path.json " + options);
    EXPECT_EQ(answer.status, 0) << answer.err;
    json document = answer.document();
    document.erase("time_s");
    return document;
  }
  int kept(const std::string& folder) const {
    return fs::exists(path(folder))
               ? static_cast<int>(
                     std::distance(fs::directory_iterator(path(folder)), fs::directory_iterator()))
               : 0;
  }
};

TEST_F(Cache, ChangesNoAnswer) {
  const json none = plan("LEEWAY_CACHE_DIR=");
  const std::string path_text = read("path.json");
  EXPECT_EQ(plan("LEEWAY_CACHE_DIR=kept"), none);
  EXPECT_EQ(kept("kept"), 3);  // two meshes, and what is proven of the robot
  EXPECT_EQ(plan("LEEWAY_CACHE_DIR=kept"), none);
  EXPECT_EQ(read("path.json"), path_text);
  EXPECT_EQ(kept("kept"), 3);
  for (const auto& entry : fs::directory_iterator(path("kept"))) {
    std::string bytes = readText(entry.path());
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    writeText(entry.path(), bytes);
  }
  EXPECT_EQ(plan("LEEWAY_CACHE_DIR=kept"), none);
  EXPECT_EQ(read("path.json"), path_text);
}

TEST_F(Cache, IsWhereTheEnvironmentSays) {
  plan("env -u LEEWAY_CACHE_DIR XDG_CACHE_HOME=\"$PWD/base\"");
  EXPECT_EQ(kept("base/leeway"), 3);
  plan("env -u LEEWAY_CACHE_DIR -u XDG_CACHE_HOME HOME=\"$PWD/home\"");
  EXPECT_EQ(kept("home/.cache/leeway"), 3);
}

TEST_F(Cache, IsLeftAloneWhereItIsNotWanted) {
  plan("LEEWAY_CACHE_DIR=kept", "--no-cache");
  EXPECT_EQ(kept("kept"), 0);
  plan("LEEWAY_CACHE_DIR=");
  // A proof makes everything anew.
  const Answer answer =
      shell("LEEWAY_CACHE_DIR=kept '" + leeway::commandFile() + "' verify ball.yaml path.json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(kept("kept"), 0);
}

TEST_F(Cache, RemembersWhatWasToldOfARobot) {
  // A tetrahedron without one of its faces: certificates rest on that warning, so it comes always.
  write("open.obj", "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  std::string text = kUrdf;
  const std::string box = R"(<box size="0.4 0.04 0.04"/>)";
  text.replace(text.rfind(box), box.size(), R"(<mesh filename="open.obj"/>)");
  text.insert(text.find("<link"), "<odd/>\n<strange/>\n<queer/>\n");
  write("odd.urdf", text);
  const auto told = [&](const std::string& verb) {
    const Answer answer = shell("LEEWAY_CACHE_DIR=kept '" + leeway::commandFile() + "' " + verb);
    EXPECT_EQ(answer.status, 0) << answer.err;
    return answer.err;
  };
  const std::string check =
      "check --robot odd.urdf --srdf arm.srdf --group arm --start left --goal right";
  const std::string first = told(check);
  EXPECT_NE(first.find("<queer>"), std::string::npos) << first;
  const std::string second = told(check);
  EXPECT_EQ(second.find("<queer>"), std::string::npos) << second;
  for (const std::string& told_each_time : {first, second})
    EXPECT_NE(told_each_time.find("a mesh is not closed"), std::string::npos) << told_each_time;
  EXPECT_NE(second.find("3 entries are left out, as told before"), std::string::npos) << second;
  EXPECT_NE(told("info odd.urdf").find("<queer>"), std::string::npos);
  EXPECT_EQ(told(check + " --no-cache"), first);
  write("odd.urdf", text.insert(text.find("<odd/>"), "<more/>"));
  EXPECT_NE(told(check).find("<queer>"), std::string::npos);
}

TEST_F(Cache, ThatCannotBeWrittenDoesNoHarm) {
  const json none = plan("LEEWAY_CACHE_DIR=");
  write("file", "no folder");
  for (const char* folder : {"file/below", "/proc/no/folder", "/dev/full"})
    EXPECT_EQ(plan(std::string("LEEWAY_CACHE_DIR=") + folder), none);
}

}  // namespace
}  // namespace leeway::tools::testing
