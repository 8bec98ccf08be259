#include "membrane.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "curvature.hpp"

namespace voile::energy {

namespace {

/// Of a laminate whose stretching and bending are coupled, slopes of free sides follow the strain too: A - B (I - P) D^-1 B.
Mat3 released_stiffness(const Sheet& sheet, Index t) {
  const Material& m = sheet.material(t);
  if (!couples(m)) return m.membrane;
  const Mat3 free = Mat3::Identity() - free_side_projector(sheet, t);
  const Mat3 softer = m.coupling * free * Eigen::LLT<Mat3>(m.bending).solve(m.coupling);
  return m.membrane - 0.5 * (softer + softer.transpose());
}

/// Gradient of the linear interpolation on a triangle: row alpha, column corner.
std::array<std::array<double, 3>, 2> linear_gradient(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double twice = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  return {{{(b.y() - c.y()) / twice, (c.y() - a.y()) / twice, (a.y() - b.y()) / twice},
           {(c.x() - b.x()) / twice, (a.x() - c.x()) / twice, (b.x() - a.x()) / twice}}};
}

double area_of(const Vec2& a, const Vec2& b, const Vec2& c) {
  return 0.5 * std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
}

/// Half metric (a1.a1/2, a2.a2/2, a1.a2): Green strain before the rest metric is taken off.
Vec3 half_metric(const Vec3& a1, const Vec3& a2) {
  return {0.5 * a1.squaredNorm(), 0.5 * a2.squaredNorm(), a1.dot(a2)};
}

}  // namespace

MembraneTerm::MembraneTerm(const Sheet& sheet) {
  set_shape(sheet.options().membrane, sheet.options().cst_fraction);
  batches_ = Batches(corrects() ? membrane_fields::weights : membrane_fields::plain, corrects() ? bend_vectors : 0);
  for (const Material& m : sheet.materials()) {
    stiffness_.push_back(m.membrane);
    laws_.push_back(m.yarns);
    rubbers_.push_back(m.rubber);
    viscous_time_.push_back(m.viscous_time);
  }
  yarns_ = YarnLaws(sheet.materials(), shape_.factor[shape_.rubbing]);
  rubber_ = HyperelasticLaws(sheet.materials());
}

void MembraneTerm::set_shape(MembraneOperator kind, double cst_fraction) {
  MembraneShape s;
  s.corrected = kind == MembraneOperator::six_node_corrected;
  for (double& weight : s.weight) weight = 1.0;
  if (kind == MembraneOperator::cst) {
    s.first_sample = 3;
    s.groups = 1;
    s.group[3] = 0;
    s.factor[0] = 1.0;
  } else {
    for (int k = 0; k < 3; ++k) s.weight[k] = 1.0 / 3.0;
    s.factor[0] = 1.0 - cst_fraction;
    s.factor[1] = cst_fraction;
  }
  if (s.factor[0] == 0.0) s.rubbing = 1;
  shape_ = s;
}

std::array<Index, MembraneTerm::nodes> MembraneTerm::stencil_of(const Sheet& sheet, Index t) {
  std::array<Index, nodes> points{};
  for (int i = 0; i < 3; ++i) {
    points[i] = sheet.mesh().triangles()[t][i];
    const Index apex = sheet.patches().apex(t, i);
    points[3 + i] = apex == no_index ? sheet.mesh().triangles()[t][0] : apex;
  }
  return points;
}

namespace {

constexpr double same_membrane = 0.05;  ///< relative difference up to which strain is averaged across a side
/// Turn of the axes of one material up to which it is; on curved sheets they turn a little from each triangle to the next [rad].
constexpr double same_axes = 15.0 * std::numbers::pi / 180.0;

/// Angle from the axes of the triangle beyond side s to those of t, unfolded [rad].
double turn_across(const Sheet& sheet, Index t, int s, Index other) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const auto along = [&](Index of, int side) {
    const mesh::Frame frame = sheet.frame(of);
    const Vec3 e = mesh.rest_corner(of, (side + 2) % 3) - mesh.rest_corner(of, (side + 1) % 3);
    return std::atan2(e.dot(frame.e2), e.dot(frame.e1));
  };
  return along(t, s) - along(other, mesh.side_in_neighbour(t, s)) - std::numbers::pi;
}

/// Whether the membrane or its natural strain differs across side s of t, so that the strain jumps there: a mean of both sides is
/// the strain of neither. The published elements are as they were published.
bool strain_jumps(const Sheet& sheet, Index t, int s) {
  const ElementOptions& options = sheet.options();
  const Index other = sheet.mesh().neighbour(t, s);
  if (options.membrane == MembraneOperator::cst || options.bending == BendingOperator::six_node || other == no_index)
    return false;
  const Material &mine = sheet.material(t), &theirs = sheet.material(other);
  if (sheet.zone(t) != sheet.zone(other) && !(mine.expansion.isZero(0.0) && theirs.expansion.isZero(0.0))) return true;
  const bool same = sheet.material_index(t) == sheet.material_index(other);
  if (same && !mine.direction && !mine.texture_direction) return false;
  const double turn = turn_across(sheet, t, s, other);
  if (same && std::abs(std::remainder(turn, std::numbers::pi)) < same_axes) return false;
  const Mat3 seen = rotated_stiffness(theirs.membrane, turn);
  const auto differs = [&](const Vec3& a, const Vec3& b) {
    return (a - rotated_strain(b, turn)).norm() > same_membrane * std::max(a.norm(), b.norm());
  };
  const auto strain_of = [](const Material& m) -> Vec3 {
    return m.prestress.isZero(0.0) ? Vec3(Vec3::Zero()) : Vec3(m.membrane.ldlt().solve(m.prestress));
  };
  return (seen - mine.membrane).norm() > same_membrane * std::max(seen.norm(), mine.membrane.norm()) ||
         differs(mine.initial_strain, theirs.initial_strain) || differs(mine.expansion, theirs.expansion) ||
         differs(strain_of(mine), strain_of(theirs));
}

}  // namespace

