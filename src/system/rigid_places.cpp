#include "rigid_places.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/mpi.hpp"

namespace voile::system {

namespace {

/// Places of the parts among the numbers of a body.
constexpr std::size_t first_displacement = 0, first_turn = 3, first_time = 7, has_time = 8, displacement = 9,
                      velocity = 16, spin = 19;

/// Of three points that carry a body.
constexpr std::size_t unknowns_of_body = 9;

template <class Vector>
Vector part(const std::vector<double>& places, std::size_t body, std::size_t at) {
  return Eigen::Map<const Vector>(&places[rigid_place_numbers * body + at]);
}

std::size_t count(const std::vector<double>& places) {
  return places.size() / rigid_place_numbers;
}

}  // namespace

std::array<Vec, 5> rigid_vectors(const State& s) {
  return {s.u, s.v, s.a, s.last.u ? s.last.u : s.previous, s.last.v};
}

std::vector<double> rigid_unknowns(const Dofs& dofs, const State& s) {
  std::vector<double> all;
  for (Vec v : rigid_vectors(s)) {
    const std::vector<double> own = v ? dofs.gather_bodies(v) : std::vector<double>(dofs.body_unknowns(), 0.0);
    all.insert(all.end(), own.begin(), own.end());
  }
  return mpi::rank(dofs.comm()) == 0 ? all : std::vector<double>{};
}

std::vector<double> rigid_record(const Discretisation& on, const State& s) {
  if (on.dofs().motions().empty()) return {};
  std::vector<double> record = rigid_unknowns(on.dofs(), s);
  const std::vector<double> places = rigid_places(on, s.u, s.v);
  record.insert(record.end(), places.begin(), places.end());
  return record;
}

void take_rigid_record(const std::vector<double>& record, std::vector<double>& unknowns, std::vector<double>& places) {
  constexpr std::size_t of_body = 5 * unknowns_of_body;
  const std::size_t count = record.size() / (of_body + rigid_place_numbers);
  const bool good = std::all_of(record.begin(), record.end(), [](double x) { return std::abs(x) < 1e12; });
  if (!good || record.size() != count * (of_body + rigid_place_numbers)) return;
  const auto cut = record.begin() + static_cast<std::ptrdiff_t>(count * of_body);
  unknowns.assign(record.begin(), cut);
  places.assign(cut, record.end());
}

std::vector<double> rigid_places(const Discretisation& on, Vec u, Vec v) {
  const std::vector<double> unknowns = on.dofs().gather_bodies(u);
  const std::vector<double> rates = v ? on.dofs().gather_bodies(v) : std::vector<double>(unknowns.size(), 0.0);
  const std::vector<RigidBody>& bodies = on.constraints().bodies;
  constexpr std::size_t each = unknowns_of_body;
  std::vector<double> all;
  const auto add = [&](const auto& part) { all.insert(all.end(), part.data(), part.data() + part.size()); };
  for (std::size_t b = 0; each * b < unknowns.size(); ++b) {
    const auto three = [&](const std::vector<double>& of, std::size_t k) {
      return Vec3(Eigen::Map<const Vec3>(&of[each * b + 3 * k]));
    };
    RigidMotion motion(bodies[b]);
    motion.set(three(unknowns, 0), three(unknowns, 1), three(unknowns, 2));
    Eigen::Vector4d turning;
    turning << three(rates, 1), three(rates, 2).x();
    add(bodies[b].place.displacement);
    add(bodies[b].place.turn);
    const std::optional<double>& time = bodies[b].place.time;
    all.insert(all.end(), {time.value_or(0.0), time ? 1.0 : 0.0});
    add(motion.displacement());
    add(motion.quaternion());
    add(three(rates, 0));
    add(Vec3(motion.spin() * turning));
  }
  return all;
}

void begin_stage_at(double time, std::vector<double>& places) {
  for (std::size_t b = 0; b < count(places); ++b) {
    double* body = &places[rigid_place_numbers * b];
    std::copy(body + displacement, body + velocity, body + first_displacement);
    body[first_time] = time;
    body[has_time] = 1.0;
  }
}

void put_rigid_groups(const std::vector<double>& places, bool in_time, std::vector<RigidGroup>& groups) {
  for (std::size_t b = 0; b < std::min(count(places), groups.size()); ++b) {
    RigidPlace& place = groups[b].place;
    place.displacement = part<Vec3>(places, b, first_displacement);
    place.turn = part<Eigen::Vector4d>(places, b, first_turn);
    const double* body = &places[rigid_place_numbers * b];
    if (body[has_time] > 0.0) place.time = in_time ? body[first_time] : 0.0;
  }
}

std::vector<double> rates_at(const std::vector<double>& places, const std::vector<RigidBody>& bodies) {
  std::vector<double> rates;
  for (std::size_t b = 0; b < std::min(count(places), bodies.size()); ++b) {
    const Vec3 moving = part<Vec3>(places, b, velocity);
    const Vec3 turning = 0.5 * bodies[b].length * (bodies[b].basis.transpose() * part<Vec3>(places, b, spin));
    rates.insert(rates.end(), {moving[0], moving[1], moving[2], turning[0], turning[1], turning[2], 0.0, 0.0, 0.0});
  }
  return rates;
}

}  // namespace voile::system
