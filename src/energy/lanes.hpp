// Numbers of several triangles side by side; private to the element kernels.
//
// A kernel is one source, compiled once per instruction set: VOILE_LANES is how many triangles a register holds (1: the scalar
// variant, for single elements and tests), VOILE_KERNELS the namespace of the variant. Nothing here or in the kernels may be a
// shared inline function: the linker would keep the copy of one instruction set for all.
#pragma once

#include <cmath>

#if !defined(VOILE_LANES) || !defined(VOILE_KERNELS)
#error "VOILE_LANES and VOILE_KERNELS are set by the source of each variant"
#endif

#define VOILE_INLINE inline __attribute__((always_inline))
/// So that what rarely runs takes no registers of what always does.
#define VOILE_APART inline __attribute__((noinline))

namespace voile::energy::VOILE_KERNELS {

constexpr int width = VOILE_LANES;

#if VOILE_LANES == 1
using Real = double;
VOILE_INLINE Real load(const double* from) {
  return *from;
}
VOILE_INLINE void store(double* to, Real value) {
  *to = value;
}
VOILE_INLINE Real all(double value) {
  return value;
}
VOILE_INLINE Real gather(const double* from, const int* at, int stride) {
  return from[stride * static_cast<long>(*at)];
}
VOILE_INLINE Real converted(const int* from) {
  return *from;
}
VOILE_INLINE Real root(Real a) {
  return std::sqrt(a);
}
#else
typedef double Real __attribute__((vector_size(8 * VOILE_LANES)));
typedef Real LooseReal __attribute__((aligned(8), may_alias));
VOILE_INLINE Real load(const double* from) {
  return *reinterpret_cast<const LooseReal*>(from);
}
VOILE_INLINE void store(double* to, const Real& value) {
  *reinterpret_cast<LooseReal*>(to) = value;
}
VOILE_INLINE Real all(double value) {
  return Real{} + value;
}
/// from[stride * at] of each lane.
VOILE_INLINE Real gather(const double* from, const int* at, int stride) {
  const auto one = [&](int lane) { return from[stride * static_cast<long>(at[lane])]; };
#if VOILE_LANES == 2
  return Real{one(0), one(1)};
#elif VOILE_LANES == 4
  return Real{one(0), one(1), one(2), one(3)};
#else
  return Real{one(0), one(1), one(2), one(3), one(4), one(5), one(6), one(7)};
#endif
}
VOILE_INLINE Real converted(const int* from) {
  Real r;
  for (int lane = 0; lane < width; ++lane) r[lane] = from[lane];
  return r;
}
VOILE_INLINE Real root(const Real& a) {  // one instruction, given -fno-math-errno
  Real r;
  for (int lane = 0; lane < width; ++lane) r[lane] = std::sqrt(a[lane]);
  return r;
}
#endif

/// yes where the condition holds, otherwise no.
template <class Mask>
VOILE_INLINE Real select(const Mask& condition, const Real& yes, const Real& no) {
  return condition ? yes : no;
}
VOILE_INLINE Real larger(const Real& a, const Real& b) {
  return select(a > b, a, b);
}

struct Vector {
  Real x, y, z;
};
VOILE_INLINE Vector zero() {
  return {all(0.0), all(0.0), all(0.0)};
}
VOILE_INLINE Vector operator+(const Vector& a, const Vector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
VOILE_INLINE Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
VOILE_INLINE Vector operator*(const Real& s, const Vector& a) {
  return {s * a.x, s * a.y, s * a.z};
}
VOILE_INLINE Real dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
VOILE_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Keeps a vector that is used several times in registers: GCC would load it from memory for each product.
VOILE_INLINE void hold([[maybe_unused]] Vector& a) {
#if defined(__x86_64__) && VOILE_LANES == 8
  asm("" : "+v"(a.x), "+v"(a.y), "+v"(a.z));
#elif defined(__x86_64__)
  asm("" : "+x"(a.x), "+x"(a.y), "+x"(a.z));
#endif
}
VOILE_INLINE Vector gather_vector(const double* from, const int* at) {
  return {gather(from, at, 3), gather(from + 1, at, 3), gather(from + 2, at, 3)};
}

/// A 3x3 block by rows.
struct Block {
  Real k[9];
};
/// to += a b^T
VOILE_INLINE void add_outer(Block& to, const Vector& a, const Vector& b) {
  to.k[0] += a.x * b.x;
  to.k[1] += a.x * b.y;
  to.k[2] += a.x * b.z;
  to.k[3] += a.y * b.x;
  to.k[4] += a.y * b.y;
  to.k[5] += a.y * b.z;
  to.k[6] += a.z * b.x;
  to.k[7] += a.z * b.y;
  to.k[8] += a.z * b.z;
}

/// L^T e of C = L L^T, stored as L (11 21 31 22 32 33), of numbers or vectors.
template <class A>
VOILE_INLINE void times_factor(const Real (&l)[6], A& e0, A& e1, A& e2) {
  e0 = l[0] * e0 + l[1] * e1 + l[2] * e2;
  e1 = l[3] * e1 + l[4] * e2;
  e2 = l[5] * e2;
}
/// F e of a full matrix by rows.
template <class A>
VOILE_INLINE void times_factor(const Real (&f)[9], A& e0, A& e1, A& e2) {
  const A a = e0, b = e1, c = e2;
  e0 = f[0] * a + f[1] * b + f[2] * c;
  e1 = f[3] * a + f[4] * b + f[5] * c;
  e2 = f[6] * a + f[7] * b + f[8] * c;
}
/// L y.
VOILE_INLINE void times_transposed(const Real (&l)[6], Real& y0, Real& y1, Real& y2) {
  y2 = l[2] * y0 + l[4] * y1 + l[5] * y2;
  y1 = l[1] * y0 + l[3] * y1;
  y0 = l[0] * y0;
}

/// Adds one vector of each lane to force[at].
VOILE_INLINE void scatter_vector(double* to, const int* at, const Vector& v, int lanes) {
  alignas(64) double k[3][width];
  store(k[0], v.x);
  store(k[1], v.y);
  store(k[2], v.z);
  for (int lane = 0; lane < lanes; ++lane) {
    double* point = to + 3 * static_cast<long>(at[lane]);
    for (int c = 0; c < 3; ++c) point[c] += k[c][lane];
  }
}

typedef double Four __attribute__((vector_size(32)));
typedef Four LooseFour __attribute__((aligned(8), may_alias));
VOILE_INLINE Four load_four(const double* from) {
  return *reinterpret_cast<const LooseFour*>(from);
}
#if VOILE_LANES >= 4
/// Four numbers of four lanes, lane by lane or number by number, the other way round.
VOILE_INLINE void transpose(const Four (&r)[4], Four (&to)[4]) {
  const Four a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6), b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7),
             c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6), d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  to[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  to[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  to[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  to[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}
/// Four rows of lanes, from one lane on.
VOILE_INLINE void transpose(const double (*from)[width], int lane, Four (&to)[4]) {
  const Four rows[4] = {load_four(&from[0][lane]), load_four(&from[1][lane]), load_four(&from[2][lane]),
                        load_four(&from[3][lane])};
  transpose(rows, to);
}
#endif

#if VOILE_LANES == 8
/// Eight numbers of eight lanes, number by number, to lane by lane.
VOILE_INLINE void transpose(const Real* r, Real (&to)[8]) {
  Real even[4], odd[4];  // of the lanes, two numbers of each side by side
  for (int k = 0; k < 4; ++k) {
    even[k] = __builtin_shufflevector(r[2 * k], r[2 * k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    odd[k] = __builtin_shufflevector(r[2 * k], r[2 * k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int lane = 0; lane < 2; ++lane) {
    const Real* pair = lane == 0 ? even : odd;
    const Real a = __builtin_shufflevector(pair[0], pair[1], 0, 1, 8, 9, 4, 5, 12, 13),
               b = __builtin_shufflevector(pair[2], pair[3], 0, 1, 8, 9, 4, 5, 12, 13),
               c = __builtin_shufflevector(pair[0], pair[1], 2, 3, 10, 11, 6, 7, 14, 15),
               d = __builtin_shufflevector(pair[2], pair[3], 2, 3, 10, 11, 6, 7, 14, 15);
    to[lane] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    to[lane + 2] = __builtin_shufflevector(c, d, 0, 1, 2, 3, 8, 9, 10, 11);
    to[lane + 4] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
    to[lane + 6] = __builtin_shufflevector(c, d, 4, 5, 6, 7, 12, 13, 14, 15);
  }
}
#endif

/// Adds a block of each lane to the nine numbers at slot[lane].
VOILE_INLINE void scatter_block(double* to, const int* slot, const Block& block, int lanes) {
#if VOILE_LANES == 8
  if (lanes == width) {
    Real eight[8];
    transpose(block.k, eight);
    for (int lane = 0; lane < width; ++lane) {
      double* at = to + slot[lane];
      *reinterpret_cast<LooseReal*>(at) += eight[lane];
      at[8] += block.k[8][lane];
    }
    return;
  }
#endif
  alignas(64) double k[9][width];
  for (int r = 0; r < 9; ++r) store(k[r], block.k[r]);
#if VOILE_LANES == 4
  if (lanes == width) {
    Four upper[4], lower[4];
    transpose(k, 0, upper);
    transpose(k + 4, 0, lower);
    for (int lane = 0; lane < 4; ++lane) {
      double* at = to + slot[lane];
      *reinterpret_cast<LooseFour*>(at) += upper[lane];
      *reinterpret_cast<LooseFour*>(at + 4) += lower[lane];
      at[8] += k[8][lane];
    }
    return;
  }
#endif
  for (int lane = 0; lane < lanes; ++lane) {
    double* at = to + slot[lane];
    for (int r = 0; r < 9; ++r) at[r] += k[r][lane];
  }
}
/// Fetches the places of blocks that will be added to soon.
VOILE_INLINE void fetch_blocks(const double* to, const int* slot) {
  for (int lane = 0; lane < width; ++lane) {
    __builtin_prefetch(to + slot[lane], 1);
    __builtin_prefetch(to + slot[lane] + 8, 1);
  }
}
/// Turns the blocks of lanes where the second point has the smaller number.
VOILE_INLINE void order_block(Block& block, const Real& first, const Real& second) {
  const auto turn = second < first;
  const int pairs[3][2] = {{1, 3}, {2, 6}, {5, 7}};
  for (const auto& p : pairs) {
    const Real upper = block.k[p[0]], lower = block.k[p[1]];
    block.k[p[0]] = select(turn, lower, upper);
    block.k[p[1]] = select(turn, upper, lower);
  }
}

}  // namespace voile::energy::VOILE_KERNELS