MembraneTerm::Element MembraneTerm::element_of(const Sheet& sheet, Index t) {
  const mesh::Frame frame = sheet.frame(t);
  const mesh::Patch patch = sheet.patches().patch(t, frame);
  const auto& p = patch.coordinates;
  Element el{};
  el.area = patch.area;
  el.own = linear_gradient(p[0], p[1], p[2]);
  el.metric.fill(Vec3(0.5, 0.5, 0.0));
  for (int s = 0; s < 3; ++s) {
    SideWeights& d = el.side[s];
    for (int alpha = 0; alpha < 2; ++alpha) d[alpha] = {el.own[alpha][0], el.own[alpha][1], el.own[alpha][2], 0.0};
    if (patch.points[3 + s] == no_index || sheet.is_crease(t, s) || strain_jumps(sheet, t, s)) continue;
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    // The neighbour's gradient belongs to its own rest shape, the patch has this `stretch` times as long.
    const double stretch = patch.stretch[s];
    const auto far = linear_gradient(p[b], p[a], p[3 + s]);
    const double far_area = area_of(p[a], p[b], p[3 + s]) / (stretch * stretch),
                 fraction = patch.area / (patch.area + far_area);
    const auto mix = [&](double far_fraction) {
      SideWeights m = d;
      for (int alpha = 0; alpha < 2; ++alpha) {
        for (int k = 0; k < 3; ++k) m[alpha][k] *= fraction;
        m[alpha][b] += far_fraction * far[alpha][0];
        m[alpha][a] += far_fraction * far[alpha][1];
        m[alpha][3] = far_fraction * far[alpha][2];
      }
      return m;
    };
    const SideWeights at_rest = mix(1.0 - fraction);
    Vec3 a1 = Vec3::Zero(), a2 = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vec3 x = patch.rest[k < 3 ? k : 3 + s];
      a1 += at_rest[0][k] * x;
      a2 += at_rest[1][k] * x;
    }
    el.metric[s] = half_metric(a1, a2);
    d = mix((1.0 - fraction) * stretch);
  }
  return el;
}

std::array<Eigen::Matrix<double, MembraneTerm::nodes, MembraneTerm::nodes>, 3> MembraneTerm::forms(const Sheet& sheet,
                                                                                                   Index t,
                                                                                                   double own) {
  using Weights = Eigen::Matrix<double, 2, nodes>;
  const Element el = element_of(sheet, t);
  std::array<Eigen::Matrix<double, nodes, nodes>, 3> forms;
  forms.fill(Eigen::Matrix<double, nodes, nodes>::Zero());
  const auto add = [&](double fraction, const Weights& d) {
    forms[0] += fraction * d.row(0).transpose() * d.row(0);
    forms[1] += fraction * d.row(1).transpose() * d.row(1);
    forms[2] += fraction * (d.row(0).transpose() * d.row(1) + d.row(1).transpose() * d.row(0));
  };
  for (int s = 0; s < 3; ++s) {
    Weights d = Weights::Zero(), of_triangle = Weights::Zero();
    for (int alpha = 0; alpha < 2; ++alpha) {
      for (int k = 0; k < 3; ++k) {
        d(alpha, k) = el.side[s][alpha][k];
        of_triangle(alpha, k) = el.own[alpha][k];
      }
      d(alpha, 3 + s) = el.side[s][alpha][3];
    }
    add((1.0 - own) / 3.0, d);
    add(own / 3.0, of_triangle);
  }
  return forms;
}

