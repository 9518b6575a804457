#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "leeway/robots/text.h"
#include "planner/sensed/cloud_source.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_source.h"

// The format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html

namespace leeway::planner {
namespace {

constexpr std::size_t kLargestFieldCount = std::size_t{1} << 20U;
constexpr std::size_t kLargestPoint = std::size_t{1} << 24U;  // [bytes]

using robots::NumberType;

/// Nothing for a kind that has no such size.
std::optional<NumberType> numberType(NumberType::Kind kind, std::size_t size) {
  const bool is_known =
      size == 4 || size == 8 || (kind != NumberType::Kind::kFloat && (size == 1 || size == 2));
  if (!is_known) return std::nullopt;
  return NumberType{kind, size};
}

struct PcdField {
  std::string_view name;
  NumberType type;
  std::size_t count = 1;
  std::size_t bytes() const { return type.size * count; }
};

class PcdPoints {
 public:
  PcdPoints(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink)
      : source_(source), rest_(source.text()), warnings_(warnings), sink_(sink) {}

  void run() {
    const std::string_view data = readHeader();
    makeFields();
    countPoints();
    if (data == "ascii")
      readText();
    else if (data == "binary")
      readRecords();
    else
      readCompressed();
  }

 private:
  struct Entry {
    std::vector<std::string_view> words;  // after the key
    std::size_t line = 0;
  };

  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    source_.fail({std::max<std::size_t>(line, 1), 0}, message);
  }
  std::size_t byte() const { return source_.text().size() - rest_.size(); }

