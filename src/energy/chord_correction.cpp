#include "chord_correction.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "chord_forms.hpp"
#include "element_kernels.hpp"

namespace voile::energy {

namespace {

constexpr int nodes = 6, chords = 12;

/// Points of a patch at the ends of its chords: sides, then across each side.
constexpr std::array<std::array<int, 2>, chords> ends{
    {{0, 1}, {1, 2}, {2, 0}, {1, 3}, {2, 3}, {0, 3}, {2, 4}, {0, 4}, {1, 4}, {0, 5}, {1, 5}, {2, 5}}};

/// Takes (f,y1y1 ; f,y2y2 ; 2 f,y1y2) to (f,11 ; f,22 ; 2 f,12), y = w x.
Mat3 turned_derivatives(const Mat2& w) {
  Mat3 m;
  const double a = w(0, 0), b = w(0, 1), c = w(1, 0), d = w(1, 1);
  m << a * a, c * c, a * c, b * b, d * d, b * d, 2 * a * b, 2 * c * d, a * d + b * c;
  return m;
}

/// The cubic with its second derivatives by y.
struct InOwnAxes {
  Mat3 from;  ///< second derivatives by y from those in the plane
  Mat3 to;

  explicit InOwnAxes(const Mat2& spread)
      : from(turned_derivatives(Mat2(spread.inverse()))), to(turned_derivatives(spread)) {}
  [[nodiscard]] BendWeights weights(BendWeights w) const {
    w.head<3>() = (from * w.head<3>()).eval();
    return w;
  }
  [[nodiscard]] Bends bends(Bends k) const {
    k.leftCols<3>() = (k.leftCols<3>() * from.transpose()).eval();
    return k;
  }
  [[nodiscard]] Mat3 form(const Mat3& f) const { return to.transpose() * f * to; }
};

/// sum_AB form_AB k_A.k_B
double square(const Mat3& form, const Bends& k) {
  const Mat3 of = k.leftCols<3>();
  return (of * form).cwiseProduct(of).sum();
}

/// Writes numbers one after the other.
class Writer {
 public:
  explicit Writer(std::vector<double>& to) : to_(&to) {}
  void add(double a) { to_->push_back(a); }
  void add_upper(const Mat3& form) {
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) add(form(a, b));
  }

 private:
  std::vector<double>* to_;
};

/// 1/2 sum_c W_rc (|k_c|^2 at the start - |k_c|^2 at rest) of one strain; `whole`: without what is at rest.
Vec3 start_strain(const mesh::Patch& patch, const PatchCubic& cubic, const ChordInput::Forms& quadratic, Vec3& whole) {
  Vec3 strain = Vec3::Zero();
  whole.setZero();
  for (const auto& [i, j] : ends) {
    if (patch.points[static_cast<std::size_t>(j)] == no_index) continue;
    const BendWeights along =
        cubic.along(patch.coordinates[static_cast<std::size_t>(i)], patch.coordinates[static_cast<std::size_t>(j)]);
    const double rest = along.dot(cubic.rest), start = (cubic.start * along).squaredNorm(),
                 half = 0.5 * (start - rest * rest);
    for (std::size_t r = 0; r < 3; ++r) {
      const double form = quadratic[r](i, j) / 12.0;
      strain[static_cast<int>(r)] -= form * half;
      whole[static_cast<int>(r)] -= form * 0.5 * start;
    }
  }
  return strain;
}

/// The stencil, with B'_i of each point.
std::vector<BendWeights> take_stencil(const ChordInput& in, const PatchCubic& cubic, ChordCorrection& c) {
  c.stencil.assign(in.six.begin(), in.six.end());
  std::vector<BendWeights> weights(nodes, BendWeights::Zero());
  for (std::size_t i = 0; i < cubic.points.size(); ++i) {
    const auto of_bending = std::find(in.bending.points.begin(), in.bending.points.end(), cubic.points[i]);
    const Index point = in.local[static_cast<std::size_t>(of_bending - in.bending.points.begin())];
    const auto at = static_cast<std::size_t>(std::find(c.stencil.begin(), c.stencil.end(), point) - c.stencil.begin());
    if (at == c.stencil.size()) {
      c.stencil.push_back(point);
      weights.push_back(BendWeights::Zero());
    }
    weights[at] += cubic.weights[i];
  }
  c.left_out = c.stencil.size() > ChordCorrection::most;
  if (c.left_out) {
    c.stencil.resize(nodes);
    weights.assign(nodes, BendWeights::Zero());
  }
  return weights;
}

}  // namespace