void MembraneTerm::add(const Sheet& sheet, Index t, const std::array<Index, nodes>& local, bool owned) {
  last_ = element_of(sheet, t);
  last_points_ = local;
  last_owned_ = owned;
  last_correction_.fill(Vec3::Zero());
  last_chords_ = {};
  material_.push_back(sheet.material_index(t));
  last_stiffness_ = released_stiffness(sheet, t);
  if (!corrects()) place({}, {local.begin(), local.end()}, false);
}

void MembraneTerm::correct(const Sheet& sheet, const Mat3& trace, Index t, const BendingElement& bending,
                           const std::vector<Index>& local) {
  last_chords_ = make_chord_correction(
      {sheet, t, bending, local, last_points_, {forms(sheet, t, 0.0), forms(sheet, t, 1.0)}, trace});
  const ChordCorrection& c = last_chords_;
  for (std::size_t k = 0; k < 2; ++k) last_correction_[k] = -c.start_strain[k];
  if (c.left_out && last_owned_) ++left_out_;
  place(c.numbers, c.stencil, c.fourth);
}

/// Puts the element added last into a batch; `numbers`: those of its correction.
void MembraneTerm::place(std::vector<double> numbers, const std::vector<Index>& stencil, bool fourth) {
  std::vector<double> all(membrane_fields::plain, 0.0);
  for (int alpha = 0; alpha < 2; ++alpha) {
    for (int s = 0; s < 3; ++s)
      for (int k = 0; k < 4; ++k) all[membrane_fields::side + 8 * s + 4 * alpha + k] = last_.side[s][alpha][k];
    for (int k = 0; k < 3; ++k) all[membrane_fields::own + 3 * alpha + k] = last_.own[alpha][k];
  }
  const Mat3 factor = Eigen::LLT<Mat3>(last_.area * last_stiffness_).matrixL();
  for (int b = 0, k = membrane_fields::stiffness; b < 3; ++b)
    for (int a = b; a < 3; ++a) all[k++] = factor(a, b);
  all.insert(all.end(), numbers.begin(), numbers.end());
  const Batches::Place place = batches_.add({stencil, all, last_owned_, fourth});
  if (yarns_.any()) yarns_.add(place, last_.area, laws_[static_cast<std::size_t>(material_.back())]);
  if (rubber_.any()) rubber_.add(place, last_.area, rubbers_[static_cast<std::size_t>(material_.back())]);
  Metrics off = metrics_of(last_.metric);
  for (std::size_t g = 0; g < off.size(); ++g) off[g] += last_correction_[g];
  set_metrics(size() - 1, off);
}

/// Rest metrics of the groups from those of the samples.
MembraneTerm::Metrics MembraneTerm::metrics_of(const std::array<Vec3, 4>& samples) const {
  Metrics m;
  m.fill(Vec3::Zero());
  for (int k = shape_.first_sample; k < shape_.last_sample; ++k) m[shape_.group[k]] += shape_.weight[k] * samples[k];
  return m;
}

void MembraneTerm::set_metrics(Index e, const Metrics& metrics) {
  for (int g = 0; g < 3; ++g)
    for (int r = 0; r < 3; ++r) batches_.set_number(e, membrane_fields::metric + 3 * g + r, metrics[g][r]);
}

MembraneTerm::Metrics MembraneTerm::taken_off(Index e) const {
  Metrics m;
  for (int g = 0; g < 3; ++g)
    for (int r = 0; r < 3; ++r) m[g][r] = batches_.number(e, membrane_fields::metric + 3 * g + r);
  return m;
}

bool MembraneTerm::depends_on(Index e, int i) const {
  const auto any = [&](int first, int count) {
    for (int k = 0; k < count; ++k)
      if (batches_.number(e, first + k) != 0.0) return true;
    return false;
  };
  if (i < 3) return true;
  if (corrects() && any(membrane_fields::weights + bend_vectors * i, bend_vectors)) return true;
  if (i >= nodes) return false;
  const int apex = membrane_fields::side + 8 * (i - 3) + 3;
  return any(apex, 1) || any(apex + 4, 1);
}

