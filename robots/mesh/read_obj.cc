#include <algorithm>
#include <charconv>
#include <iterator>

#include "robots/base/read_file.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const MeshSource& source) : source_(source), rest_(source.text()) {}

  MeshContents run() {
    while (nextStatement()) readStatement();
    noteOpenEnd();
    FileMesh& mesh = mesh_;
    const auto count = static_cast<std::int32_t>(mesh.vertices.size());
    for (const FileMesh::Face& face : mesh.faces)
      for (const std::int32_t corner : mesh.cornersOf(face))
        if (corner >= count)
          source_.failAt(face.place, "the face names vertex " + std::to_string(corner + 1) +
                                         "; 1 to " + std::to_string(count) + " would be accepted");
    if (unknown_ > 0)
      contents_.notes.push_back(
          {first_unknown_.first, first_unknown_.second +
                                     " is no statement of the format and is "
                                     "left out" +
                                     (unknown_ == 1 ? ""
                                                    : ", as are " + std::to_string(unknown_ - 1) +
                                                          " more lines like it")});
    contents_.meshes.push_back(std::move(mesh_));
    contents_.instances.push_back({0, MeshContents::Placement::Identity()});
    return std::move(contents_);
  }

 private:
  /// A file that was cut in `f 1 2 34` may end in `f 1 2 3`.
  void noteOpenEnd() {
    if (last_line_.find('#') == last_line_.npos && !lastLineEnds(source_.text()))
      contents_.notes.push_back({FilePlace::line(lines_read_), std::string(kLastLineOpen)});
  }

  /// Reads a line without its comment. If it is a vertex or a face and ends with a backslash, the
  /// lines that continue it are included. (Comments, names and paths may end with a backslash by
  /// chance.)
  bool nextStatement() {
    if (rest_.empty()) return false;
    if (++statements_ % MeshSource::kLinesBetweenStops == 0) source_.pause();
    statement_ = nextLine();
    line_ = lines_read_;
    if (!statement_.ends_with('\\') || !isRead(Words(statement_).next())) return true;
    joined_.clear();
    while (statement_.ends_with('\\') && !rest_.empty()) {
      joined_ += statement_.substr(0, statement_.size() - 1);
      joined_ += ' ';
      statement_ = nextLine();
    }
    joined_ += statement_;
    statement_ = joined_;
    return true;
  }

  static bool isRead(std::string_view word) { return word == "v" || word == "f" || word == "fo"; }

  std::string_view nextLine() {
    last_line_ = takeLine(rest_);
    ++lines_read_;
    return last_line_.substr(0, last_line_.find('#'));
  }

  FilePlace place() const { return FilePlace::line(line_); }

  void readStatement() {
    Words words(statement_);
    const std::string_view word = words.next();
    if (isRead(word)) return word == "v" ? readVertex(words) : readFace(words);
    NotSolid& left_out = contents_.not_solid;
    if (word == "l" || word == "p" || word == "curv" || word == "cdc") readOthers(words);
    if (word == "l") left_out.count(left_out.lines, place());
    if (word == "p") left_out.count(left_out.points, place());
    if (word == "curv" || word == "curv2" || word == "cdc")
      left_out.count(left_out.curves, place());
    if (word == "surf" || word == "bzp" || word == "bsp" || word == "cdp")
      source_.failAt(place(),
                     "a free-form surface (" + std::string(word) + "); polygons would be accepted");
    if (word == "call" || word == "csh")
      source_.failAt(place(), shown(word) +
                                  " brings in what is not in this file; a file that holds "
                                  "all of its faces would be accepted");
    if (word == "V" || word == "F")
      source_.failAt(place(), shown(word) + " begins the line; " + (word == "V" ? "v" : "f") +
                                  " would be accepted");
    if (!word.empty() && !isKnown(word) && unknown_++ == 0) first_unknown_ = {place(), shown(word)};
  }

  /// Statements of the format that do not describe polygons.
  static bool isKnown(std::string_view word) {
    static constexpr std::string_view kKnown[] = {
        "l",   "p",        "curv",     "curv2",      "vt",        "vn",     "vp",     "g",
        "o",   "s",        "mg",       "mtllib",     "usemtl",    "usemap", "maplib", "bevel",
        "lod", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",  "stech",  "cstype",
        "deg", "bmat",     "step",     "parm",       "trim",      "hole",   "scrv",   "sp",
        "end", "con",      "cdc",      "res"};
    return std::find(std::begin(kKnown), std::end(kKnown), word) != std::end(kKnown);
  }

  /// X Y Z, with a weight W, three colours or four. W is the weight of a control point of rational
  /// curves and surfaces; programs disagree on what another one than 1 means for polygons.
  void readVertex(Words& words) {
    Eigen::Vector3d& v = mesh_.vertices.emplace_back();
    requireCountable(source_, mesh_.vertices.size(), place());
    for (int k = 0; k < 3; ++k) v[k] = coordinate(source_, words.next(), place());
    int more = 0;
    double weight = 1;
    for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++more) {
      const std::optional<double> value = parseNumber(word);
      if (!value)
        source_.failAt(place(), shown(word) +
                                    " stands where a number is expected; v X Y Z, with "
                                    "W or colours behind it, would be accepted");
      if (more == 0) weight = *value;
    }
    if (more != 0 && more != 1 && more != 3 && more != 4)
      source_.failAt(place(), "a vertex of " + std::to_string(3 + more) +
                                  " numbers; v X Y Z, with W or colours behind it, would be "
                                  "accepted");
    if (more == 1 && weight != 1)
      source_.failAt(
          place(), "a vertex whose weight is " + std::to_string(weight) + "; 1 would be accepted");
  }

  /// VERTEX, VERTEX/TEXTURE, VERTEX/TEXTURE/NORMAL or VERTEX//NORMAL for each corner.
  void readFace(Words& words) {
    const auto first = static_cast<std::int32_t>(mesh_.corners.size());
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
      mesh_.corners.push_back(corner(word));
    requireCountable(source_, mesh_.corners.size(), place());
    const auto count = static_cast<std::int32_t>(mesh_.corners.size()) - first;
    if (count < 3)
      source_.failAt(place(), "a face of " + std::to_string(count) +
                                  " corners; at least three would be accepted");
    mesh_.faces.push_back({first, count, place()});
  }

  /// Reads the vertices that a statement without faces uses. (curv begins with its range.)
  void readOthers(Words& words) {
    const auto so_far = static_cast<std::int32_t>(mesh_.vertices.size());
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      std::int32_t number = 0;
      std::from_chars(word.data(), word.data() + word.size(), number);
      if (number != 0) mesh_.others.push_back(number > 0 ? number - 1 : so_far + number);
    }
  }

  /// Negative numbers count back from the last vertex so far; positive numbers may refer to a later
  /// vertex.
  std::int32_t corner(std::string_view word) const {
    std::int32_t number = 0;
    const char* const end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, number);
    const auto so_far = static_cast<std::int32_t>(mesh_.vertices.size());
    const auto isReference = [](char c) { return c == '/' || c == '-' || (c >= '0' && c <= '9'); };
    if (error != std::errc() || (rest != end && *rest != '/') ||
        !std::all_of(rest, end, isReference) || number == 0)
      source_.failAt(place(), shown(word) +
                                  " stands where a corner is expected; the number of a vertex, "
                                  "1 or more, would be accepted");
    if (number < -so_far)
      source_.failAt(place(), "the face names vertex " + std::to_string(number) + " of the " +
                                  std::to_string(so_far) + " so far; -1 to -" +
                                  std::to_string(so_far) + " would be accepted");
    return number > 0 ? number - 1 : so_far + number;
  }

  const MeshSource& source_;
  std::string_view rest_, last_line_, statement_;
  std::string joined_;
  std::size_t statements_ = 0;
  std::int64_t lines_read_ = 0, line_ = 0;
  FileMesh mesh_;
  MeshContents contents_;
  std::int64_t unknown_ = 0;  // statements
  std::pair<FilePlace, std::string> first_unknown_;
};

}  // namespace

MeshContents readObj(const MeshSource& source) { return ObjReader(source).run(); }

}  // namespace leeway::robots
