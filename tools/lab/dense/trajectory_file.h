#pragma once

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace leeway::dense {

struct TrajectoryRow {
  double time = 0;
  std::vector<double> positions;
};
using Trajectory = std::vector<TrajectoryRow>;

/// Reads a CSV with a header, time in the first column. Throws std::runtime_error.
inline Trajectory readTrajectory(const std::string& file, std::size_t variables) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) throw std::runtime_error(file + ": cannot be read");
  Trajectory rows;
  while (std::getline(stream, line)) {
    std::istringstream fields(line);
    TrajectoryRow row;
    std::string field;
    for (bool first = true; std::getline(fields, field, ','); first = false) {
      if (first)
        row.time = std::stod(field);
      else
        row.positions.push_back(std::stod(field));
    }
    if (row.positions.size() != variables)
      throw std::runtime_error(file + ": a row has another number of columns than the header says");
    rows.push_back(row);
  }
  if (rows.size() < 2) throw std::runtime_error(file + ": has fewer than two rows");
  return rows;
}

}  // namespace leeway::dense