  /// The kind of data, which begins after the header.
  std::string_view readHeader() {
    static constexpr std::string_view kKeys[] = {"VERSION", "FIELDS", "SIZE",   "TYPE",
                                                 "COUNT",   "WIDTH",  "HEIGHT", "VIEWPOINT",
                                                 "POINTS",  "DATA"};
    while (!rest_.empty()) {
      ++line_;
      std::vector<std::string_view> words = wordsOf(robots::takeLine(rest_));
      if (words.empty() || words[0].starts_with('#')) continue;
      const std::string_view key = words[0] == "COLUMNS" ? "FIELDS" : words[0];
      if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys))
        fail(line_, fmt::format("the header's line {} is not known; VERSION, FIELDS, SIZE, TYPE, "
                                "COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS and DATA are accepted",
                                robots::shown(key)));
      words.erase(words.begin());
      if (!entries_.emplace(key, Entry{words, line_}).second)
        fail(line_, fmt::format("{} stands twice in the header; once is expected", key));
      if (key == "DATA") return kindOfData();
    }
    fail(line_, "the file ends within its header; DATA is expected");
  }

  std::string_view kindOfData() const {
    const Entry& data = entries_.at("DATA");
    for (const std::string_view kind : {"ascii", "binary", "binary_compressed"})
      if (data.words.size() == 1 && data.words[0] == kind) return kind;
    fail(data.line, fmt::format("DATA is {}; ascii, binary and binary_compressed are accepted",
                                data.words.empty() ? "empty" : robots::shown(data.words[0])));
  }

  const Entry& required(std::string_view key) const {
    const auto found = entries_.find(key);
    if (found == entries_.end())
      fail(line_, fmt::format("the header has no {}; it is expected", key));
    return found->second;
  }

  void makeFields() {
    const Entry& names = required("FIELDS");
    const auto listed = [&](std::string_view key) -> const Entry& {
      const Entry& entry = required(key);
      if (entry.words.size() != names.words.size())
        fail(entry.line, fmt::format("{} has {} entries; {}, as FIELDS has, are expected", key,
                                     entry.words.size(), names.words.size()));
      return entry;
    };
    const Entry &sizes = listed("SIZE"), &types = listed("TYPE");
    const Entry* const counts = entries_.count("COUNT") != 0 ? &listed("COUNT") : nullptr;
    for (std::size_t i = 0; i < names.words.size(); ++i) {
      PcdField field{names.words[i], {}, 1};
      const std::string_view type = types.words[i];
      const auto kind = type == "F"   ? NumberType::Kind::kFloat
                        : type == "I" ? NumberType::Kind::kSigned
                                      : NumberType::Kind::kUnsigned;
      const auto known =
          type == "F" || type == "I" || type == "U"
              ? numberType(kind, readCount(source_, sizes.words[i], "a SIZE", {sizes.line, 0}))
              : std::nullopt;
      if (!known)
        fail(types.line,
             fmt::format("field '{}' has type {} of {} bytes; F of 4 or 8, I or U of 1, "
                         "2, 4 or 8 are accepted",
                         field.name, robots::shown(type), sizes.words[i]));
      field.type = *known;
      if (counts != nullptr)
        field.count = readCount(source_, counts->words[i], "a COUNT", {counts->line, 0});
      if (field.count == 0 || field.count > kLargestFieldCount)
        fail(counts->line, fmt::format("field '{}' has a COUNT of {}; 1 to {} are accepted",
                                       field.name, field.count, kLargestFieldCount));
      point_bytes_ += field.bytes();
      if (point_bytes_ > kLargestPoint)
        fail(names.line,
             fmt::format("a point has more than {} bytes; fewer are accepted", kLargestPoint));
      fields_.push_back(field);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view name = std::string_view("xyz").substr(axis, 1);
      const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const PcdField& f) {
        return f.name == name && f.count == 1;
      });
      if (found == fields_.end())
        fail(names.line,
             fmt::format("there is no field '{}' of COUNT 1; x, y and z are expected", name));
      if (std::count_if(fields_.begin(), fields_.end(),
                        [&](const PcdField& f) { return f.name == name; }) > 1)
        fail(names.line, fmt::format("two fields are named '{}'; one of each is expected", name));
      axes_[axis] = static_cast<std::size_t>(found - fields_.begin());
    }
    if (const auto viewpoint = entries_.find("VIEWPOINT"); viewpoint != entries_.end())
      noteViewpoint(viewpoint->second);
  }

  /// PCL leaves points in the frame of the sensor that took them, and so does this.
  void noteViewpoint(const Entry& viewpoint) {
    static constexpr double kIdentity[] = {0, 0, 0, 1, 0, 0, 0};
    bool is_identity = viewpoint.words.size() == 7;
    for (std::size_t i = 0; is_identity && i < 7; ++i)
      is_identity = robots::parseNumber(viewpoint.words[i]) == kIdentity[i];
    if (!is_identity)
      warnings_.push_back(fmt::format(
          "{}:{}: VIEWPOINT is not applied: points are taken as they are written, in the frame of "
          "the object",
          source_.path(), viewpoint.line));
  }

  void countPoints() {
    const auto count = [&](std::string_view key) {
      const Entry& entry = required(key);
      return readCount(source_, entry.words.empty() ? std::string_view() : entry.words[0], key,
                       {entry.line, 0});
    };
    const std::size_t width = count("WIDTH"), height = count("HEIGHT");
    points_ = width * height;
    const auto found = entries_.find("POINTS");
    if (found == entries_.end()) return;
    if (const std::size_t points = count("POINTS"); points != points_)
      fail(found->second.line,
           fmt::format("POINTS is {}; WIDTH times HEIGHT, {}, is expected", points, points_));
  }

  void readText() {
    for (std::size_t i = 0; i < points_; ++i) {
      source_.pause(i);
      if (rest_.empty())
        fail(line_ + 1,
             fmt::format("the file ends after {} of {} points; all are expected", i, points_));
      ++line_;
      const std::vector<std::string_view> words = wordsOf(robots::takeLine(rest_));
      double p[3] = {0, 0, 0};
      std::size_t at = 0;
      for (std::size_t f = 0; f < fields_.size(); ++f) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          if (axes_[axis] == f && at < words.size())
            p[axis] = readCoordinate(source_, words[at], {line_, 0});
        at += fields_[f].count;
      }
      if (at != words.size())
        fail(line_, fmt::format("the line has {} numbers; {} are expected", words.size(), at));
      sink_.add(p, {line_, 0});
    }
    while (!rest_.empty()) {
      ++line_;
      if (!wordsOf(robots::takeLine(rest_)).empty())
        fail(line_,
             fmt::format("more than {} points; as many as POINTS says are expected", points_));
    }
  }

  /// Only zeros may follow the points: some writers pad their files with them.
  void expectEnd() {
    const std::size_t at = rest_.find_first_not_of('\0');
    if (at != std::string_view::npos)
      source_.fail(
          {0, byte() + at},
          fmt::format("more than {} points; as many as POINTS says are expected", points_));
    if (!rest_.empty())
      warnings_.push_back(
          fmt::format("{}: byte {}: {} bytes of value 0 follow the {} points, and are left out",
                      source_.path(), byte(), rest_.size(), points_));
  }

  [[noreturn]] void failShort(std::size_t points) const {
    source_.fail({0, source_.text().size()},
                 fmt::format("the file ends after {} of {} points of {} bytes; all are expected",
                             points, points_, point_bytes_));
  }

  void readRecords() {
    if (rest_.size() / point_bytes_ < points_) failShort(rest_.size() / point_bytes_);
    std::array<std::size_t, 3> offsets{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t f = 0; f < axes_[axis]; ++f) offsets[axis] += fields_[f].bytes();
    for (std::size_t i = 0; i < points_; ++i) {
      source_.pause(i);
      double p[3];
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = loadNumber(rest_.data() + offsets[axis], fields_[axes_[axis]].type,
                             std::endian::little);
      sink_.add(p, {0, byte()});
      rest_.remove_prefix(point_bytes_);
    }
    expectEnd();
  }

  /// Two sizes, then the fields one after the other, compressed. Fields named '_' pad records, and
  /// are left out.
  void readCompressed() {
    constexpr NumberType kWord{NumberType::Kind::kUnsigned, 4};
    if (rest_.size() < 8)
      source_.fail({0, byte()},
                   "the file ends before the two sizes of compressed data; both are "
                   "expected");
    const auto compressed =
        static_cast<std::size_t>(loadNumber(rest_.data(), kWord, std::endian::little));
    const auto size =
        static_cast<std::size_t>(loadNumber(rest_.data() + 4, kWord, std::endian::little));
    std::size_t point = 0;
    std::array<std::size_t, 3> offsets{};
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (axes_[axis] == f) offsets[axis] = point;
      if (fields_[f].name != "_") point += fields_[f].bytes();
    }
    if (point == 0 || size % point != 0 || size / point != points_)
      source_.fail({0, byte() + 4}, fmt::format("the data has {} bytes; {} points of {} bytes are "
                                                "expected",
                                                size, points_, point));
    rest_.remove_prefix(8);
    if (compressed > rest_.size())
      source_.fail({0, source_.text().size()},
                   fmt::format("the file ends after {} of {} compressed bytes; all are expected",
                               rest_.size(), compressed));
    const auto data = decompressLzf(rest_.substr(0, compressed), size);
    if (!data)
      source_.fail({0, byte()},
                   "the compressed data is damaged; LZF data of the size that its "
                   "header says is expected");
    for (std::size_t i = 0; i < points_; ++i) {
      source_.pause(i);
      double p[3];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const NumberType type = fields_[axes_[axis]].type;
        p[axis] = loadNumber(data->data() + offsets[axis] * points_ + i * type.size, type,
                             std::endian::little);
      }
      sink_.add(p, {0, byte()});
    }
    rest_.remove_prefix(compressed);
    expectEnd();
  }

  const CloudSource& source_;
  std::string_view rest_;
  std::vector<std::string>& warnings_;
  PointSink& sink_;
  std::size_t line_ = 0;
  std::map<std::string_view, Entry> entries_;
  std::vector<PcdField> fields_;
  std::array<std::size_t, 3> axes_{};  // the fields of x, y and z
  std::size_t point_bytes_ = 0, points_ = 0;
};

}  // namespace

void readPcd(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink) {
  PcdPoints(source, warnings, sink).run();
}

}  // namespace leeway::planner
