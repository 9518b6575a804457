#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "leeway/planner/path_io.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"

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

/// Refuses what stamps cannot say, and numbers of rows that nobody can mean.
void checkTimes(const std::string& file, double duration, double period) {
  if (!(duration <= kLatestStamp))
    throw InputError(file, 0,
                     fmt::format("cannot be written: the motion takes {} s; no more than {} s, by "
                                 "faster limits, are expected",
                                 duration, kLatestStamp));
  if (period > 0 && !(duration / period <= kMostRows))
    throw InputError(file, 0,
                     fmt::format("cannot be written: {} s have more than {} rows {} s apart; a "
                                 "longer period is expected",
                                 duration, kMostRows, period));
}

/// When each waypoint is passed by a trajectory that stops at the corners [s].
std::vector<double> waypointTimes(const std::string& file, const Problem& problem,
                                  const ConfigurationSpace& space,
                                  const std::vector<std::vector<double>>& rows) {
  if (rows.empty()) return {};
  const Trajectory trajectory(std::make_shared<ConfigurationSpace>(space), rows,
                              motionLimits(problem));
  checkTimes(file, trajectory.duration(), 0);
  return {trajectory.times().begin(), trajectory.times().end()};
}

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

std::string timeText(double seconds) {
  const std::int64_t whole = nanoseconds(seconds);
  return fmt::format("{{\"sec\": {}, \"nanosec\": {}}}", whole / 1'000'000'000,
                     whole % 1'000'000'000);
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

std::string jsonHead(const Problem& problem, const std::vector<std::string>& names) {
  return fmt::format(
      "{{\n  \"header\": {{\"frame_id\": {}}},\n  \"joint_names\": {},\n  \"points\": [\n",
      quotedText(problem.model->links[0].name), namesText(names));
}

std::string yamlHead(const Problem& problem, const std::vector<std::string>& names) {
  return fmt::format("header: {{frame_id: {}}}\njoint_names: {}\npoints:\n",
                     quotedText(problem.model->links[0].name), namesText(names));
}

using Entries = std::vector<std::pair<std::string, std::string>>;

std::string jsonTail(const Entries& certificate) {
  std::string text = "  ],\n  \"certificate\": {\n";
  for (std::size_t i = 0; i < certificate.size(); ++i)
    text += fmt::format("    \"{}\": {}{}\n", certificate[i].first, certificate[i].second,
                        i + 1 < certificate.size() ? "," : "");
  return text + "  }\n}\n";
}

std::string yamlTail(const Entries& certificate) {
  std::string text = "certificate:\n";
  for (const auto& [key, value] : certificate) text += fmt::format("  {}: {}\n", key, value);
  return text;
}

std::string jsonText(const std::string& file, const Problem& problem,
                     const ConfigurationSpace& space, const PlanResult& result) {
  const auto rows = unwrapped(space, result.path.positions);
  const std::vector<double> times = waypointTimes(file, problem, space, rows);
  std::string text = jsonHead(problem, result.path.names);
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("    {{\"positions\": {}, \"time_from_start\": {}}}{}\n", rowText(rows[i]),
                        timeText(times[i]), i + 1 < rows.size() ? "," : "");
  return text + jsonTail(certificateEntries(problem, space, result.certificate));
}

std::string yamlText(const std::string& file, const Problem& problem,
                     const ConfigurationSpace& space, const PlanResult& result) {
  const auto rows = unwrapped(space, result.path.positions);
  const std::vector<double> times = waypointTimes(file, problem, space, rows);
  std::string text = yamlHead(problem, result.path.names);
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("  - positions: {}\n    time_from_start: {}\n", rowText(rows[i]),
                        timeText(times[i]));
  return text + yamlTail(certificateEntries(problem, space, result.certificate));
}

/// What a timed motion is at some moments.
struct Samples {
  std::vector<double> times;
  std::vector<std::vector<double>> positions, velocities, accelerations;
};

/// Rates of the numbers themselves: of a quaternion, from those of a rotation vector in the body's
/// frame (q' = q w / 2, q'' = q a / 2 - |w|^2 q / 4).
void quaternionRates(const double* q, double* velocity, double* acceleration) {
  const auto times = [q](const double* v, double* result) {
    result[0] = (q[3] * v[0] + q[1] * v[2] - q[2] * v[1]) / 2;
    result[1] = (q[3] * v[1] + q[2] * v[0] - q[0] * v[2]) / 2;
    result[2] = (q[3] * v[2] + q[0] * v[1] - q[1] * v[0]) / 2;
    result[3] = -(q[0] * v[0] + q[1] * v[1] + q[2] * v[2]) / 2;
  };
  double rate[4], second[4];
  times(velocity, rate);
  times(acceleration, second);
  const double squared =
      velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
  for (int k = 0; k < 4; ++k) {
    velocity[k] = rate[k];
    acceleration[k] = second[k] - squared / 4 * q[k];
  }
}

/// The moments of the rows: knots, and every `period` seconds where that is above 0. Of those that
/// a file cannot tell apart the last, from which on the motion goes as its row says, but the start
/// itself.
std::vector<double> sampleTimes(const Trajectory& trajectory, double period) {
  std::vector<double> times = trajectory.knots();
  if (period > 0)
    for (double k = 1; k * period < trajectory.duration(); ++k) times.push_back(k * period);
  std::sort(times.begin(), times.end());
  std::vector<double> result;
  for (const double time : times)
    if (result.empty() || nanoseconds(time) > nanoseconds(result.back()))
      result.push_back(time);
    else if (result.size() > 1 || time == trajectory.duration())
      result.back() = time;
  return result;
}

Samples sample(const Trajectory& trajectory, double period) {
  const ConfigurationSpace& space = trajectory.space();
  const std::size_t size = at(space.size());
  Samples samples;
  samples.times = sampleTimes(trajectory, period);
  for (const double time : samples.times) {
    std::vector<double> position(size), velocity(size), acceleration(size);
    trajectory.configuration(time, position);
    trajectory.velocity(time, velocity);
    trajectory.acceleration(time, acceleration);
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        double* q = &position[at(part.first)];
        // A waypoint may name the same orientation by the opposite numbers.
        if (!samples.positions.empty()) {
          const double* last = &samples.positions.back()[at(part.first)];
          if (q[0] * last[0] + q[1] * last[1] + q[2] * last[2] + q[3] * last[3] < 0)
            for (int k = 0; k < 4; ++k) q[k] = -q[k];
        }
        quaternionRates(q, &velocity[at(part.first)], &acceleration[at(part.first)]);
      }
    samples.positions.push_back(std::move(position));
    samples.velocities.push_back(std::move(velocity));
    samples.accelerations.push_back(std::move(acceleration));
  }
  samples.positions = unwrapped(space, std::move(samples.positions));
  return samples;
}

/// Of the motion as a whole: where corners are blended, what is proven of it are the margins, and
/// it may never be where the path is nearest.
Entries trajectoryEntries(const Problem& problem, const Trajectory& trajectory,
                          Certificate certificate) {
  std::string corners = "[";
  for (const Blend& blend : trajectory.blends()) {
    corners += fmt::format("{}{}", corners.size() > 1 ? ", " : "", blend.corner);
    double least = problem.margin;
    for (const Problem::PairMargin& pair : problem.margins) least = std::min(least, pair.margin);
    certificate.clearance.lower = std::min(certificate.clearance.lower, least);
  }
  if (certificate.closest_segment >= 0 &&
      !trajectory.passes(certificate.closest_segment, certificate.closest_t))
    certificate.clearance.upper = std::numeric_limits<double>::infinity();
  Entries entries;
  for (auto& entry : certificateEntries(problem, trajectory.space(), certificate))
    if (entry.first != "closest" && entry.first != "segments") entries.push_back(std::move(entry));
  entries.emplace_back("blended_corners", corners + "]");
  return entries;
}

/// RFC 4180: a field with a comma, a quote or a line end stands in quotes, quotes doubled.
std::string csvField(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

std::string csvText(const std::vector<std::string>& names, const std::vector<double>& times,
                    const std::vector<std::vector<double>>& rows) {
  std::string text = "time";
  for (const std::string& name : names) text += "," + csvField(name);
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
  if (ending == ".json") return writeFileWhole(file, jsonText(file, problem, space, result));
  if (ending == ".yaml" || ending == ".yml")
    return writeFileWhole(file, yamlText(file, problem, space, result));
  if (ending == ".csv") {
    const auto rows = unwrapped(space, result.path.positions);
    return writeFileWhole(
        file, csvText(result.path.names, waypointTimes(file, problem, space, rows), rows));
  }
  if (ending == ".path") return writeFileWhole(file, matrixText(space, result));
  throw InputError(
      file, 0,
      fmt::format("the ending '{}' names no format; .json, .yaml, .csv or .path is expected",
                  ending));
}

void writeTrajectory(const std::string& file, const Problem& problem, const PlanResult& result,
                     const Trajectory& trajectory, double period) {
  const std::string ending = std::filesystem::path(file).extension().string();
  const bool json = ending == ".json", yaml = ending == ".yaml" || ending == ".yml";
  if (!json && !yaml && ending != ".csv")
    throw InputError(
        file, 0,
        fmt::format("the ending '{}' names no format of trajectories; .json, .yaml or .csv is "
                    "expected",
                    ending));
  checkTimes(file, trajectory.duration(), period);
  const Samples samples = sample(trajectory, period);
  const std::vector<std::string>& names = result.path.names;
  if (ending == ".csv")
    return writeFileWhole(file, csvText(names, samples.times, samples.positions));
  std::string text = json ? jsonHead(problem, names) : yamlHead(problem, names);
  for (std::size_t i = 0; i < samples.times.size(); ++i) {
    const std::string positions = rowText(samples.positions[i]),
                      velocities = rowText(samples.velocities[i]),
                      accelerations = rowText(samples.accelerations[i]),
                      time = timeText(samples.times[i]);
    text += json ? fmt::format(
                       "    {{\"positions\": {}, \"velocities\": {}, \"accelerations\": {}, "
                       "\"time_from_start\": {}}}{}\n",
                       positions, velocities, accelerations, time,
                       i + 1 < samples.times.size() ? "," : "")
                 : fmt::format(
                       "  - positions: {}\n    velocities: {}\n    accelerations: {}\n    "
                       "time_from_start: {}\n",
                       positions, velocities, accelerations, time);
  }
  const Entries entries = trajectoryEntries(problem, trajectory, result.certificate);
  writeFileWhole(file, text + (json ? jsonTail(entries) : yamlTail(entries)));
}

}  // namespace leeway::planner
