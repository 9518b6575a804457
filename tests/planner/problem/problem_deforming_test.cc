// `deforming` and `execution` in problem files: meaning, and every message.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "planner/execute/obstacles.h"
#include "robots/mesh/mesh_import.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

namespace fs = std::filesystem;

class ProblemDeforming : public testing::Test {
 protected:
  void SetUp() override {
    write("square.obj",
          "# a square\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\nv 0 1 0\nf 1/1/1 2 3 -1\n");
    write("bent.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    write("three.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nf 1 2 3\n");
  }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }

  /// Lines 1 to 9 of a problem file; `more` starts in line 10.
  std::string file(const std::string& more) const {
    return write(
        "problem.yaml",
        "leeway: 1\nbody:\n  name: disc\n  joint: planar\n  bounds: {lower: [-3, -3], upper: "
        "[3, 3]}\n  shapes: [{cylinder: {radius: 0.1, length: 0.2}}]\nstart: {position: "
        "[-2, -2], angle: 0}\ngoal: {position: [2, -2]}\nmargin: 0.01\n" +
            more);
  }

  Problem load(const std::string& more) const { return loadProblem(file(more)); }

  /// A square with that motion, which starts in line 13.
  Problem square(const std::string& motion) const {
    return load("deforming:\n  - name: cloth\n    mesh: {file: square.obj}\n    motion:\n" +
                motion);
  }

  static Eigen::Vector3d vertexAt(const Problem& problem, double time, std::size_t v) {
    std::vector<Eigen::Vector3d> vertices(
        static_cast<std::size_t>(problem.world.deforming.at(0).mesh->vertexCount()));
    problem.world.deforming[0].motion->evaluate(time, vertices);
    return vertices.at(v);
  }

  void expectRefused(const std::string& more, int line, const std::string& message) const {
    const std::string name = file(more);
    try {
      loadProblem(name);
      ADD_FAILURE() << "accepted, but expected: " << message << "\n" << more;
    } catch (const robots::InputError& error) {
      const std::string what = error.what();
      EXPECT_EQ(error.line(), line) << what;
      EXPECT_NE(what.find(message), std::string::npos)
          << "got      " << what << "\nexpected " << message;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }

  Folder folder_;
};

TEST_F(ProblemDeforming, AFileKeepsItsVerticesNumbers) {
  const robots::IndexedMesh mesh =
      robots::importIndexed(folder_.path("square.obj"), Eigen::Vector3d::Ones(), "p.yaml", 1);
  ASSERT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(1, 1, 0));
  ASSERT_EQ(mesh.triangles.size(), 2U);
  EXPECT_EQ(mesh.triangles[1], (collision::DeformableMesh::Triangle{0, 2, 3}));
  const Problem grid =
      load("deforming:\n  - name: cloth\n    grid: {size: [2, 1], cells: [4, 3]}\n");
  const collision::DeformableMesh& cloth = *grid.world.deforming.at(0).mesh;
  EXPECT_EQ(cloth.rest().size(), 20U);
  EXPECT_EQ(cloth.triangles().size(), 24U);
  EXPECT_EQ(cloth.rest().front(), Eigen::Vector3d(-1, -0.5, 0));
  EXPECT_EQ(cloth.rest().back(), Eigen::Vector3d(1, 0.5, 0));
}

/// The notch of an L is not filled: every corner may be the face's first.
TEST_F(ProblemDeforming, ConcaveFacesKeepTheirNotch) {
  const std::string corners[6] = {"0 2 0", "0 0 0", "3 0 0", "3 1 0", "1 1 0", "1 2 0"};
  for (int first = 0; first < 6; ++first) {
    std::string obj;
    for (int i = 0; i < 6; ++i)
      obj += "v " + corners[static_cast<std::size_t>((first + i) % 6)] + '\n';
    write("ell.obj", obj + "f 1 2 3 4 5 6\n");
    const Problem problem = load(
        "deforming:\n  - name: sheet\n    position: [0, 0, 0.05]\n    mesh: {file: ell.obj}\n");
    EXPECT_EQ(problem.world.deforming.at(0).mesh->triangles().size(), 4U);
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    EXPECT_NEAR(certifier.clearance(std::vector<double>{1.3, 1.3, 0}, 1e-4).clearance.lower, 0.2,
                1e-3)
        << first;
  }
}

