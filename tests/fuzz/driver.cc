// Runs a fuzz target without libFuzzer: TARGET [--seconds N] [--count N] [--seed S] [--only INDEX]
// [--corpus FOLDER]. Input i depends on seed, i and the corpus, whose files are seeds as well,
// alone:
// --only i reproduces it. --write FOLDER writes what libFuzzer begins with: seeds, and the words as
// FOLDER.dict.

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "tests/fuzz/target.h"
#include "tests/support/folder.h"
#include "tools/truth/oracle/generate.h"

namespace {

using leeway::oracle::Random;

// A longer input has an unbounded loop [s]; bounded ones take milliseconds even with sanitizers,
// oracle and a busy machine.
constexpr unsigned kLongestInput = 60;

char replay_line[200] = "";

void sayReplay(int signal) {
  const char* what = signal == SIGALRM ? "does not end: " : "stopped at: ";
  // Uses async-signal-safe calls only.
  if (write(STDERR_FILENO, what, std::strlen(what)) < 0 ||
      write(STDERR_FILENO, replay_line, std::strlen(replay_line)) < 0)
    _exit(1);
  _exit(1);
}

std::string randomBytes(Random& random) {
  std::string input(static_cast<std::size_t>(1 + random.below(random.chance(0.1) ? 1000 : 250)),
                    '\0');
  for (char& c : input) c = static_cast<char>(random.bits() & 0xff);
  return input;
}

/// One mutation of a text: bytes changed, pieces removed, duplicated or moved, words inserted, a
/// line removed.
void alter(std::string& text, const std::vector<std::string>& words, Random& random) {
  const auto place = [&] { return static_cast<std::size_t>(random.bits() % (text.size() + 1)); };
  const auto piece = [&](std::size_t at) {
    return std::min(text.size() - at,
                    static_cast<std::size_t>(1 + random.below(random.chance(0.2) ? 400 : 12)));
  };
  const std::size_t at = place();
  switch (random.below(8)) {
    case 0:
      if (at < text.size()) text[at] = static_cast<char>(random.bits() & 0xff);
      break;
    case 1:
      text.erase(at, piece(at));
      break;
    case 2:
      text.insert(place(), text.substr(at, piece(at)));
      break;
    case 3: {
      // Replaces a number.
      const std::size_t digit = text.find_first_of("0123456789", at);
      static const char* const kNumbers[] = {
          "nan", "inf", "-1", "0", "1e999", "1e-320", "99999999999999999999", "0x10", "1,5", ""};
      if (digit == std::string::npos) break;
      const std::size_t end = text.find_first_not_of("0123456789.eE+-", digit);
      text.replace(digit, end == std::string::npos ? std::string::npos : end - digit,
                   kNumbers[random.below(10)]);
      break;
    }
    case 4: {
      const std::size_t begin = text.rfind('\n', at), end = text.find('\n', at);
      if (begin == std::string::npos || end == std::string::npos) break;
      if (random.chance(0.5)) {
        text.erase(begin, end - begin);
      } else {
        text.insert(begin, text.substr(begin, end - begin));
      }
      break;
    }
    case 5:
      text.resize(at);
      break;
    default:
      if (words.empty()) break;
      {
        const std::string& word =
            words[static_cast<std::size_t>(random.below(static_cast<int>(words.size())))];
        if (random.chance(0.5)) {
          text.insert(at, word);
        } else {
          text.replace(at, std::min(word.size(), text.size() - at), word);
        }
      }
      break;
  }
}

struct Arguments {
  double seconds = 10;
  long long count = std::numeric_limits<long long>::max();
  unsigned long long seed = 1;
  long long only = -1;
  bool show = false;  // with --only: prints the input
  std::string corpus, write;
};

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    char* end = nullptr;
    if (name == "--seconds") {
      arguments.seconds = std::strtod(argv[i + 1], &end);
    } else if (name == "--count") {
      arguments.count = std::strtoll(argv[i + 1], &end, 10);
    } else if (name == "--seed") {
      arguments.seed = std::strtoull(argv[i + 1], &end, 10);
    } else if (name == "--only") {
      arguments.only = std::strtoll(argv[i + 1], &end, 10);
    } else if (name == "--write" || name == "--corpus") {
      (name == "--write" ? arguments.write : arguments.corpus) = argv[i + 1];
      continue;
    } else if (name == "--show") {
      arguments.show = std::strtoll(argv[i + 1], &end, 10) != 0;
    }
    if (end == nullptr || *end != '\0') return false;
  }
  return argc % 2 == 1;
}

/// All files of a folder, in the order of their names; none without a folder.
std::vector<std::string> readCorpus(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> texts;
  for (const std::filesystem::path& file : files) texts.push_back(leeway::readText(file));
  return texts;
}

/// A number for each input and a quoted word for each line, as libFuzzer reads them.
bool write(const std::string& folder, const std::vector<std::string>& seeds,
           const std::vector<std::string>& words) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    std::ofstream(folder + "/" + std::to_string(i), std::ios::binary) << seeds[i];
  std::ofstream dictionary(folder + ".dict");
  for (const std::string& word : words) {
    if (word.empty()) continue;
    dictionary << '"';
    for (const char c : word) {
      char hex[8];
      std::snprintf(hex, sizeof hex, "\\x%02x", static_cast<unsigned char>(c));
      dictionary << hex;
    }
    dictionary << "\"\n";
  }
  return static_cast<bool>(dictionary.flush());
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    std::fprintf(stderr,
                 "usage: %s [--seconds N] [--count N] [--seed S] [--only INDEX [--show 1]] "
                 "[--corpus FOLDER] [--write FOLDER]\n",
                 argv[0]);
    return 2;
  }
  for (const int signal : {SIGALRM, SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL})
    std::signal(signal, sayReplay);
  std::vector<std::string> seeds = leeway::fuzz::seedInputs();
  const std::vector<std::string> words = leeway::fuzz::dictionary();
  if (!arguments.write.empty()) return write(arguments.write, seeds, words) ? 0 : 1;
  for (std::string& input : readCorpus(arguments.corpus)) seeds.push_back(std::move(input));
  const bool single = arguments.only >= 0;
  const std::time_t begin = std::time(nullptr);
  long long done = 0;
  for (long long i = single ? arguments.only : 0; done < arguments.count; ++i, ++done) {
    if (single ? done == 1 : std::difftime(std::time(nullptr), begin) >= arguments.seconds) break;
    std::snprintf(replay_line, sizeof replay_line, "%s --seed %llu --only %lld%s%s\n", argv[0],
                  arguments.seed, i, arguments.corpus.empty() ? "" : " --corpus ",
                  arguments.corpus.c_str());
    Random random(Random(arguments.seed).bits() ^
                  (static_cast<std::uint64_t>(i) * 0xd1342543de82ef95ull));
    std::string input;
    if (seeds.empty()) {
      input = randomBytes(random);
    } else {
      input = seeds[static_cast<std::size_t>(random.below(static_cast<int>(seeds.size())))];
      // The first inputs are the unmodified seeds.
      if (i < static_cast<long long>(seeds.size())) {
        input = seeds[static_cast<std::size_t>(i)];
      } else {
        for (int n = 1 + random.below(6); n > 0; --n) alter(input, words, random);
      }
    }
    if (arguments.show) {
      std::fwrite(input.data(), 1, input.size(), stdout);
      std::fflush(stdout);
    }
    alarm(kLongestInput);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    alarm(0);
  }
  std::printf("%s: %lld inputs, seed %llu, nothing wrong\n", argv[0], done, arguments.seed);
  return 0;
}