std::vector<BentChord> bent_chords(const Sheet& sheet, Index t, const BendingElement& bending,
                                   const ChordInput::Forms& quadratic) {
  std::vector<BentChord> chords;
  if (beside_crease(sheet, t)) return chords;
  const PatchCubic cubic = make_patch_cubic(sheet, t, bending);
  const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
  for (const auto& [i, j] : ends) {
    if (patch.points[static_cast<std::size_t>(j)] == no_index) continue;
    const BendWeights along =
        cubic.along(patch.coordinates[static_cast<std::size_t>(i)], patch.coordinates[static_cast<std::size_t>(j)]);
    BentChord chord{cubic.points, {}, cubic.start * along, Vec3::Zero()};
    for (const BendWeights& w : cubic.weights) chord.weights.push_back(along.dot(w));
    for (std::size_t r = 0; r < 3; ++r) chord.fraction[static_cast<int>(r)] = -quadratic[r](i, j) / 12.0;
    chords.push_back(std::move(chord));
  }
  return chords;
}

ChordCorrection make_chord_correction(const ChordInput& in) {
  const PatchCubic cubic = make_patch_cubic(in.sheet, in.triangle, in.bending);
  const mesh::Patch patch = in.sheet.patches().patch(in.triangle, in.sheet.frame(in.triangle));
  ChordCorrection c;
  const std::vector<BendWeights> weights = take_stencil(in, cubic, c);
  const bool corrected = !c.left_out && !beside_crease(in.sheet, in.triangle);
  c.start_strain.fill(Vec3::Zero());
  c.whole_strain.fill(Vec3::Zero());
  for (std::size_t k = 0; k < 2 && corrected; ++k)
    c.start_strain[k] = start_strain(patch, cubic, in.quadratic[k], c.whole_strain[k]);
  const InOwnAxes own(cubic.spread);
  Writer write(c.numbers);
  write.add(corrected ? -1.0 / 12.0 : 0.0);
  for (std::size_t i = 0; i < nodes; ++i) {
    const bool there = patch.points[i] != no_index;
    const Vec2 y = there ? Vec2(cubic.spread * (patch.coordinates[i] - cubic.centre)) : Vec2(Vec2::Zero());
    write.add(y[0]);
    write.add(y[1]);
  }
  const Bends start = own.bends(cubic.start);
  for (int b = 0; b < bend_vectors; ++b)
    for (int k = 0; k < 3; ++k) write.add(start(k, b));
  const Mat3 in_plane = corrected ? Mat3(patch.area * in.sheet.material(in.triangle).bending) : Mat3(Mat3::Zero());
  const Bends rest = Vec3::UnitZ() * cubic.rest.transpose();  // only its products matter
  write.add_upper(own.form(in_plane));
  write.add_upper(own.form(in.trace));
  c.start_squares = {square(in_plane, cubic.start), square(in.trace, cubic.start)};
  write.add(c.start_squares[0] - square(in_plane, rest));
  write.add(c.start_squares[1] - square(in.trace, rest));
  c.in_plane = in_plane;
  c.trace = in.trace;
  c.rest_bend = cubic.rest.head<3>();
  c.fourth = !in_plane.isZero(0.0) && !in.trace.isZero(0.0);
  for (const BendWeights& w : weights)
    for (const double number : own.weights(w)) write.add(number);
  return c;
}

}  // namespace voile::energy
