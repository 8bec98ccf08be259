// How far a test goes.
#pragma once

namespace voile {

/// Sanitizers look for errors of memory, not of the mechanics, and take ten to twenty times as long: where a test only goes
/// through more values of the same, `few` of them do.
#ifdef VOILE_SANITIZED
template <class T>
constexpr T extent(T, T few) {
  return few;
}
#else
template <class T>
constexpr T extent(T whole, T) {
  return whole;
}
#endif

}  // namespace voile
