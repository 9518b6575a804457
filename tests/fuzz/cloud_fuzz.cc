// Any bytes as a point cloud or an octree of each format: finite points and boxes within the
// limits, or an InputError.

#include <cmath>

#include "leeway/planner/octree.h"
#include "leeway/planner/point_cloud.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ";
  const std::string ply =
      " 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string twelve(12, '\x3F');
  return {
      "1 2 3\n4 5 6\n",
      "x,y,z\n1,2,nan\n",
      "ply\nformat ascii" + ply + "1 2 3\n",
      "ply\nformat binary_little_endian" + ply + twelve,
      "ply\nformat binary_big_endian" + ply + twelve,
      pcd + "ascii\n1 2 3\n",
      pcd + "binary\n" + twelve,
      "# Octomap OcTree binary file\nid OcTree\nsize 4\nres 0.1\ndata\n" +
          std::string("\x03\x00\x06\x00", 4),
      "# Octomap OcTree file\nid OcTree\nsize 2\nres 0.1\ndata\n" +
          std::string("\0\0\x80\x3F\x01\0\0\x80\xBF\0", 10),
      pcd + "binary_compressed\n" + std::string("\x05\0\0\0\x0C\0\0\0\x00\x3F\xE0\x02\x00", 13)};
}

std::vector<std::string> dictionary() {
  return {"ply\n",
          "format ascii 1.0\n",
          "element vertex ",
          "property list uchar int ",
          "property float x\n",
          "end_header\n",
          "FIELDS ",
          "SIZE ",
          "TYPE ",
          "COUNT ",
          "WIDTH ",
          "HEIGHT ",
          "POINTS ",
          "VIEWPOINT ",
          "DATA binary\n",
          "DATA binary_compressed\n",
          "DATA ascii\n",
          "# Octomap OcTree binary file\n",
          "# Octomap OcTree file\n",
          "id ColorOcTree\n",
          "size ",
          "res ",
          "data\n",
          "nan",
          "-inf",
          "2147483647",
          "1e400",
          ";",
          ",",
          "\r\n"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  for (const char* name : {"a.ply", "a.pcd", "a.xyz"}) {
    const std::string path = fuzz::writeInput(name, {data, size});
    std::vector<std::string> warnings;
    try {
      const planner::PointCloud cloud = planner::loadCloud(path, 0.01, warnings);
      if (cloud.balls.empty()) fuzz::fail("%s: no point and no error", name);
      for (const planner::PointCloud::Ball& ball : cloud.balls)
        if (!(ball.center.cwiseAbs().maxCoeff() <= 1e9))
          fuzz::fail("%s: a point that is none", name);
      if (planner::thinned(cloud, 0.5).size() > cloud.size()) fuzz::fail("%s: thinning adds", name);
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  for (const char* name : {"a.bt", "a.ot"}) {
    const std::string path = fuzz::writeInput(name, {data, size});
    try {
      double volumes[2] = {};
      for (const planner::Unseen unseen : {planner::Unseen::kFree, planner::Unseen::kOccupied})
        for (const robots::Geometry& box : planner::loadOctree(path, unseen))
          volumes[unseen == planner::Unseen::kFree ? 0 : 1] += box.shape.halfExtents().prod();
      if (!(volumes[0] <= volumes[1] * (1 + 1e-9))) fuzz::fail("%s: less is occupied", name);
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  return 0;
}
