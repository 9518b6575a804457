#include "collision/convex/round_depth/face_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/tolerances.h"

namespace leeway::collision {

double innerProduct(const double (&v)[kOffsets], const double (&w)[kOffsets]) {
  double sum = 0;
  for (int i = 0; i < kOffsets; ++i) sum += v[i] * w[i];
  return sum;
}

void meanOf(const FaceMember* members, int count, double (&mean)[kOffsets]) {
  for (double& m : mean) m = 0;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kOffsets; ++k) mean[k] += members[i].weight * members[i].offset[k];
  }
}

namespace {

// The change of the weights to the best mean. False if the gain is unbounded along the change.
bool bestChange(const FaceMember* members, int count, double (&change)[kMostMembers]) {
  double way[kMostMembers][kOffsets], a[kMostMembers][kMostMembers], mean[kOffsets];
  double whole[kMostMembers] = {}, right[kMostMembers] = {};
  int order[kMostMembers] = {};
  meanOf(members, count, mean);
  for (int i = 1; i < count; ++i) {
    for (int k = 0; k < kOffsets; ++k) way[i][k] = members[i].offset[k] - members[0].offset[k];
    order[i] = i;
    right[i] = members[i].gain - members[0].gain - innerProduct(way[i], mean);
    for (int j = 1; j <= i; ++j) a[i][j] = a[j][i] = innerProduct(way[i], way[j]);
    whole[i] = a[i][i];
  }
  // Cholesky's decomposition, pivoting for the largest remaining share of a square.
  int rank = 1;
  for (; rank < count; ++rank) {
    int best = rank;
    for (int i = rank + 1; i < count; ++i) {
      if (a[i][i] * whole[best] > a[best][best] * whole[i]) best = i;
    }
    if (!(a[best][best] > kSingularFace * whole[best])) break;
    std::swap(order[rank], order[best]);
    std::swap(whole[rank], whole[best]);
    std::swap(right[rank], right[best]);
    for (int i = 1; i < count; ++i) std::swap(a[rank][i], a[best][i]);
    for (int i = 1; i < count; ++i) std::swap(a[i][rank], a[i][best]);
    for (int i = rank + 1; i < count; ++i) {
      const double times = a[i][rank] / a[rank][rank];
      for (int j = rank + 1; j < count; ++j) a[i][j] -= times * a[rank][j];
      right[i] -= times * right[rank];
    }
  }
  const bool ends = rank == count;
  double c[kMostMembers] = {};
  if (!ends) c[rank] = 1;
  for (int i = rank - 1; i > 0; --i) {
    double sum = ends ? right[i] : -a[i][rank];
    for (int j = i + 1; j < rank; ++j) sum -= a[i][j] * c[j];
    c[i] = sum / a[i][i];
  }
  // (The remaining right side is the gain along the change.)
  const double sign = !ends && right[rank] < 0 ? -1 : 1;
  change[0] = 0;
  for (int i = 1; i < count; ++i) {
    change[order[i]] = sign * c[i];
    change[0] -= sign * c[i];
  }
  return ends;
}

// Moves the weights to the best ones, or to where one of them vanishes; in the latter case drops
// that member and returns true.
bool moveWeights(FaceMember* members, int& count) {
  double change[kMostMembers];
  const bool ends = bestChange(members, count, change);
  double step = ends ? 1 : std::numeric_limits<double>::infinity();
  int gone = -1;
  for (int i = 0; i < count; ++i) {
    if (!(change[i] < 0 && -members[i].weight > step * change[i])) continue;
    step = members[i].weight / -change[i];
    gone = i;
  }
  if (!std::isfinite(step)) return false;
  for (int i = 0; i < count; ++i) {
    members[i].weight = std::max(members[i].weight + step * change[i], 0.0);
  }
  if (gone < 0) return false;
  members[gone] = members[--count];
  return true;
}

}  // namespace

void weigh(FaceMember* members, int& count) {
  while (count > 1 && moveWeights(members, count)) {
  }
}

}  // namespace leeway::collision
