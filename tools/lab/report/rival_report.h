#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/lab/base/report_options.h"
#include "tools/lab/base/rivals.h"
#include "tools/lab/base/table.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {

/// Loads the rivals of a report, shows its progress, and writes its files and its answer.
class RivalReport {
 public:
  /// Starts the clock. Throws robots::InputError if the folder of `options` cannot be written or
  /// made: users learn this before minutes are spent on measuring. Makes nothing yet. `options`
  /// must outlive this.
  explicit RivalReport(const report::ReportOptions& options);

  /// Ours, followed by the rivals' of one kind (&report::Rivals::pairs, meshes, motions, ...)
  /// unless the options leave rivals out. The first call loads their modules, and names on stderr
  /// those that are missing. Valid while `own` and this report exist.
  template <class Engine>
  std::vector<const Engine*> engines(const std::vector<std::unique_ptr<Engine>>& own,
                                     std::vector<std::unique_ptr<Engine>> report::Rivals::*kind) {
    loadRivals();
    std::vector<const Engine*> all;
    all.reserve(own.size());
    for (const auto& engine : own) all.push_back(engine.get());
    for (const report::RivalModule& module : modules_) {
      if (!module.rivals) continue;
      for (const auto& engine : (*module.rivals).*kind) all.push_back(engine.get());
    }
    return all;
  }

  /// The rivals alone.
  template <class Engine>
  std::vector<const Engine*> rivals(std::vector<std::unique_ptr<Engine>> report::Rivals::*kind) {
    return engines(std::vector<std::unique_ptr<Engine>>{}, kind);
  }

  /// Pins the process to one processor, and shows the progress of `units` units of work.
  std::function<void(const std::string&)> begin(std::size_t units);
  /// For on_rows: keeps the rows so far in NAME.csv.partial, which is what an interrupted report
  /// leaves.
  template <class Row>
  std::function<void(const std::vector<Row>&)> keep(
      const std::string& name, report::Table (*table)(const std::vector<Row>&)) {
    return [this, name, table](const std::vector<Row>& added) { addRows(name, table(added)); };
  }
  /// Sets the conditions of the measurement, to which the machine's name is added: people read them
  /// first, and files and pictures contain them.
  void note(const std::string& text);

  /// Writes NAME.csv, in place of NAME.csv.partial, and NAME.json: an object with the note, the
  /// seed and the rows. Throws robots::InputError if that fails.
  void write(const std::string& name, const report::Table& table);
  /// Draws pictures of the tables so far, with matplotlib. Says so on stderr where Python or
  /// matplotlib is missing, and goes on.
  void draw(const std::vector<std::string>& pictures);

  /// How the report ends.
  struct End {
    std::vector<report::Table> tables = {};  ///< after the note
    std::string words = {};                  ///< at last, before the seed
    std::size_t count = 0;                   ///< of rows, or of what `counted` names
    std::string counted = "rows";
    int own_errors = 0;  ///< decides the exit status
  };
  /// Prints it, or a JSON document, to stdout, with the time and the files. Returns the exit
  /// status: kYes without errors of ours.
  int end(const End& end) const;

 private:
  void loadRivals();
  void addRows(const std::string& name, const report::Table& table);

  const report::ReportOptions& options_;
  std::optional<UnitProgress> progress_;
  int processor_ = -1;  // -1: any
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  bool is_loaded_ = false;
  std::vector<report::RivalModule> modules_;
  std::string note_;
  std::vector<std::string> missing_;  // libraries of rivals, and what draws
  std::vector<std::string> names_;    // of files
  std::set<std::string> partial_;     // of files that addRows() began
};

}  // namespace leeway::tools
