#include "collision/convex/round_depth/cell_bound.h"

#include "collision/base/tolerances.h"

namespace leeway::collision {

// clang-format off
// The bound on a cell as a quadratic form.
//
// With e a unit vector, l_i = e . v_i and r_i the part of v_i across e:
//
//   |v_i| = l_i + r_i^2 / (|v_i| + l_i),
//
// and of two functions that are linear,
//
//   (s_i l_j + s_j l_i) / 2 = (s_i l_i + s_j l_j) / 2 - (s_i - s_j) (l_i - l_j) / 2.
//
// So the form consists of the margins at the corners, and the rest is small.
//
// The excess of |v| over l, times the share s, is at least s r^2 / g with g = 2 l + R^2 / (2 min l), R the largest r;
// g is linear as s is. The least s / g would err by the third power, because s / g changes by the cell's size. With
// the ratio c where the form is least, and the linear n = s - c g, which is 0 there:
//
//   s r^2 / g = c r^2 + n r^2 / g,   |n| r^2 / g <= (t n^2 + R^2 r^2 / t) / (2 min g) for any t > 0,
//
// a quadratic form again. t is as large as the corners' margins allow. These are of second order, too, where the least
// is a valley.
//
// Rounding, with u = kUnitRoundoff, L the sum of the sizes, s the largest r / |v|:
//   corners' v, and so r                                       20 u of their size
//   r^2 / (|v| + l)                                            40 u s
//   with the products of the bends, each of A, B and depth,
//     whose sizes' sum is less than 2 L                        68 u s
//   centres err by 8 u L; times the directions' difference     16 u s L
// In all less than 160 u s L. Corners that differ add 20 u of the shares' difference times M, and 4 u of the centres'.
// clang-format on

namespace {

constexpr int kNext[3] = {1, 2, 0};
// The share of the corners' margins that t n^2 of A and of B may take each.
constexpr double kShareOfMargin = 0.1;

void addSquares(const Vector (&v)[3], double factor, Form& form) {
  form.p00 += factor * v[0].squaredNorm();
  form.p11 += factor * v[1].squaredNorm();
  form.p22 += factor * v[2].squaredNorm();
  form.p01 += factor * v[0].dot(v[1]);
  form.p02 += factor * v[0].dot(v[2]);
  form.p12 += factor * v[1].dot(v[2]);
}

// The least value of the form on corners and edges, and its weights, whose sum is 1.
double findLeast(const Form& form, double (&mu)[3]) {
  const double corner[3] = {form.p00, form.p11, form.p22};
  const double between[3] = {form.p01, form.p12, form.p02};
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int j = kNext[i];
    const double from = corner[i] - between[i], to = corner[j] - between[i];
    const double t = from > 0 ? (to > 0 ? from / (from + to) : 1) : 0;
    const double value =
        corner[i] * (1 - t) * (1 - t) + corner[j] * t * t + 2 * between[i] * t * (1 - t);
    if (!(value < least)) continue;
    least = value;
    mu[i] = 1 - t, mu[j] = t, mu[kNext[j]] = 0;
  }
  return least;
}

double at(const double (&values)[3], const double (&mu)[3]) {
  return mu[0] * values[0] + mu[1] * values[1] + mu[2] * values[2];
}

}  // namespace

// Splits v into parts along the middle and across, and `beyond` = |v| - along. False if the
// direction is lost: v may be off by `doubt`.
bool CellBound::split(const Vector (&v)[3], double doubt, Round& round, double (&beyond)[3]) {
  constexpr double kThird = 1.0 / 3;
  const Vector middle = kThird * (v[0] + v[1] + v[2]);
  const double length = middle.norm();
  if (!(length > kLostBelow * doubt)) return false;
  const Vector e = middle / length;
  round.r_squared = 0;
  double largest = 0, shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double along = e.dot(v[i]);
    round.along[i] = along;
    round.across[i] = v[i] - along * e;
    const double r_squared = round.across[i].squaredNorm(), squared = along * along + r_squared;
    const double whole = std::sqrt(squared);
    beyond[i] = along > 0 ? r_squared / (whole + along) : whole - along;
    round.r_squared = std::max(round.r_squared, r_squared);
    if (squared > 0) largest = std::max(largest, r_squared / squared);
    shortest = std::min(shortest, squared);
    // (Opposite to e, |v| and e . v err in opposite directions, however small the sine of the
    // angle.)
    if (!(along > 0)) slack_ += 2 * doubt;
  }
  angle_ = std::max(angle_, std::sqrt(largest));
  // (The angle of short vectors is itself uncertain.)
  slack_ += 4 * doubt * (shortest > doubt * doubt ? doubt / std::sqrt(shortest) : 1);
  return true;
}