/// Regression: they were lost in silence.
TEST_F(ProblemDeforming, WarningsAboutFilesOfTargets) {
  write("odd.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nodd 1\nf 1 2 3 4\n");
  const std::string morph =
      "morph: {references: [{}, {file: odd.obj}], keys: [{time: 0, weights: "
      "[1, 0]}]}";
  const std::string frames = "cache: {times: [0], frames: [{file: odd.obj}]}";
  const std::string reduced = "reduced: {modes: [{file: odd.obj}], harmonics: [{frequency: 1}]}";
  for (const std::string& motion : {morph, frames, reduced}) {
    const Problem problem =
        load("deforming:\n  - name: cloth\n    mesh: {file: square.obj}\n    motion: {" + motion +
             "}\nmeshes: {cloth: {solid: surface}}\n");
    ASSERT_EQ(problem.warnings.size(), 1U) << motion;
    EXPECT_NE(problem.warnings[0].find("odd.obj:5: "), std::string::npos) << problem.warnings[0];
  }
}

/// Faces that are not planar are the triangles that they are cut into, with a warning.
TEST_F(ProblemDeforming, BentFacesAreTold) {
  write("bent_face.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3 4\nl 1 2\n");
  const Problem problem = load(
      "deforming:\n  - name: cloth\n    mesh: {file: bent_face.obj, scale: 2}\nmeshes: {cloth: "
      "{solid: surface}}\n");
  EXPECT_EQ(problem.world.deforming.at(0).mesh->triangles().size(), 2U);
  ASSERT_EQ(problem.warnings.size(), 2U);
  EXPECT_NE(problem.warnings[0].find("bent_face.obj:6: left out"), std::string::npos)
      << problem.warnings[0];
  EXPECT_NE(problem.warnings[1].find("bent_face.obj:5: a face is not planar, by 0."),
            std::string::npos)
      << problem.warnings[1];
}

TEST_F(ProblemDeforming, EverybodySeesTheStart) {
  const std::string text =
      "deforming:\n  - name: gate\n    position: [0, 0, 0]\n    rpy: [1.5707963267948966, 0, 0]\n"
      "    grid: {size: [0.4, 1], cells: [2, 2]}\n    margin: 0.03\n    strategy: morph\n    "
      "options: {volume: ball}\n    motion:\n"
      "      morph:\n        references: [{}, {bumps: [{center: [0, 0, 0], radius: 9, by: [5, 0, "
      "0]}]}]\n"
      "        keys: [{time: 0, weights: [1, 0]}, {time: 2, weights: [0, 1]}]\n";
  const auto clearanceAt = [&](const std::string& execution) {
    const Problem problem = load(text + execution);
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    return certifier.clearance(std::vector<double>{0.5, 0, 0}, 1e-4).clearance.lower;
  };
  EXPECT_NEAR(clearanceAt(""), 0.2, 1e-3);  // the gate ends at x = 0.2, the disc starts at 0.4
  EXPECT_GT(clearanceAt("execution: {start: 2}\n"), 3);
  const Problem problem = load(text);
  ASSERT_EQ(problem.world.deforming.size(), 1U);
  EXPECT_EQ(problem.world.deforming[0].options.strategy, collision::DeformStrategy::kMorph);
  EXPECT_EQ(problem.world.deforming[0].options.volume, collision::DeformVolume::kBall);
  EXPECT_EQ(problem.world.deforming[0].object.name, "gate");
  EXPECT_EQ(problem.margins.pairs.at(0).margin, 0.03);
  EXPECT_TRUE(problem.warnings.empty());
}

