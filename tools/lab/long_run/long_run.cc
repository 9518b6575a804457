// Runs random and hard pairs of convex shapes through the distance engine, for any number of cases.
//
//   long_run [--cases N] [--seed N] [--family WORD] [--oracle-every N] [--state FILE]
//            [--block N] [--verbose]
//
// Each case is queried plainly, swapped, with a threshold, with another case's cache and a warm
// one, and sometimes with few iterations. Extended precision proves both ends of each answer from
// the normal and the witness points. Every answer of every N-th case is also compared with the
// quadruple-precision oracle (0: no case): proven, refuted, or left open if the oracle's own bounds
// are wider. Each block of cases has its own random numbers, so --block repeats one. --state FILE
// stores totals after every block; an interrupted run resumes from it. Exit status: 0; 1 if a check
// failed; 2 for bad usage.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tools/lab/bench/program.h"
#include "tools/lab/long_run/examine.h"

namespace {

using namespace leeway::accuracy;
using leeway::oracle::Random;

constexpr std::int64_t kBlock = 15000;  // cases; a thousand of each family

struct Options {
  std::int64_t cases = 1'000'000, seed = 1, oracle_every = 0, block = -1;
  int family = -1;
  std::string state;
  bool verbose = false;
};

using Table = std::array<Tally, kFamilyNames.size()>;

struct State {
  std::int64_t next_block = 0;
  Table table;
};

std::string heading(const Options& o) {
  std::ostringstream text;
  text << "seed " << o.seed << " family " << o.family << " oracle " << o.oracle_every;
  return text.str();
}

// False if the file belongs to another run.
bool readState(const Options& o, State& state) {
  std::ifstream file(o.state);
  std::string line;
  if (!file || !std::getline(file, line)) return true;
  if (line != heading(o)) return false;
  file >> state.next_block;
  for (Tally& t : state.table) {
    file >> t.cases >> t.answers >> t.overlapping >> t.unsafe >> t.failures >> t.open >> t.oracle >>
        t.unproven;
  }
  return static_cast<bool>(file);
}

bool writeState(const Options& o, const State& state) {
  const std::string fresh = o.state + ".new";
  {
    std::ofstream file(fresh);
    file << heading(o) << '\n' << state.next_block << '\n';
    for (const Tally& t : state.table) {
      file << t.cases << ' ' << t.answers << ' ' << t.overlapping << ' ' << t.unsafe << ' '
           << t.failures << ' ' << t.open << ' ' << t.oracle << ' ' << t.unproven << '\n';
    }
    if (!file.flush()) return false;
  }
  return std::rename(fresh.c_str(), o.state.c_str()) == 0;
}

void runBlock(const Options& o, std::int64_t block, std::int64_t count, Examiner& examiner,
              leeway::collision::Scratch& scratch, Table& table) {
  Random random(static_cast<std::uint64_t>(o.seed) * 1'000'003 + static_cast<std::uint64_t>(block));
  const Pool pool(random);
  for (std::int64_t i = 0; i < count; ++i) {
    const int f =
        o.family >= 0 ? o.family : static_cast<int>(i % static_cast<std::int64_t>(table.size()));
    const Case c = pool.draw(random, static_cast<Family>(f), scratch);
    const std::int64_t index = block * kBlock + i;
    const bool with_oracle = o.oracle_every > 0 && index % o.oracle_every == 0;
    const std::string says = std::string(kFamilyNames[static_cast<std::size_t>(f)]) + ", block " +
                             std::to_string(block) + ", case " + std::to_string(i);
    examiner.examine(c, random, with_oracle, says, table[static_cast<std::size_t>(f)]);
  }
}

void print(const Table& table, Tally& all) {
  std::printf("%-12s %12s %12s %11s %7s %8s %9s %9s %9s\n", "family", "cases", "answers",
              "overlapping", "unsafe", "failures", "open", "oracle", "unproven");
  const auto row = [](const char* name, const Tally& t) {
    std::printf("%-12s %12lld %12lld %11lld %7lld %8lld %9lld %9lld %9lld\n", name,
                static_cast<long long>(t.cases), static_cast<long long>(t.answers),
                static_cast<long long>(t.overlapping), static_cast<long long>(t.unsafe),
                static_cast<long long>(t.failures), static_cast<long long>(t.open),
                static_cast<long long>(t.oracle), static_cast<long long>(t.unproven));
  };
  for (std::size_t f = 0; f < table.size(); ++f) {
    all.add(table[f]);
    if (table[f].cases > 0) row(kFamilyNames[f], table[f]);
  }
  row("all", all);
}

int run(const Options& o) {
  State state;
  if (!o.state.empty() && !readState(o, state))
    throw std::runtime_error(o.state + ": of another run, or damaged; '" + heading(o) +
                             "' is expected");
  Examiner examiner;
  examiner.verbose = o.verbose;
  leeway::collision::Scratch scratch;
  if (o.block >= 0) {
    runBlock(o, o.block, kBlock, examiner, scratch, state.table);
  } else {
    for (std::int64_t begin = state.next_block * kBlock; begin < o.cases; begin += kBlock) {
      runBlock(o, state.next_block, std::min(kBlock, o.cases - begin), examiner, scratch,
               state.table);
      ++state.next_block;
      if (!o.state.empty() && !writeState(o, state))
        throw std::runtime_error(o.state + ": cannot be written");
    }
  }
  Tally all;
  print(state.table, all);
  return all.unsafe == 0 && all.failures == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Random and hard pairs of convex shapes through the distance engine.");
  Options o;
  std::map<std::string, int> families;
  for (const char* name : kFamilyNames) families.emplace(name, static_cast<int>(families.size()));
  app.add_option("--cases", o.cases, "to make")->check(CLI::NonNegativeNumber);
  app.add_option("--seed", o.seed, "of the cases")->check(CLI::NonNegativeNumber);
  app.add_option("--family", o.family, "only this one")
      ->transform(CLI::CheckedTransformer(families));
  app.add_option("--oracle-every", o.oracle_every,
                 "cases, one is compared with the oracle; 0: none")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--state", o.state, "file with the totals, from which a run goes on");
  app.add_option("--block", o.block, "repeat one")->check(CLI::NonNegativeNumber);
  app.add_flag("--verbose", o.verbose, "name each case");
  return leeway::bench::runProgram("long_run", app, argc, argv, [&] { return run(o); });
}
