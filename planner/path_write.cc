#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"

namespace leeway::planner {
namespace {

using robots::InputError;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// 17 digits bring every double back to the bit. What is not finite has no number in JSON.
std::string numberText(double x) { return std::isfinite(x) ? fmt::format("{:.17g}", x) : "null"; }

/// A JSON string is a YAML string too.
std::string quotedText(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string rowText(const std::vector<double>& row) {
  std::string text = "[";
  for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? ", " : "") + numberText(row[i]);
  return text + "]";
}

std::string namesText(const std::vector<std::string>& names) {
  std::string text = "[";
  for (std::size_t i = 0; i < names.size(); ++i) text += (i > 0 ? ", " : "") + quotedText(names[i]);
  return text + "]";
}

std::vector<std::vector<double>> unwrapped(const ConfigurationSpace& space,
                                           std::vector<std::vector<double>> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) space.unwrap(rows[i - 1], rows[i]);
  return rows;
}

/// The least time in which the edge from a to b keeps every velocity limit [s].
double edgeTime(const ConfigurationSpace& space, const std::vector<double>& a,
                const std::vector<double>& b) {
  std::vector<double> dq(a.size());
  space.difference(a, b, dq);
  double time = 0;
  for (const ConfigurationSpace::Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    const double limit = space.model().variables[at(space.variables()[i])].velocity;
    const double change =
        part.kind == ConfigurationSpace::Kind::kRotation
            ? std::sqrt(dq[i] * dq[i] + dq[i + 1] * dq[i + 1] + dq[i + 2] * dq[i + 2])
            : std::abs(dq[i]);
    time = std::max(time, change / (std::isfinite(limit) && limit > 0 ? limit : 1));
  }
  return time;
}

std::vector<double> waypointTimes(const ConfigurationSpace& space,
                                  const std::vector<std::vector<double>>& rows) {
  std::vector<double> times(rows.size());
  for (std::size_t i = 1; i < rows.size(); ++i)
    times[i] = times[i - 1] + edgeTime(space, rows[i - 1], rows[i]);
  return times;
}

std::string timeText(double seconds) {
  const std::int64_t nanoseconds = std::llround(seconds * 1e9);
  return fmt::format("{{\"sec\": {}, \"nanosec\": {}}}", nanoseconds / 1'000'000'000,
                     nanoseconds % 1'000'000'000);
}

const char* interpolationName(const ConfigurationSpace& space) {
  for (const ConfigurationSpace::Part& part : space.parts())
    if (part.kind == ConfigurationSpace::Kind::kRotation) return "SE(3) geodesic";
  for (const int v : space.variables())
    if (space.model().joints[at(space.model().variables[at(v)].joint)].type ==
        robots::JointType::kPlanar)
      return "SE(2) geodesic";
  return "joint-linear";
}

/// How far from its place on the path every point of the robot may be while margins hold: half of
/// what the path leaves above the largest margin, because two links may both be off towards each
/// other [m].
double trackingTolerance(const Problem& problem, const Certificate& certificate) {
  double margin = problem.margin;
  for (const Problem::PairMargin& pair : problem.margins) margin = std::max(margin, pair.margin);
  return certificate.certified ? std::max(0.0, (certificate.clearance.lower - margin) / 2) : 0;
}

/// Key and value of the certificate's entries, in order, each a JSON text.
std::vector<std::pair<std::string, std::string>> certificateEntries(
    const Problem& problem, const ConfigurationSpace& space, const Certificate& certificate) {
  std::string closest = "null", segments = "[";
  if (certificate.closest_segment >= 0)
    closest = fmt::format("{{\"a\": {}, \"b\": {}, \"segment\": {}, \"t\": {}}}",
                          quotedText(certificate.closest_a), quotedText(certificate.closest_b),
                          certificate.closest_segment, numberText(certificate.closest_t));
  for (std::size_t i = 0; i < certificate.segments.size(); ++i)
    segments += fmt::format("{}{{\"clearance_lower\": {}}}", i > 0 ? ", " : "",
                            numberText(certificate.segments[i].lower));
  return {{"certified", certificate.certified ? "true" : "false"},
          {"interpolation", quotedText(interpolationName(space))},
          {"margin", numberText(problem.margin)},
          {"tracking_tolerance", numberText(trackingTolerance(problem, certificate))},
          {"clearance_lower", numberText(certificate.clearance.lower)},
          {"clearance_upper", numberText(certificate.clearance.upper)},
          {"closest", closest},
          {"segments", segments + "]"}};
}

std::string jsonText(const Problem& problem, const ConfigurationSpace& space,
                     const PlanResult& result) {
  const auto rows = unwrapped(space, result.path.positions);
  const std::vector<double> times = waypointTimes(space, rows);
  std::string text = fmt::format(
      "{{\n  \"header\": {{\"frame_id\": {}}},\n  \"joint_names\": {},\n  \"points\": [\n",
      quotedText(problem.model->links[0].name), namesText(result.path.names));
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("    {{\"positions\": {}, \"time_from_start\": {}}}{}\n", rowText(rows[i]),
                        timeText(times[i]), i + 1 < rows.size() ? "," : "");
  text += "  ],\n  \"certificate\": {\n";
  const auto entries = certificateEntries(problem, space, result.certificate);
  for (std::size_t i = 0; i < entries.size(); ++i)
    text += fmt::format("    \"{}\": {}{}\n", entries[i].first, entries[i].second,
                        i + 1 < entries.size() ? "," : "");
  return text + "  }\n}\n";
}

std::string yamlText(const Problem& problem, const ConfigurationSpace& space,
                     const PlanResult& result) {
  const auto rows = unwrapped(space, result.path.positions);
  const std::vector<double> times = waypointTimes(space, rows);
  std::string text =
      fmt::format("header: {{frame_id: {}}}\njoint_names: {}\npoints:\n",
                  quotedText(problem.model->links[0].name), namesText(result.path.names));
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("  - positions: {}\n    time_from_start: {}\n", rowText(rows[i]),
                        timeText(times[i]));
  text += "certificate:\n";
  for (const auto& [key, value] : certificateEntries(problem, space, result.certificate))
    text += fmt::format("  {}: {}\n", key, value);
  return text;
}

/// RFC 4180: a field with a comma, a quote or a line end stands in quotes, quotes doubled.
std::string csvField(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

std::string csvText(const ConfigurationSpace& space, const PlanResult& result) {
  const auto rows = unwrapped(space, result.path.positions);
  const std::vector<double> times = waypointTimes(space, rows);
  std::string text = "time";
  for (const std::string& name : result.path.names) text += "," + csvField(name);
  text += "\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += numberText(times[i]);
    for (const double x : rows[i]) text += "," + numberText(x);
    text += "\n";
  }
  return text;
}

std::string matrixText(const ConfigurationSpace& space, const PlanResult& result) {
  std::string text;
  for (const std::vector<double>& row : unwrapped(space, result.path.positions)) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? " " : "") + numberText(row[i]);
    text += "\n";
  }
  return text;
}