// By its name queries find it: no object that comes later may have it.
TEST_F(ProblemDeforming, ObjectsThatComeHaveOtherNames) {
  const Problem problem = load("deforming:\n  - name: cloth\n    mesh: {file: square.obj}\n");
  const CompiledScene scene(problem);
  Object ball{"cloth", {{collision::Shape::sphere(0.1), {}, "ball"}}, {}};
  EXPECT_THROW(scene.withObjects({{ball}}), robots::InputError);
  ball.name = "ball";
  const auto with_ball = scene.withObjects({{ball}});
  EXPECT_EQ(with_ball->scene().pairs().size(), scene.scene().pairs().size() + 1);
  // The shape of another instant changes neither margins nor what the problem says.
  const int cloth = scene.scene().find("cloth");
  const CompiledScene::Replacement same{
      cloth, 0, scene.scene().bodies()[static_cast<std::size_t>(cloth)].geometries[0].shape, 0};
  EXPECT_EQ(scene.withShapes({{same}})->withObjects({{ball}})->scene().pairs().size(),
            with_ball->scene().pairs().size());
}

// The time overflows: 0 m/s times infinity is NaN, no growth to add to a shape.
TEST_F(ProblemDeforming, NothingIsKnownAfterTimesThatNoDoubleHolds) {
  const Problem problem = load("deforming:\n  - name: cloth\n    mesh: {file: square.obj}\n");
  Obstacles obstacles(problem, std::make_shared<const CompiledScene>(problem));
  obstacles.set("cloth", problem.world.deforming.at(0).mesh->rest(), -1e308, {0});
  EXPECT_EQ(obstacles.growthOf(0, -1e308, 0).most, 0);
  const Obstacles::Growth growth = obstacles.growthOf(0, 0, 1e308);
  EXPECT_EQ(growth.most, std::numeric_limits<double>::infinity());
  EXPECT_EQ(growth.at_middle, std::numeric_limits<double>::infinity());
}