bool CellBound::addDepth(double depth) {
  Round round;
  double beyond[3];
  const Vector x[3] = {shorter_[0] * corners_[0].x, shorter_[1] * corners_[1].x,
                       shorter_[2] * corners_[2].x};
  for (int i = 0; i < 3; ++i) {
    const int j = kNext[i];
    const Vector centers = corners_[i].center - corners_[j].center;
    between_[i] -= 0.5 * (x[i] - x[j]).dot(centers);
    difference_ = std::max(difference_, centers.cwiseAbs().sum());
  }
  if (!(depth > 0)) {
    addRound(x, {-depth, -depth, -depth}, 1, 0);
    return true;
  }
  if (!split(x, 0, round, beyond)) return false;
  // |x| <= (1 / k + k) / 2 l + r^2 / (2 k min l), with k^2 = 1 + R^2 / (2 l^2).
  const double nearest = std::min({round.along[0], round.along[1], round.along[2]});
  if (!(nearest > 0)) return false;
  const double part = 0.5 * round.r_squared / (nearest * nearest), k = std::sqrt(1 + part);
  const double less_one = part / (1 + k), straight_less_one = 0.5 * less_one * less_one / k;
  for (int i = 0; i < 3; ++i) at_[i] -= depth * (straight_less_one * round.along[i] - beyond[i]);
  addSquares(round.across, -depth * (0.5 / (k * nearest)), form_);
  return true;
}

// The excess of |M x| over r |x| is x' (M^2 - r^2) x / (|M x| + r |x|). The denominator is at most
// the sum of r and the longest axis times the largest |x|: a quadratic form.
void CellBound::addBall(int k) {
  const NearlyBall& ball = balls_[k];
  double longest = 0;
  Vector w[3];
  for (int i = 0; i < 3; ++i) {
    const Vector v = shorter_[i] * corners_[i].scaled[k];
    const double length = shorter_[i] * corners_[i].x.norm();
    w[i] = ball.spread.cwiseProduct(v);
    at_[i] -= w[i].squaredNorm() / (v.norm() + ball.radius * length);
    longest = std::max(longest, length);
  }
  addSquares(w, 1 / (ball.sum * longest * kGrowthOutwards), form_);
}

void CellBound::addRound(int k) {
  Vector v[3];
  double share[3];
  for (int i = 0; i < 3; ++i) {
    share[i] = corners_[i].share[k];
    v[i] = shorter_[i] * corners_[i].scaled[k];
  }
  if (!(std::max({share[0], share[1], share[2]}) > 0)) return;
  addRound(v, share, sizes_[k], sizes_[k] * kCornerRounding * kUnitRoundoff);
}

void CellBound::addRound(const Vector (&v)[3], const double (&share)[3], double size,
                         double doubt) {
  Round& round = round_[rounds_];
  double beyond[3];
  for (int i = 0; i < 3; ++i) round.share[i] = share[i];
  if (!split(v, doubt, round, beyond)) {
    // (|v| >= 0 is also a bound.)
    for (int i = 0; i < 3; ++i) at_[i] -= round.share[i] * v[i].norm();
    slack_ += doubt;
    return;
  }
  const double nearest = std::min({round.along[0], round.along[1], round.along[2]}),
               most = std::max({round.along[0], round.along[1], round.along[2]});
  // (Around a cap's middle, |M x| is far from linear.)
  const double constant = 2 * nearest > most ? 0 : most + std::sqrt(most * most + round.r_squared);
  for (int i = 0; i < 3; ++i) {
    const int j = kNext[i];
    const double difference = round.share[i] - round.share[j];
    at_[i] -= round.share[i] * beyond[i];
    between_[i] -= 0.5 * difference * (round.along[i] - round.along[j]);
    difference_ = std::max(difference_, std::abs(difference) * size);
    round.g[i] = constant > 0 ? constant : 2 * round.along[i] + 0.5 * round.r_squared / nearest;
  }
  ++rounds_;
}