[[noreturn]] void failWriting(const std::string& file, int error) {
  throw InputError(
      file, 0,
      fmt::format("cannot be written: {}; a writable path is expected", std::strerror(error)));
}

/// All of `text`, or the error number.
int writeText(int descriptor, const std::string& text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    written += static_cast<std::size_t>(count);
  }
  return 0;
}

/// All of `text` to the disk, or the error number.
int writeAll(int descriptor, const std::string& text) {
  if (const int error = writeText(descriptor, text); error != 0) return error;
  // A full disk may show only here.
  return ::fsync(descriptor) == 0 ? 0 : errno;
}

/// Into what is there and is no file, such as /dev/stdout; returns the error number.
int writeThrough(const std::string& file, const std::string& text) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  int error = writeText(descriptor, text);
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// What a chain of symbolic links ends at, whether that exists or not.
std::string linkTarget(const std::string& name) {
  constexpr int kLongestChain = 40;  // as Linux
  std::filesystem::path path = name;
  std::error_code error;
  for (int i = 0; i < kLongestChain && std::filesystem::is_symlink(path, error); ++i) {
    // /proc's links to pipes and sockets name no path: only the link itself can be opened.
    if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
      break;
    const std::filesystem::path target = std::filesystem::read_symlink(path, error);
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  return path.string();
}

}  // namespace

void writeFileWhole(const std::string& name, const std::string& text) {
  // A link stays and what it names is replaced; a device or pipe would be lost by a rename.
  const std::string file = linkTarget(name);
  struct stat existing {};
  const bool exists = ::stat(file.c_str(), &existing) == 0;
  if (exists && !S_ISREG(existing.st_mode) && !S_ISDIR(existing.st_mode)) {
    if (const int error = writeThrough(file, text); error != 0) failWriting(file, error);
    return;
  }
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored))
    failWriting(file, EISDIR);
  std::string temporary;
  int descriptor = -1;
  // Another run may be writing the same file, or may have died while it did.
  for (int attempt = 0; descriptor < 0 && attempt < 100; ++attempt) {
    temporary = fmt::format("{}.{}.{}.tmp", file, ::getpid(), attempt);
    descriptor = ::open(temporary.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) break;
  }
  if (descriptor < 0) failWriting(file, errno);
  int error = writeAll(descriptor, text);
  if (error == 0 && exists && ::fchmod(descriptor, existing.st_mode & 0777U) != 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  failWriting(file, error);
}

void writePath(const std::string& file, const Problem& problem, const PlanResult& result) {
  const ConfigurationSpace space(problem.model, problem.variables);
  for (const std::vector<double>& row : result.path.positions)
    if (row.size() != problem.variables.size())
      throw std::invalid_argument("writePath: a row is not as long as the group");
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending == ".json") return writeFileWhole(file, jsonText(problem, space, result));
  if (ending == ".yaml" || ending == ".yml")
    return writeFileWhole(file, yamlText(problem, space, result));
  if (ending == ".csv") return writeFileWhole(file, csvText(space, result));
  if (ending == ".path") return writeFileWhole(file, matrixText(space, result));
  throw InputError(
      file, 0,
      fmt::format("the ending '{}' names no format; .json, .yaml, .csv or .path is expected",
                  ending));
}

}  // namespace leeway::planner
