#include "planner/sensed/cloud_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "collision/base/tolerances.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "robots/base/read_file.h"
#include "robots/mesh/scan.h"

namespace leeway::planner {
namespace {

constexpr std::size_t kLongestCloud = std::size_t{2} << 30U;  // [bytes]

}  // namespace

void CloudSource::fail(CloudPlace place, const std::string& message) const {
  if (place.line > 0) throw robots::InputError(path_, static_cast<int>(place.line), message);
  throw robots::InputError(path_, 0, fmt::format("byte {}: {}", place.byte, message));
}

CloudSource readSource(const std::string& path, std::string_view kind, const robots::Stop& stop) {
  CloudSource source(path, robots::readBinaryFile(path, kind, kLongestCloud), stop);
  if (source.text().starts_with("version https://git-lfs"))
    throw robots::InputError(
        path, 0, "is a pointer of Git LFS, not the file itself; `git lfs pull` fetches it");
  return source;
}

void PointSink::add(const double (&p)[3], CloudPlace place) {
  last_line_ = place.line;
  if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
    ++dropped_;
    return;
  }
  for (const double value : p)
    if (std::abs(value) > collision::kLargestSize)
      source_.fail(place, fmt::format("the coordinate {} is too large; up to {} m are accepted",
                                      value, collision::kLargestSize));
  points_.emplace_back(p[0], p[1], p[2]);
}

double loadNumber(const char* from, robots::NumberType type, std::endian order) {
  return robots::loadNumber(reinterpret_cast<const std::byte*>(from), type, order);
}

double readCoordinate(const CloudSource& source, std::string_view word, CloudPlace place) {
  const auto value = robots::parseNumber(word);
  // (Words for numbers that are not finite have an n; other infinite ones are out of range.)
  if (value && std::isinf(*value) && word.find_first_of("nN") == std::string_view::npos)
    source.fail(place, fmt::format("the coordinate {} is too large; up to {} m are accepted",
                                   robots::shown(word), collision::kLargestSize));
  if (value) return *value;
  source.fail(place, fmt::format("{} stands where a coordinate is expected; a number, or nan for "
                                 "a point that was not seen, is accepted",
                                 robots::shown(word)));
}

std::size_t readCount(const CloudSource& source, std::string_view word, std::string_view what,
                      CloudPlace place) {
  std::size_t count = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error == std::errc() && end == word.data() + word.size() && count <= 0x7FFFFFFF) return count;
  source.fail(place, fmt::format("{} is {}; a whole number from 0 to 2147483647 is accepted", what,
                                 robots::shown(word)));
}

PointCloud loadCloud(const std::string& path, double radius, std::vector<std::string>& warnings,
                     const robots::Stop& stop) {
  const std::string ending = robots::endingOf(path);
  const bool in_columns = ending == ".xyz" || ending == ".txt" || ending == ".csv";
  if (ending != ".ply" && ending != ".pcd" && !in_columns)
    throw robots::InputError(
        path, 0,
        fmt::format("has the ending '{}', which no format of point clouds has; .ply, .pcd, .xyz, "
                    ".txt and .csv are accepted",
                    ending));
  const CloudSource source = readSource(path, "a point cloud", stop);
  PointSink sink(source);
  if (ending == ".ply")
    readPly(source, warnings, sink);
  else if (ending == ".pcd")
    readPcd(source, warnings, sink);
  else
    readColumns(source, sink);
  if (sink.lastLine() > 0 && !robots::lastLineEnds(source.text()))
    warnings.push_back(fmt::format("{}:{}: {}", path, sink.lastLine(), robots::kLastLineOpen));
  if (sink.points().empty())
    throw robots::InputError(
        path, 0,
        sink.dropped() == 0
            ? "holds no point; at least one is expected"
            : fmt::format("holds {} points, none of which is a number; at least one that is is "
                          "expected",
                          sink.dropped()));
  PointCloud cloud = makeCloud({sink.points().data(), sink.points().size(), sizeof(Eigen::Vector3d),
                                PointArray::Number::kDouble},
                               radius);
  if (sink.dropped() > 0)
    cloud.filters.push_back({"drop", "points that are not numbers", sink.dropped()});
  return cloud;
}

}  // namespace leeway::planner