TEST_F(ProblemDeforming, Motions) {
  Problem p = square(
      "      waves: [{direction: [1, 0, 0], amplitude: [0, 0, 2], wavelength: 4, frequency: "
      "0.25}]\n");
  EXPECT_NEAR(vertexAt(p, 0, 1).z(), 2, 1e-12);
  EXPECT_NEAR(vertexAt(p, 1, 1).z(), 0, 1e-12);
  p = square(
      "      waves: [{direction: [1, 0, 0], amplitude: [0, 0, 2], wavelength: 4, frequency: "
      "0.25}]\n"
      "      pinned: {point: [0, 0, 0], direction: [0, 1, 0], length: 1}\n");
  EXPECT_EQ(vertexAt(p, 0, 1).z(), 0);
  EXPECT_NEAR(vertexAt(p, 0, 2).z(), 2, 1e-12);
  p = square(
      "      lattice:\n        box: {lower: [0, 0, -1], upper: [1, 1, 1]}\n        cells: [1, 1, "
      "1]\n"
      "        keys: [{time: 0}, {time: 1, moved: [{at: [1, 1, 0], by: [0, 0, 1]}, {at: [1, 1, 1], "
      "by: [0, 0, 1]}]}]\n");
  EXPECT_NEAR(vertexAt(p, 0, 2).z(), 0, 1e-12);
  EXPECT_NEAR(vertexAt(p, 1, 2).z(), 1, 1e-12);
  EXPECT_NEAR(vertexAt(p, 1, 0).z(), 0, 1e-12);
  p = square(
      "      morph: {references: [{}, {file: bent.obj, scale: 2}], keys: [{time: 0, weights: [1, "
      "0]}, "
      "{time: 1, weights: [0, 1]}]}\n");
  EXPECT_NEAR(vertexAt(p, 0.5, 2).z(), 0.5, 1e-12);
  p = square(
      "      reduced: {modes: [{file: bent.obj}], harmonics: [{frequency: 1, amplitude: 2}]}\n");
  EXPECT_NEAR(vertexAt(p, 0.25, 2).z(), 1, 1e-12);
  p = square(
      "      skinned:\n        bones: [{name: still}, {name: turns, position: [0, 1, 0], tip: [1, "
      "0, 0]}]\n"
      "        keys: [{time: 0}, {time: 1, poses: {turns: {rpy: [0, 0, 1.5707963267948966]}}}]\n");
  EXPECT_NEAR((vertexAt(p, 1, 2) - Eigen::Vector3d(0, 2, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((vertexAt(p, 1, 0) - Eigen::Vector3d(0, 0, 0)).norm(), 0, 1e-9);
}

TEST_F(ProblemDeforming, CachesOfAnimationTools) {
  // MDD, big endian: 2 frames at 0 and 0.5 s of 4 vertices; the third rises.
  std::string mdd;
  const auto put = [&mdd](std::uint32_t bits) {
    for (int shift = 24; shift >= 0; shift -= 8) mdd += static_cast<char>((bits >> shift) & 255U);
  };
  const auto real = [&](float x) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &x, 4);
    put(bits);
  };
  put(2);
  put(4);
  real(0);
  real(0.5F);
  for (int frame = 0; frame < 2; ++frame)
    for (int v = 0; v < 4; ++v) {
      real(static_cast<float>(v == 1 || v == 2));
      real(static_cast<float>(v >= 2));
      real(v == 2 ? static_cast<float>(frame) : 0.0F);
    }
  write("cloth.mdd", mdd);
  Problem p = square("      cache: {file: cloth.mdd}\n");
  EXPECT_NEAR(vertexAt(p, 0.25, 2).z(), 0.5, 1e-6);
  p = square("      cache: {file: cloth.mdd, start: 1, scale: 2}\n");
  EXPECT_NEAR(vertexAt(p, 1.25, 2).z(), 1, 1e-6);
  write("short.mdd", mdd.substr(0, mdd.size() - 5));
  const std::string head =
      "deforming:\n  - name: cloth\n    mesh: {file: square.obj}\n    motion:\n";
  expectRefused(head + "      cache: {file: short.mdd}\n", 14, "deforming[0].motion.cache");
  expectRefused(head + "      cache: {file: short.mdd}\n", 14, "short.mdd': MDD cache: ");
  // Well-formed, but with a NaN, or without increasing times.
  std::string broken = mdd;
  broken.replace(16, 4, std::string("\x7f\xc0\0\0", 4));
  write("broken.mdd", broken);
  expectRefused(head + "      cache: {file: broken.mdd}\n", 14,
                "broken.mdd': cache: frame 0, vertex 0: nan");
  broken = mdd;
  broken.replace(12, 4, 4, '\0');
  write("broken.mdd", broken);
  expectRefused(head + "      cache: {file: broken.mdd}\n", 14,
                "broken.mdd': cache: key 1: time 0");
  expectRefused(head + "      cache: {file: nowhere.pc2}\n", 14, "cannot be read");
  expectRefused(head + "      cache: {file: cloth.abc}\n", 14, ".pc2 or .mdd is expected");
  expectRefused(head + "      cache: {file: cloth.mdd, times: [0]}\n", 14,
                "deforming[0].motion.cache.times goes with 'frames' only");
  expectRefused(head + "      cache: {file: cloth.mdd, times: [0], frames: [{}]}\n", 14,
                "deforming[0].motion.cache has both 'file' and 'frames'; one is expected");
  expectRefused(head + "      cache: {times: [0], frames: [{}], rate: 5}\n", 14,
                "deforming[0].motion.cache.rate goes with 'file' only");
  expectRefused(
      head + "      cache: {times: [0, 1], frames: [{}]}\n", 14,
      "deforming[0].motion.cache.times has 2 numbers; as many as 'frames', 1, are expected");
  expectRefused(head + "      cache: {frames: [{}]}\n", 14, "key 'times' is missing");
  fs::create_directories(folder_.path("folder.pc2"));
  expectRefused(head + "      cache: {file: folder.pc2}\n", 14, "cannot be read");
  expectRefused(
      "deforming:\n  - name: cloth\n    mesh: {file: three.obj}\n    motion:\n      cache: {file: "
      "cloth.mdd}\n",
      14, "has 4 vertices; the mesh's 3 are expected");
}

TEST_F(ProblemDeforming, ObjectsThatMove) {
  const Problem problem = load(
      "objects:\n  - name: door\n    box: {size: [1, 0.1, 1]}\n    moving:\n      keys:\n"
      "        - {time: 0, position: [1, 0, 0]}\n        - {time: 4, position: [1, 2, 0], rpy: [0, "
      "0, 1]}\n  - name: cart\n    position: [0, 1, 0]\n    sphere: {radius: 0.1}\n    moving: "
      "{velocity: [0.5, 0, 0], time: 1}\n  - name: person\n    position: [2, 2, 0]\n    shapes: "
      "[{position: [0.3, 0, 0], sphere: {radius: 0.1}}]\n    moving: {speed_bound: 1.5, "
      "turn_bound: "
      "2, age: 0.25}\n  - {name: post, sphere: {radius: 0.1}}\nexecution: {start: 3}\n");
  const std::vector<Object>& objects = problem.world.objects;
  ASSERT_EQ(objects.size(), 4u);
  EXPECT_NEAR(objects[0].X_WO.translation.y(), 1.5, 1e-12);  // as at the start of the execution
  EXPECT_NEAR(objects[0].X_WO.rotation(0, 0), std::cos(0.75), 1e-12);
  EXPECT_EQ(objects[0].motion->poses->keyPoses().size(), 2u);
  EXPECT_NEAR(objects[1].X_WO.translation.x(), 1, 1e-12);
  EXPECT_TRUE(objects[1].motion->poses->isSteady());
  EXPECT_EQ(objects[2].motion->poses, nullptr);
  EXPECT_EQ(objects[2].motion->speed_bound, 1.5);
  EXPECT_EQ(objects[2].motion->turn_bound, 2);
  EXPECT_EQ(objects[2].motion->age, 0.25);
  EXPECT_EQ(objects[3].motion, nullptr);
}

/// The shorter way is not the way that the numbers seem to say.
TEST_F(ProblemDeforming, TurnsOfKeysBeyondHalfATurnAreSaid) {
  const auto warnings = [&](const std::string& from, const std::string& to) {
    const Problem problem = load(
        "objects:\n  - name: door\n    box: {size: [1, 0.1, 1]}\n    moving: {keys: [{time: 0, "
        "rpy: "
        "[0, 0, " +
        from + "]}, {time: 4, rpy: [0, 0, " + to + "]}]}\n");
    return std::count_if(problem.warnings.begin(), problem.warnings.end(), [](const auto& warning) {
      return warning.find("as written; the object turns the shorter way") != std::string::npos;
    });
  };
  EXPECT_EQ(warnings("0", "3.1"), 0);
  EXPECT_EQ(warnings("-1.5", "1.5"), 0);
  EXPECT_EQ(warnings("0", "4.71"), 1);
  EXPECT_EQ(warnings("3.1", "-3.1"), 1);
  EXPECT_EQ(warnings("0", "6.2831853"), 1);
}

TEST_F(ProblemDeforming, MessagesOfObjectsThatMove) {
  const std::string head = "objects:\n  - name: cart\n";  // line 11
  const std::string box = head + "    box: {size: [1, 1, 1]}\n";
  const auto refused = [&](const std::string& moving, const std::string& message) {
    expectRefused(box + "    moving: " + moving + "\n", 13, message);
  };
  refused("{speed_bund: 1}",
          "unknown key 'speed_bund' in objects[0].moving; did you mean 'speed_bound'?");
  refused("{}", "has no 'speed_bound', and neither 'keys' nor 'velocity'");
  refused("{speed_bound: 1}", "has no 'turn_bound'");
  refused("{speed_bound: -1, turn_bound: 0}", "objects[0].moving.speed_bound");
  refused("{speed_bound: 1, turn_bound: 1, time: 2}", "'age' is expected");
  refused("{velocity: [1, 0, 0], age: 1}", "key 'age' stands beside 'velocity'");
  refused("{velocity: [1, 0]}", "objects[0].moving.velocity");
  refused("{velocity: [1, 0, 1e10]}", "the velocity is out of range");
  refused("{velocity: [1, 0, 0], turning: [0, 0, 1], keys: [{time: 0}]}",
          "key 'velocity' stands beside 'keys'");
  refused("{velocity: [1, 0, 0], speed_bound: 0.5, turn_bound: 0}", "may reach 1");
  refused("{keys: []}", "keys is empty");
  refused("{keys: [{position: [0, 0, 0]}]}", "key 'time' is missing");
  refused("{keys: [{time: 0, pose: 1}]}", "unknown key 'pose'");
  refused("{keys: [{time: 1}, {time: 1}]}", "keys[1].time is not after");
  for (const char* half : {"3.14159265358979", "3.14159", "3.1416", "-3.142"})
    refused(std::string("{keys: [{time: 0}, {time: 1, rpy: [0, 0, ") + half + "]}]}",
            "objects[0].moving.keys[1] is half a turn from the key before it");
  expectRefused(box + "    position: [1, 0, 0]\n    moving: {keys: [{time: 0}]}\n", 13,
                "key 'position' stands beside 'moving.keys'");
  expectRefused(head + "    half_space: {}\n    moving: {velocity: [0, 0, 1]}\n", 13, "half-space");
  expectRefused(box + "    attach: {link: disc}\n    moving: {velocity: [0, 0, 1]}\n", 14,
                "'moving' stands beside 'attach'");
}

TEST_F(ProblemDeforming, Messages) {
  const std::string head = "deforming:\n  - name: cloth\n";
  expectRefused(head, 11, "has neither 'grid' nor 'mesh'");
  expectRefused(head + "    grid: {size: [1, 1], cells: [2, 2]}\n    mesh: {file: square.obj}\n",
                11, "has both 'grid' and 'mesh'");
  expectRefused(head + "    grid: {size: [1, 0], cells: [2, 2]}\n", 12, "above 0");
  expectRefused(head + "    grid: {size: [1, 1], cells: [2000, 501]}\n", 12, "1000000");
  expectRefused(head + "    gird: {size: [1, 1], cells: [2, 2]}\n", 12,
                "unknown key 'gird' in deforming[0]; did you mean 'grid'?");
  expectRefused(head + "    mesh: {file: nowhere.obj}\n", 12, "does not exist");
  write("solid.stl", "solid x\nendsolid x\n");
  expectRefused(head + "    mesh: {file: solid.stl}\n", 12, "an OBJ is expected");
  const std::string grid = head + "    grid: {size: [1, 1], cells: [2, 2]}\n";  // line 12
  expectRefused(grid + "    strategy: refitt\n", 13, "did you mean 'refit'?");
  expectRefused(grid + "    strategy: skinned\n", 13, "");
  expectRefused(grid + "    options: {restructure_factor: 1}\n", 13, "above 1");
  expectRefused(grid + "    options: {volume: bal}\n", 13, "did you mean 'ball'?");
  expectRefused(grid + "    motion: {}\n", 13, "none of waves, lattice");
  expectRefused(
      grid + "    motion: {pinned: {point: [0, 0, 0], direction: [0, 1, 0], length: 1}}\n", 13,
      "none of waves");
  expectRefused(
      grid + "    motion: {waves: [{direction: [1, 0, 0], amplitude: [0, 0, 1], frequency: 1}]}\n",
      13, "key 'wavelength' is missing");
  expectRefused(grid +
                    "    motion: {waves: [{direction: [1, 0, 0], amplitude: [0, 0, 1], wavelength: "
                    "1, frequency: .nan}]}\n",
                13, "a finite number is expected");
  const auto morph = [&](const std::string& keys) {
    return grid +
           "    motion: {morph: {references: [{}, {bumps: [{center: [0, 0, 0], radius: 1, by: [0, "
           "0, 1]}]}], keys: [" +
           keys + "]}}\n";
  };
  EXPECT_NO_THROW(load(morph("{time: 0, weights: [1, 0]}, {time: 1, weights: [0, 1]}")));
  expectRefused(morph("{time: 1, weights: [1, 0]}, {time: 0, weights: [0, 1]}"), 13,
                "deforming[0].motion.morph");  // key times out of order
  expectRefused(morph("{time: 1, weights: [1]}"), 13, "deforming[0].motion.morph");
  expectRefused(morph("{time: 1, weight: [1, 0]}"), 13, "did you mean 'weights'?");
  expectRefused(grid +
                    "    motion: {morph: {references: [{file: three.obj}], keys: [{time: 0, "
                    "weights: [1]}]}}\n",
                13, "three.obj has 3 vertices; the mesh's 9 are expected");
  expectRefused(grid +
                    "    motion: {morph: {references: [{bumps: [{center: [5, 0, 0], radius: 1, by: "
                    "[0, 0, 1]}]}], keys: [{time: 0, weights: [1]}]}}\n",
                13, "moves no vertex");
  expectRefused(
      grid + "    motion: {skinned: {bones: [{name: a}], keys: [{time: 0, poses: {b: {}}}]}}\n", 13,
      "unknown bone 'b'");
  expectRefused(grid +
                    "    motion: {waves: [{direction: [1, 0, 0], amplitude: [0, 0, 1], wavelength: "
                    "1, frequency: 1}]}\n    speed_bound: 0.5\n",
                14, "the motion may reach");
  write("bad.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
  write("bad_face.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
  expectRefused(head + "    mesh: {file: bad.obj}\n", 12,
                "bad.obj:2: the coordinate 'nan' is not finite");
  expectRefused(head + "    mesh: {file: bad_face.obj}\n", 12,
                "bad_face.obj:4: the face names vertex 7; 1 to 3 would be accepted");
  expectRefused("objects:\n  - {name: cloth, sphere: {radius: 0.1}}\n" + grid, 13,
                "name of another object");
}

TEST_F(ProblemDeforming, ExecutionIsReadAndRefused) {
  const Problem p = load(
      "execution: {start: 1, step: 0.1, duration: 7, speed: 0.5, velocities: {disc/x: 2}, "
      "foresight: "
      "speed_bound, look_ahead: 0, buffer: 0.03, patience: 1}\n");
  EXPECT_EQ(p.execution.start, 1);
  EXPECT_EQ(p.execution.step, 0.1);
  EXPECT_EQ(p.execution.duration, 7);
  EXPECT_EQ(p.execution.speed, 0.5);
  EXPECT_EQ(p.execution.velocities.at("disc/x"), 2);
  EXPECT_EQ(p.execution.foresight, Foresight::kSpeedBound);
  EXPECT_EQ(p.execution.look_ahead, 0);
  EXPECT_EQ(p.execution.buffer, 0.03);
  EXPECT_EQ(p.execution.patience, 1);
  const Problem q =
      load("execution: {velocities: 3, accelerations: {disc/x: 4}, jerks: 50, corners: blend}\n");
  EXPECT_EQ(q.execution.velocities.at("disc/y"), 3);
  EXPECT_EQ(q.execution.accelerations.size(), 1U);
  EXPECT_EQ(q.execution.accelerations.at("disc/x"), 4);
  EXPECT_EQ(q.execution.jerks.at("disc/x"), 50);
  EXPECT_EQ(q.execution.corners, Corners::kBlend);
  EXPECT_EQ(load("execution: {corners: stop}\n").execution.corners, Corners::kStop);
  const Problem scaled = load("execution: {acceleration_scale: 0.5, jerk_scale: 0.25}\n");
  EXPECT_EQ(scaled.execution.acceleration_scale, 0.5);
  EXPECT_EQ(scaled.execution.jerk_scale, 0.25);
  EXPECT_EQ(scaled.execution.corners, Corners::kBlend);
  expectRefused("execution: {acceleration_scale: 2}\n", 10, "a share of the acceleration limits");
  expectRefused("execution: {jerk_scale: 0}\n", 10, "a share of the jerk limits");
  expectRefused("execution: {accelerations: 0}\n", 10,
                "execution.accelerations is 0; a number from 1e-09 to 1000000000 is expected");
  expectRefused("execution: {accelerations: fast}\n", 10, "fast");
  expectRefused("execution: {jerks: {disc/x: -1}}\n", 10,
                "a number from 1e-09 to 1000000000 is expected");
  expectRefused("execution: {corners: cut}\n", 10, "stop or blend is expected");
  expectRefused("execution: {step: 0}\n", 10, "execution.step is 0; a number above 0 is expected");
  expectRefused("execution: {duration: 0.01}\n", 10, "at least a step, 0.05 s, is expected");
  expectRefused("execution: {speed: 1.5}\n", 10, "up to 1");
  expectRefused("execution: {velocities: {disc/w: 2}}\n", 10,
                "execution.velocities: no planned variable is named 'disc/w'; did you mean");
  expectRefused("execution: {foresight: all}\n", 10, "motion or speed_bound is expected");
  expectRefused("execution: {sped: 1}\n", 10, "did you mean 'speed'?");
}

}  // namespace
}  // namespace leeway::planner