void MembraneTerm::add_gather(const Sheet& sheet, const mesh::PatchMesh& before, Index t) {
  const auto bases = [&](const mesh::PatchMesh& of) {
    const mesh::Patch patch = of.patch(t, of.frame(t));
    std::array<std::array<Vec3, 2>, 4> all;
    for (std::size_t s = 0; s < 4; ++s)
      for (std::size_t alpha = 0; alpha < 2; ++alpha) {
        Vec3& a = all[s][alpha] = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k)
          a += (s < 3 ? last_.side[s][alpha][k] : last_.own[alpha][k]) * patch.rest[k];
        if (s < 3) a += last_.side[s][alpha][3] * patch.rest[3 + s];
      }
    return all;
  };
  const Gathered g{size() - 1, bases(before), bases(sheet.patches()), last_correction_};
  constexpr double same = 1e-9;
  double change = 0.0;
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < 2; ++i) change = std::max(change, (g.before[k][i] - g.drawn_in[k][i]).norm());
  if (change > same) gathered_.push_back(g);
}

void MembraneTerm::gather(double fraction) {
  ++version_;
  for (const Gathered& g : gathered_) {
    std::array<Vec3, 4> samples;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto base = [&](std::size_t i) {
        return Vec3((1.0 - fraction) * g.before[k][i] + fraction * g.drawn_in[k][i]);
      };
      samples[k] = half_metric(base(0), base(1));
    }
    Metrics now = metrics_of(samples);
    for (std::size_t k = 0; k < now.size(); ++k) now[k] += g.correction[k];
    Natural* natural = natural_of(g.element);
    if (natural) natural->rest = now;
    shift_metrics(g.element, natural ? natural_metrics(*natural) : now);
  }
}

void MembraneTerm::shift_metrics(Index e, const Metrics& metrics) {
  if (!viscosity_.empty()) {
    const Metrics off = taken_off(e);
    const Batches::Place p = batches_.place(e);
    for (int k = 0; k < 9; ++k) start_[9 * p.batch + k].of[p.lane] += off[k / 3][k % 3] - metrics[k / 3][k % 3];
  }
  set_metrics(e, metrics);
}

void MembraneTerm::add_natural() {
  const ChordCorrection& c = last_chords_;
  Natural n{size() - 1, {}, taken_off(size() - 1), {}, c.in_plane, c.trace, c.rest_bend, c.start_squares, c.fourth};
  n.whole.fill(Vec3::Zero());
  if (corrects())
    for (std::size_t g = 0; g < 2; ++g) n.whole[g] = c.whole_strain[g];
  natural_.push_back(n);
}

MembraneTerm::Natural* MembraneTerm::natural_of(Index e) {
  const auto at = std::lower_bound(natural_.begin(), natural_.end(), e,
                                   [](const Natural& n, Index element) { return n.element < element; });
  return at == natural_.end() || at->element != e ? nullptr : &*at;
}

/// With P the spurious part of chords of the start, rest + P is the metric of the surface itself, which the natural stretch changes.
MembraneTerm::Metrics MembraneTerm::natural_metrics(const Natural& n) const {
  Metrics off;
  off.fill(Vec3::Zero());
  for (int g = 0; g < shape_.groups; ++g) off[g] = n.state.metric(n.rest[g] + n.whole[g]) - n.whole[g];
  return off;
}

Vec3 MembraneTerm::natural_metric(Index e) const {
  const Metrics off = taken_off(e);
  Vec3 sum = Vec3::Zero();
  for (int g = 0; g < shape_.groups; ++g) sum += shape_.factor[g] * off[g];
  return sum;
}

void MembraneTerm::set_natural(Index e, const NaturalState& state) {
  ++version_;
  Natural& n = *natural_of(e);
  n.state = state;
  shift_metrics(e, natural_metrics(n));
  if (!n.fourth) return;
  const Vec3 bent = state.bent(n.rest_bend);
  const auto square = [&](const Mat3& form) {
    return state.first_order ? n.rest_bend.dot(form * (2.0 * bent - n.rest_bend)) : bent.dot(form * bent);
  };
  batches_.set_number(e, membrane_fields::start_invariants, n.start_squares[0] - square(n.in_plane));
  batches_.set_number(e, membrane_fields::start_invariants + 1, n.start_squares[1] - square(n.trace));
}

}  // namespace voile::energy
