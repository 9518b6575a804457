// Worlds of ten thousand objects and of a million triangles, from file to verified path.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

constexpr int kObjects = 10'000;

struct Ball {
  double x, y, z, radius;
};

std::string inYaml(const std::string& name, const Ball& b) {
  return "  - {name: " + name + ", position: [" + std::to_string(b.x) + ", " + std::to_string(b.y) +
         ", " + std::to_string(b.z) + "], sphere: {radius: " + std::to_string(b.radius) + "}}\n";
}

/// How far the ball's surface is from the point (x, y, z).
double apart(const Ball& b, double x, double y, double z) {
  return std::sqrt((b.x - x) * (b.x - x) + (b.y - y) * (b.y - y) + (b.z - z) * (b.z - z)) -
         b.radius;
}

class LargeWorlds : public CommandTest {
 protected:
  /// A shipped problem; `more` are further objects of it.
  void writeProblem(const std::string& name, const std::string& shipped,
                    const std::string& more) const {
    std::string text = readText(fs::path(leeway::sourceFolder()) / "problems" / shipped);
    const std::string from = "../../robots", to = leeway::sourceFolder() + "/robots";
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at))
      text.replace(at, from.size(), to);
    write(name, text.insert(text.find("margin:"), more));
  }

  /// A shipped problem with ten thousand balls in a box around it where `leaves` lets them be is
  /// planned, verified and measured; a ball that is then put on the path is found among them.
  void passesAmong(const std::string& shipped, double margin, double half_width,
                   const std::function<bool(const Ball&)>& leaves) {
    std::mt19937 random(1);
    const auto uniform = [&](double lower, double upper) {
      return lower + (upper - lower) * static_cast<double>(random()) * 0x1p-32;
    };
    std::string balls;
    for (int i = 0; i < kObjects;) {
      const Ball b{uniform(-half_width, half_width), uniform(-half_width, half_width),
                   uniform(-0.5, 2.5), uniform(0.003, 0.03)};
      if (leaves(b)) balls += inYaml("ball_" + std::to_string(i++), b);
    }
    writeProblem("world.yaml", shipped, balls);
    const Answer plan = run("plan world.yaml --output path.json --time 200 --json");
    ASSERT_EQ(plan.status, 0) << plan.err;
    const json certificate = plan.document()["certificate"];
    EXPECT_EQ(certificate["certified"], true);
    EXPECT_GE(certificate["clearance_lower"], margin);

    const Answer verified = run("verify world.yaml path.json --json");
    EXPECT_EQ(verified.status, 0) << verified.err;
    EXPECT_EQ(verified.document()["status"], "certified");
    EXPECT_GE(verified.document()["clearance_lower"], margin);
    EXPECT_LE(verified.document()["clearance_lower"], certificate["clearance_upper"]);

    const json profile = run("clearance world.yaml path.json --json").document();
    EXPECT_LE(certificate["clearance_lower"], profile["clearance_upper"]);
    EXPECT_GE(certificate["clearance_upper"], profile["clearance_lower"]);

    const json segments = profile["segments"];
    ASSERT_FALSE(segments.empty());
    const json at = segments[segments.size() / 2]["world"]["closest"]["point_a"];
    writeProblem("blocked.yaml", shipped, balls + inYaml("intruder", {at[0], at[1], at[2], 0.002}));
    const Answer refuted = run("verify blocked.yaml path.json --json");
    EXPECT_EQ(refuted.status, 1) << refuted.err;
    EXPECT_EQ(refuted.document()["status"], "refuted");
    EXPECT_NE(refuted.out.find("intruder"), std::string::npos) << refuted.out;
  }
};

TEST_F(LargeWorlds, AnArmWithSixJoints) {
  passesAmong("table/posts.yaml", 0.005, 3,
              [](const Ball& b) { return apart(b, 0, 0, 0.4) > 0.95; });
}

TEST_F(LargeWorlds, AnArmWithSevenJoints) {
  passesAmong("shelf/reach.yaml", 0.01, 3, [](const Ball& b) { return apart(b, 0, 0, 0.4) > 1.1; });
}

TEST_F(LargeWorlds, ABody) {
  passesAmong("bodies/window.yaml", 0.005, 2, [](const Ball& b) {
    const bool window = std::abs(b.x) < 0.7 && std::abs(b.y) < 0.7 && std::abs(b.z - 1) < 0.6;
    return !window && apart(b, -1, 0, 1) > 0.6 && apart(b, 1, 0.2, 1) > 0.6;
  });
}

/// Hills of a million triangles, as a scanner would leave them; a body flies through their pass.
TEST_F(LargeWorlds, AMeshOfAMillionTriangles) {
  constexpr int kCells = 708;
  const auto vertex = [](int i, int j) {
    const double x = 6.0 * i / kCells - 3, y = 6.0 * j / kCells - 3;
    const double ridge = 1.6 * std::exp(-x * x / 0.04) * (1 - 0.8 * std::exp(-y * y / 0.2));
    return std::array<float, 3>{
        static_cast<float>(x), static_cast<float>(y),
        static_cast<float>(ridge + 0.02 * std::sin(40 * x) * std::cos(31 * y))};
  };
  std::ofstream file(path("hills.stl"), std::ios::binary);
  const std::uint32_t count = 2 * kCells * kCells;
  std::vector<char> bytes(80);
  const auto append = [&bytes](const void* data, std::size_t size) {
    const char* first = static_cast<const char*>(data);
    bytes.insert(bytes.end(), first, first + size);
  };
  append(&count, sizeof count);
  constexpr std::array<float, 3> kNoNormal = {0, 0, 0};
  constexpr std::uint16_t kNoAttribute = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const auto a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1),
                 d = vertex(i, j + 1);
      for (const auto& triangle : {std::array{a, b, c}, std::array{a, c, d}}) {
        append(kNoNormal.data(), sizeof kNoNormal);
        for (const auto& corner : triangle) append(corner.data(), sizeof corner);
        append(&kNoAttribute, sizeof kNoAttribute);
      }
    }
  }
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  ASSERT_TRUE(file);
  write("hills.yaml", R"(leeway: 1
body:
  name: cross
  joint: floating
  bounds: {lower: [-1.5, -1.0, 0.2], upper: [1.5, 1.0, 1.4]}
  shapes:
    - {name: beam, box: {size: [0.9, 0.1, 0.1]}}
    - {name: arm, box: {size: [0.1, 0.5, 0.1]}, position: [0.25, 0, 0]}
start: {position: [-1.0, 0.4, 0.6], rpy: [0, 0, 1.5707963267948966]}
goal: {position: [1.0, -0.2, 0.7], rpy: [0, 0.4, 0]}
objects:
  - {name: hills, mesh: {file: hills.stl}}
margin: 0.005
limits: {time: 20}
)");
  const Answer plan = run("plan hills.yaml --output path.json --time 200 --json");
  ASSERT_EQ(plan.status, 0) << plan.err;
  EXPECT_EQ(plan.document()["certificate"]["certified"], true);
  EXPECT_GE(plan.document()["certificate"]["clearance_lower"], 0.005);
  const Answer verified = run("verify hills.yaml path.json --json");
  EXPECT_EQ(verified.status, 0) << verified.err;
  EXPECT_GE(verified.document()["clearance_lower"], 0.005);
  EXPECT_LE(verified.document()["clearance_lower"],
            plan.document()["certificate"]["clearance_upper"]);
}

}  // namespace
}  // namespace leeway::tools::testing
