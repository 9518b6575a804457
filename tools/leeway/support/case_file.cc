#include "tools/leeway/support/case_file.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <span>
#include <sstream>

#include "leeway/robots/input_error.h"
#include "leeway/robots/text.h"

namespace leeway::tools {
namespace {

using collision::Pose;
using collision::Shape;
using robots::InputError;

/// Reads the words of one line one by one. Every error has the file and line.
class LineReader {
 public:
  LineReader(const std::string& file, int line, const std::string& text)
      : file_(file), line_(line), stream_(text) {}

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(file_, line_, message);
  }

  std::string word(const char* what) {
    std::string result;
    if (!(stream_ >> result)) fail(std::string("the line ends where ") + what + " is expected");
    return result;
  }

  double number(const char* what) {
    const std::string text = word(what);
    const std::optional<double> value = robots::parseFinite(text);
    if (!value) fail(std::string(what) + " is '" + text + "'; a finite number is expected");
    return *value;
  }

  std::int64_t integer(const char* what,
                       std::int64_t lower = std::numeric_limits<std::int64_t>::min(),
                       std::int64_t upper = std::numeric_limits<std::int64_t>::max()) {
    const std::string text = word(what);
    errno = 0;
    char* end = nullptr;
    const long long value = std::strtoll(text.c_str(), &end, 10);
    if (end == text.c_str() || *end != '\0' || errno != 0 || value < lower || value > upper) {
      std::string wanted = "an integer";
      if (lower != std::numeric_limits<std::int64_t>::min())
        wanted += " from " + std::to_string(lower);
      if (upper != std::numeric_limits<std::int64_t>::max())
        wanted += " to " + std::to_string(upper);
      fail(std::string(what) + " is '" + text + "'; " + wanted + " is expected");
    }
    return value;
  }

  Eigen::Vector3d vector(const char* what) {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = number(what);
    return v;
  }

  Pose pose() {
    Pose X;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) X.rotation(r, c) = number("an entry of the rotation");
    X.translation = vector("an entry of the translation");
    return X;
  }

  void end() {
    std::string rest;
    if (stream_ >> rest) fail("'" + rest + "' stands after the end of what is expected");
  }

 private:
  const std::string& file_;
  int line_;
  std::istringstream stream_;
};

Shape readHull(LineReader& line, std::vector<Eigen::Vector3d>& vertices) {
  // No valid file reaches this limit. It keeps a mistyped count from requesting all memory.
  constexpr std::int64_t kMost = 10'000'000;
  const std::int64_t vertex_count = line.integer("the number of vertices", 1, kMost);
  const std::int64_t face_count = line.integer("the number of faces", 0, kMost);
  for (std::int64_t i = 0; i < vertex_count; ++i)
    vertices.push_back(line.vector("a vertex coordinate"));
  // The engine computes its own facets. The file's are read only to report broken lines.
  for (std::int64_t i = 0; i < 3 * face_count; ++i)
    line.integer("a vertex index of a face", 0, vertex_count - 1);
  return Shape::convexHull(std::span<const Eigen::Vector3d>(vertices));
}

Shape readShape(LineReader& line, std::vector<Eigen::Vector3d>& points) {
  const std::string type = line.word("a shape type");
  try {
    if (type == "box") return Shape::box(line.vector("a half size"));
    if (type == "sphere") return Shape::sphere(line.number("the radius"));
    if (type == "capsule" || type == "cylinder") {
      const double radius = line.number("the radius");
      const double half_length = line.number("the half length");
      return type == "capsule" ? Shape::capsule(radius, half_length)
                               : Shape::cylinder(radius, half_length);
    }
    if (type == "hull") return readHull(line, points);
  } catch (const collision::InvalidShape& error) {
    line.fail(error.what());
  }
  line.fail("unknown shape type '" + type +
            "'; box, sphere, capsule, cylinder or hull is expected");
}

/// Calls f(line reader, first word) for every line with contents.
template <typename Function>
void forEachLine(const std::string& file, const Function& f) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file, 0, "cannot be opened; a readable file is expected");
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos || text[first] == '#') continue;
    LineReader line(file, number, text);
    f(line);
    line.end();
  }
  if (stream.bad())
    throw InputError(file, 0, "cannot be read to its end; a readable file is expected");
}

}  // namespace

CaseFile readCaseFile(const std::string& file) {
  CaseFile result;
  std::unordered_map<std::int64_t, std::size_t> index_of_shape;
  std::unordered_map<std::int64_t, bool> known_case;
  forEachLine(file, [&](LineReader& line) {
    const std::string kind = line.word("'shape' or 'case'");
    if (kind == "shape") {
      const std::int64_t id = line.integer("the shape's ID");
      if (!index_of_shape.emplace(id, result.shapes.size()).second)
        line.fail("shape " + std::to_string(id) + " is given twice; every shape needs its own ID");
      result.points.emplace_back();
      result.shapes.push_back(readShape(line, result.points.back()));
    } else if (kind == "case") {
      Case c;
      c.id = line.integer("the case's ID");
      if (!known_case.emplace(c.id, true).second)
        line.fail("case " + std::to_string(c.id) + " is given twice; every case needs its own ID");
      c.family = line.word("the family");
      c.part = line.word("SUB");
      for (std::size_t* shape : {&c.shape_a, &c.shape_b}) {
        const std::int64_t id = line.integer("a shape's ID");
        const auto found = index_of_shape.find(id);
        if (found == index_of_shape.end())
          line.fail("unknown shape " + std::to_string(id) +
                    "; the ID of a shape given above is expected");
        *shape = found->second;
      }
      c.X_WA = line.pose();
      c.X_WB = line.pose();
      result.cases.push_back(std::move(c));
    } else {
      line.fail("unknown word '" + kind + "'; 'shape' or 'case' is expected");
    }
  });
  if (result.cases.empty())
    throw InputError(file, 0, "holds no case; at least one line 'case ...' is expected");
  return result;
}

std::unordered_map<std::int64_t, Reference> readReferenceFile(const std::string& file) {
  std::unordered_map<std::int64_t, Reference> result;
  forEachLine(file, [&](LineReader& line) {
    const std::int64_t id = line.integer("the case's ID");
    Reference r;
    r.verdict = static_cast<int>(line.integer("the verdict", -1, 1));
    r.distance = line.number("the distance");
    r.gap = line.number("the width");
    r.has_value = line.integer("HASVALUE", 0, 1) == 1;
    r.extent = line.number("the largest coordinate");
    if (!result.emplace(id, r).second)
      line.fail("case " + std::to_string(id) + " is given twice; every case needs its own ID");
  });
  return result;
}

}  // namespace leeway::tools
