#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/planner/point_cloud.h"
#include "planner/base/cells.h"
#include "robots/mesh/number_type.h"

namespace leeway::planner {

/// Where in a file something stands.
struct CloudPlace {
  std::size_t line = 0;  ///< from 1; 0: it is a byte
  std::size_t byte = 0;
};

/// A file of points in memory, and how readers complain about it.
class CloudSource {
 public:
  CloudSource(std::string path, std::string contents, const robots::Stop& stop)
      : path_(std::move(path)), contents_(std::move(contents)), stop_(stop) {}

  const std::string& path() const { return path_; }
  std::string_view text() const { return contents_; }
  [[noreturn]] void fail(CloudPlace place, const std::string& message) const;
  /// Throws Stopped where that was asked for. Called for each point.
  void pause(std::size_t point) const {
    if (point % (std::size_t{1} << 16U) == 0) robots::throwIfStopped(stop_, "points were read");
  }

 private:
  std::string path_, contents_;
  const robots::Stop& stop_;
};

/// The bytes of a file, of which `kind` says what is expected in it ("a point cloud"). Throws
/// robots::InputError for what cannot be read and for a pointer of Git LFS.
CloudSource readSource(const std::string& path, std::string_view kind, const robots::Stop& stop);

/// Collects points, and drops those that are not numbers.
class PointSink {
 public:
  explicit PointSink(const CloudSource& source) : source_(source) {}
  void add(const double (&p)[3], CloudPlace place);
  std::vector<Eigen::Vector3d>& points() { return points_; }
  std::size_t dropped() const { return dropped_; }
  /// The line of the last point; 0 in binary data.
  std::size_t lastLine() const { return last_line_; }

 private:
  const CloudSource& source_;
  std::vector<Eigen::Vector3d> points_;
  std::size_t dropped_ = 0, last_line_ = 0;
};

/// Reads type.size bytes.
double loadNumber(const char* from, robots::NumberType type, std::endian order);

/// The number at `place`, where a finite coordinate, "nan" or "inf" is expected.
double readCoordinate(const CloudSource& source, std::string_view word, CloudPlace place);
/// A whole number that is not negative.
std::size_t readCount(const CloudSource& source, std::string_view word, std::string_view what,
                      CloudPlace place);

/// A line of numbers or names in columns.
struct ColumnRow {
  std::size_t line;
  std::vector<std::string_view> cells;
  /// The words of the last comment before the first row that has one for each column, with x, y and
  /// z once each; empty if there is none.
  std::vector<std::string_view> names = {};
  /// Without such a comment: the line of one that seems to name columns in an order of its own,
  /// since it has the word qw, or x, y and z beside each other in another order.
  std::optional<std::size_t> unclear_names = {};
};
/// Calls visit() for each line that is not blank and no comment. Blanks, tabs, commas or semicolons
/// part the columns, as in the first line. Only between tabs, commas and semicolons are there empty
/// cells; a line of tabs alone is a row of them. Fails for lines of another number of columns, and
/// for a byte that no text has.
void eachRow(const CloudSource& source, const std::function<void(const ColumnRow&)>& visit);
/// Fails for a first row of numbers below a comment that seems to name columns but does not fit.
void refuseUnclearNames(const CloudSource& source, const ColumnRow& first);

// The readers. Each adds all points of its file, or throws.
void readPly(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink);
void readPcd(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink);
/// Numbers in columns, parted by blanks, commas or semicolons; a first line, or a comment before
/// the first row, may name the columns.
void readColumns(const CloudSource& source, PointSink& sink);

/// Decompresses LZF data (Marc Lehmann's liblzf) of exactly `size` bytes; nothing for data that is
/// damaged. O(size).
std::optional<std::string> decompressLzf(std::string_view data, std::size_t size);

}  // namespace leeway::planner
