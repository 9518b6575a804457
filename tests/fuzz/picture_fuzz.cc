// Any bytes as a depth image and as a height field of each format: balls and heights within the
// limits, a closed solid, or an error with a message.

#include <cmath>

#include "leeway/collision/invalid_shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/depth_image.h"
#include "leeway/planner/height_field.h"
#include "leeway/robots/input_error.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"
#include "tests/support/png.h"

namespace leeway::fuzz {
namespace {

void checkDepthImage(const std::string& path) {
  const planner::PointCloud cloud =
      planner::loadDepthImage(path, "", {500, 400, 1, 2, 0.001, 1}, 0.01);
  if (cloud.balls.empty()) fail("%s: no ball and no error", path.c_str());
  if (const std::string fault = planner::cloudFault(cloud); !fault.empty())
    fail("%s: %s", path.c_str(), fault.c_str());
  if (planner::thinnedTo(cloud, 3).size() > 3) fail("%s: more than three balls", path.c_str());
}

void checkHeightField(const std::string& path, bool is_picture) {
  std::vector<std::string> warnings;
  planner::HeightFile file;
  if (is_picture)
    file.scale = 0.01;
  else
    file.missing = 1;
  planner::HeightField field = planner::loadHeightField(path, file, warnings);
  if (field.heights.size() != field.columns * field.rows)
    fail("%s: %zu heights", path.c_str(), field.heights.size());
  if (field.heights.size() > 1000) return;
  field.step_x = 0.1;
  field.step_y = -0.1;
  field.floor = -1;
  const collision::Shape shape = planner::heightFieldShape(field);
  if (shape.mesh()->openEdgeCount() > 0) fail("%s: the solid is open", path.c_str());
}

}  // namespace

std::vector<std::string> seedInputs() {
  return {PngWriter{3, 2, 16}.write({1, 2, 3, 500, 600, 700}),
          PngWriter{3, 3, 8, 0, true}.write({1, 2, 3, 4, 5, 6, 7, 8, 9}),
          PngWriter{2, 2, 1}.write({0, 1, 1, 0}),
          "P2\n# a\n2 2 1000\n1 2 3 4\n",
          std::string("P5 2 2 1000\n\0\1\0\2\0\3\0\4", 20),
          std::string("P5 2 2 9\n\1\2\3\4", 13),
          "1,2\n3,nan\n,4\n"};
}

std::vector<std::string> dictionary() {
  return {"P2\n", "P5\n", "65535", "65536", "2147483648", "#", "IHDR", "IDAT",
          "IEND", "nan",  "inf",   "1e400", ";",          ",", "\r\n"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  for (const std::string name : {"a.png", "a.pgm", "a.csv"}) {
    const std::string path = fuzz::writeInput(name, {data, size});
    const bool is_picture = name != "a.csv";
    for (const bool as_depth : {true, false}) {
      try {
        if (!as_depth)
          fuzz::checkHeightField(path, is_picture);
        else if (is_picture)
          fuzz::checkDepthImage(path);
      } catch (const robots::InputError& error) {
        if (error.what()[0] == '\0') fuzz::fail("an error without a message");
      } catch (const collision::InvalidShape& error) {
        if (as_depth) fuzz::fail("%s: %s", path.c_str(), error.what());
      }
    }
  }
  return 0;
}
