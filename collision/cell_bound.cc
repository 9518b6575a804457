#include "collision/cell_bound.h"

namespace leeway::collision {

// With e a unit vector, l_i = e . v_i and r_i across, |v_i| = l_i + r_i^2 / (|v_i| + l_i), and of
// two functions that are linear, (s_i l_j + s_j l_i) / 2 = (s_i l_i + s_j l_j) / 2 - (s_i - s_j)
// (l_i - l_j) / 2. So the bound's form has the margins at the corners, and the rest is small.
//
// What |v| exceeds l by, times the share s, is at least s r^2 / g with g = 2 l + R^2 / (2 min l), R
// the largest r; g is linear as s is. Over the cell s / g changes by its size: with the least of it
// the bound errs by the third power. With the ratio c where the form is least, and the linear n = s
// - c g, which is 0 there, it is c r^2 + n r^2 / g, and |n| r^2 / g is at most (t n^2 + R^2 r^2 /
// t) / (2 min g) for any t > 0: a quadratic form again. t is as large as the corners' margins let
// it be, which are of second order, too, where the least is a valley.
//
// Rounding, with u = kUnitRoundoff, L the sizes' sum, s the largest r / |v|: corners' v err by 20 u
// of their size, and so do r; r^2 / (|v| + l) by 40 u s, with the bends' products 68 u s of each of
// A, B and the depth, whose sizes' sum is less than 2 L; centres err by 8 u L, times the
// directions' difference 16 u s L. In all less than 160 u s L. What corners that differ add besides
// is 20 u of the shares' difference times M and 4 u of the centres'. `moved` stands beside u L in
// all of these.

namespace {

constexpr int kNext[3] = {1, 2, 0};
// How much of the corners' margins t n^2 may take, of A and B each.
constexpr double kShareOfMargin = 0.1;

void addSquares(const Vector (&v)[3], double factor, Form<double>& form) {
  form.p00 += factor * v[0].squaredNorm();
  form.p11 += factor * v[1].squaredNorm();
  form.p22 += factor * v[2].squaredNorm();
  form.p01 += factor * v[0].dot(v[1]);
  form.p02 += factor * v[0].dot(v[2]);
  form.p12 += factor * v[1].dot(v[2]);
}

// Where the form is least on a corner or an edge, the weights' sum 1, and what it is there.
double findLeast(const Form<double>& form, double (&mu)[3]) {
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

// |v| less the part along the middle; false where the direction is lost.
bool CellBound::split(const Vector (&v)[3], double size, Round& round, double (&beyond)[3]) {
  constexpr double kThird = 1.0 / 3;
  const Vector middle = kThird * (v[0] + v[1] + v[2]);
  const double length = middle.norm();
  if (!(length > size)) return false;
  const Vector e = middle / length;
  round.r_squared = 0;
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    const double along = e.dot(v[i]);
    round.along[i] = along;
    round.across[i] = v[i] - along * e;
    const double r_squared = round.across[i].squaredNorm(), squared = along * along + r_squared;
    const double whole = std::sqrt(squared);
    beyond[i] = along > 0 ? r_squared / (whole + along) : whole - along;
    round.r_squared = std::max(round.r_squared, r_squared);
    if (squared > 0) largest = std::max(largest, r_squared / squared);
  }
  angle_ = std::max(angle_, std::sqrt(largest));
  return true;
}

bool CellBound::addDepth(double depth) {
  Round round;
  double beyond[3];
  const Vector x[3] = {shorter_[0] * corners_[0].x, shorter_[1] * corners_[1].x,
                       shorter_[2] * corners_[2].x};
  if (!split(x, 0, round, beyond)) return false;
  for (int i = 0; i < 3; ++i) {
    const int j = kNext[i];
    const Vector centers = corners_[i].center - corners_[j].center;
    between_[i] -= 0.5 * (x[i] - x[j]).dot(centers);
    difference_ = std::max(difference_, centers.cwiseAbs().sum());
  }
  // |x| <= (1 / k + k) / 2 l + r^2 / (2 k min l), with k^2 = 1 + R^2 / (2 l^2).
  const double nearest = std::min({round.along[0], round.along[1], round.along[2]});
  if (!(nearest > 0)) return false;
  const double part = 0.5 * round.r_squared / (nearest * nearest), k = std::sqrt(1 + part);
  const double less_one = part / (1 + k), straight_less_one = 0.5 * less_one * less_one / k;
  for (int i = 0; i < 3; ++i) at_[i] -= depth * (straight_less_one * round.along[i] - beyond[i]);
  addSquares(round.across, -depth * (0.5 / (k * nearest)), form_);
  return true;
}

void CellBound::addRound(int k) {
  Round& round = round_[rounds_];
  double beyond[3];
  Vector v[3];
  for (int i = 0; i < 3; ++i) {
    round.share[i] = corners_[i].share[k];
    v[i] = shorter_[i] * corners_[i].scaled[k];
  }
  if (!(std::max({round.share[0], round.share[1], round.share[2]}) > 0)) return;
  if (!split(v, 1e-12 * sizes_[k], round, beyond)) {
    // (0 is a bound, too.)
    for (int i = 0; i < 3; ++i) at_[i] -= round.share[i] * v[i].norm();
    slack_ += 64 * (roundoff_ + moved_) * (sizes_[k] / (roundoff_ / kUnitRoundoff));
    return;
  }
  const double nearest = std::min({round.along[0], round.along[1], round.along[2]}),
               most = std::max({round.along[0], round.along[1], round.along[2]});
  // (About a cap's middle |M x| is anything.)
  const double constant = 2 * nearest > most ? 0 : most + std::sqrt(most * most + round.r_squared);
  for (int i = 0; i < 3; ++i) {
    const int j = kNext[i];
    const double difference = round.share[i] - round.share[j];
    at_[i] -= round.share[i] * beyond[i];
    between_[i] -= 0.5 * difference * (round.along[i] - round.along[j]);
    difference_ = std::max(difference_, std::abs(difference) * sizes_[k]);
    round.g[i] = constant > 0 ? constant : 2 * round.along[i] + 0.5 * round.r_squared / nearest;
  }
  ++rounds_;
}

Form<double> CellBound::leastForm() const {
  Form<double> form = form_;
  for (int m = 0; m < rounds_; ++m) {
    const Round& r = round_[m];
    const double bend = std::min({r.share[0] / r.g[0], r.share[1] / r.g[1], r.share[2] / r.g[2]});
    addSquares(r.across, bend, form);
  }
  return form;
}

Form<double> CellBound::middleForm() const {
  Form<double> form = form_;
  for (int m = 0; m < rounds_; ++m) {
    const Round& r = round_[m];
    addSquares(r.across, (r.share[0] + r.share[1] + r.share[2]) / (r.g[0] + r.g[1] + r.g[2]), form);
  }
  return form;
}

// With the bends at mu; false where there is no room for what they change by.
bool CellBound::bendAt(const double (&mu)[3], double most, Form<double>& form) const {
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
  // Directions of one length: r^2 / (2 l) is taken with one l for all.
  for (int i = 0; i < 3; ++i) {
    shorter_[i] = least_length / lengths[i];
    at_[i] = shorter_[i] * margins[i];
  }
  slack_ = 0.25 * roundoff_;
  if (!addDepth(depth)) return false;
  for (int k = 0; k < 2; ++k) addRound(k);
  slack_ +=
      (256 * angle_ + 32 * (difference_ / (roundoff_ / kUnitRoundoff))) * (roundoff_ + moved_);
  form_.p00 += at_[0] - slack_;
  form_.p11 += at_[1] - slack_;
  form_.p22 += at_[2] - slack_;
  form_.p01 += 0.5 * (at_[0] + at_[1]) + between_[0] - slack_;
  form_.p12 += 0.5 * (at_[1] + at_[2]) + between_[1] - slack_;
  form_.p02 += 0.5 * (at_[0] + at_[2]) + between_[2] - slack_;
  if (copositive(leastForm())) return true;
  if (rounds_ == 0) return false;
  const Form<double> middle = middleForm();
  double mu[3] = {1, 0, 0};
  below_ = findLeast(middle, mu) < 0;
  least_ = mu[0] * corners_[0].x + mu[1] * corners_[1].x + mu[2] * corners_[2].x;
  Form<double> form = form_;
  return bendAt(mu, std::max({middle.p00, middle.p11, middle.p22}), form) && copositive(form);
}

}  // namespace leeway::collision
