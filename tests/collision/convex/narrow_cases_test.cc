#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "tests/support/build_paths.h"
#include "tests/support/case_file.h"
#include "tools/truth/oracle/oracle.h"

// 6,000 pairs, ordinary and hard, with reference distances from quadruple precision; see the data's
// README.

namespace leeway::collision {
namespace {

struct Reference {
  int verdict = 0;
  double distance = 0, gap = 0;
  int has_value = 0;
  double largest = 0;
};

std::map<int, Reference> readReferences(const std::string& path) {
  std::map<int, Reference> references;
  std::ifstream lines(path);
  int id = 0;
  Reference r;
  while (lines >> id >> r.verdict >> r.distance >> r.gap >> r.has_value >> r.largest)
    references[id] = r;
  return references;
}

bool holds(const Interval& d, const Reference& r) {
  if (r.has_value == 0) return d.lower <= 0;
  return d.lower <= r.distance + r.gap && d.upper >= r.distance - r.gap;
}

TEST(NarrowCases, EveryIntervalHoldsTheReference) {
  const char* root = std::getenv("LEEWAY_DATA");
  const std::string folder =
      (root != nullptr ? std::string(root) : (leeway::sourceFolder() + "/../shared/data")) +
      "/narrow";
  const testing::CaseFile data = testing::readCases(folder + "/cases.txt");
  const std::map<int, Reference> references = readReferences(folder + "/reference.txt");
  if (data.cases.empty() || references.empty()) GTEST_SKIP() << "no data in " << folder;
  ASSERT_GE(data.cases.size(), 6000u);
  Scratch scratch;
  PairCache cache;
  int unsafe = 0, refuted = 0, undecided = 0, wide = 0, overlapping = 0;
  double widest = 0;
  for (const testing::FileCase& c : data.cases) {
    const Reference& reference = references.at(c.id);
    const Shape &a = data.shapes.at(c.a), &b = data.shapes.at(c.b);
    overlapping += reference.verdict < 0;
    for (const bool swapped : {false, true}) {
      const auto ask = [&](const DistanceRequest& request, PairCache* with) {
        return swapped ? distance(b, c.X_WB, a, c.X_WA, request, scratch, with)
                       : distance(a, c.X_WA, b, c.X_WB, request, scratch, with);
      };
      const auto check = [&](const DistanceResult& r, const char* how) {
        if (holds(r.distance, reference)) return;
        // A few references, with nearly duplicated vertices, are wrong in the twelfth digit.
        // References that the slow oracle refutes are counted, and the interval must contain the
        // oracle's answer.
        const oracle::Truth truth = oracle::signedSeparation(a, c.X_WA, b, c.X_WB);
        if (truth.has_value && std::abs(reference.distance - truth.upper) < 1e-11 &&
            r.distance.lower <= truth.upper && r.distance.upper >= truth.lower) {
          ++refuted;
          return;
        }
        ++unsafe;
        ADD_FAILURE() << "case " << c.id << " " << c.family << ", " << how
                      << (swapped ? ", swapped" : "") << ": reference "
                      << ::testing::PrintToString(reference.distance) << " not in ["
                      << ::testing::PrintToString(r.distance.lower) << ", "
                      << ::testing::PrintToString(r.distance.upper) << "]";
      };
      const DistanceResult r = ask({}, nullptr);
      check(r, "plain");
      check(ask({}, &cache), "cache of the pair before");
      DistanceRequest request;
      for (const int limit : {0, 1, 2, 5}) {
        request.iteration_limit = limit;
        check(ask(request, nullptr), "limited");
      }
      // Verdicts beyond the input's own rounding.
      const double rounding = 1e-13 * reference.largest;
      const bool apart = r.distance.lower > 0, in_contact = r.distance.upper <= 0;
      if (reference.verdict > 0 && reference.distance > rounding && !apart) ++undecided;
      if (reference.verdict < 0 && !(reference.has_value != 0 && reference.distance > -rounding) &&
          !in_contact) {
        ++undecided;
      }
      const double width = r.distance.width() / reference.largest;
      widest = std::max(widest, width);
      wide += !(width <= 1e-9);
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_EQ(wide, 0);
  EXPECT_EQ(undecided, 0);
  EXPECT_LE(refuted, 3 * 2 * 6);
  EXPECT_GT(overlapping, 1000);
  RecordProperty("widest", ::testing::PrintToString(widest));
}

}  // namespace
}  // namespace leeway::collision