Form CellBound::leastForm() const {
  Form form = form_;
  for (int m = 0; m < rounds_; ++m) {
    const Round& r = round_[m];
    const double bend = std::min({r.share[0] / r.g[0], r.share[1] / r.g[1], r.share[2] / r.g[2]});
    addSquares(r.across, bend, form);
  }
  return form;
}

Form CellBound::middleForm() const {
  Form form = form_;
  for (int m = 0; m < rounds_; ++m) {
    const Round& r = round_[m];
    addSquares(r.across, (r.share[0] + r.share[1] + r.share[2]) / (r.g[0] + r.g[1] + r.g[2]), form);
  }
  return form;
}

// Adds the bends at mu, minus their change; false if the margins leave no room for that.
bool CellBound::bendAt(const double (&mu)[3], double most, Form& form) const {
  if (!(most > 0)) return false;
  for (int m = 0; m < rounds_; ++m) {
    const Round& r = round_[m];
    const double bend = at(r.share, mu) / at(r.g, mu);
    const double least_g = std::min({r.g[0], r.g[1], r.g[2]});
    const double n[3] = {r.share[0] - bend * r.g[0], r.share[1] - bend * r.g[1],
                         r.share[2] - bend * r.g[2]};
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    // t / (2 min g), and R^2 / (2 t min g).
    double of_squares = 0, of_bend = 0;
    if (largest > 0) {
      of_squares = kShareOfMargin * most / (largest * largest);
      of_bend = r.r_squared / (4 * of_squares * least_g * least_g);
      form.p00 -= of_squares * (n[0] * n[0]);
      form.p11 -= of_squares * (n[1] * n[1]);
      form.p22 -= of_squares * (n[2] * n[2]);
      form.p01 -= of_squares * (n[0] * n[1]);
      form.p02 -= of_squares * (n[0] * n[2]);
      form.p12 -= of_squares * (n[1] * n[2]);
    }
    addSquares(r.across, bend - of_bend, form);
  }
  return true;
}

bool CellBound::proves(const double (&margins)[3], double depth) {
  double lengths[3];
  for (int i = 0; i < 3; ++i) lengths[i] = corners_[i].x.norm();
  const double least_length = std::min({lengths[0], lengths[1], lengths[2]});
  if (!(least_length > 0)) return false;
  // Uses directions of equal length, because r^2 / (2 l) has one l for all.
  for (int i = 0; i < 3; ++i) {
    shorter_[i] = least_length / lengths[i];
    at_[i] = shorter_[i] * margins[i];
  }
  slack_ = 0.25 * roundoff_;
  double rest = depth;
  for (int k = 0; k < 2; ++k) {
    if (isBall(k)) rest -= balls_[k].radius;
  }
  if (!addDepth(rest)) return false;
  for (int k = 0; k < 2; ++k) isBall(k) ? addBall(k) : addRound(k);
  slack_ += 256 * angle_ * roundoff_ + 32 * kUnitRoundoff * difference_;
  form_.p00 += at_[0] - slack_;
  form_.p11 += at_[1] - slack_;
  form_.p22 += at_[2] - slack_;
  form_.p01 += 0.5 * (at_[0] + at_[1]) + between_[0] - slack_;
  form_.p12 += 0.5 * (at_[1] + at_[2]) + between_[1] - slack_;
  form_.p02 += 0.5 * (at_[0] + at_[2]) + between_[2] - slack_;
  if (copositive(leastForm())) return true;
  if (rounds_ == 0) return false;
  const Form middle = middleForm();
  double mu[3] = {1, 0, 0};
  below_ = findLeast(middle, mu) < 0;
  least_ = mu[0] * corners_[0].x + mu[1] * corners_[1].x + mu[2] * corners_[2].x;
  Form form = form_;
  return bendAt(mu, std::max({middle.p00, middle.p11, middle.p22}), form) && copositive(form);
}

}  // namespace leeway::collision
