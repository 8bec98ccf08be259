// Ends the process, and with it the job, when one test case takes too long, and says which: a lost reduction hangs for ever.
//
// VOILE_TEST_LIMIT gives the limit in seconds of a test case; otherwise 120, five times as many with sanitizers. Ranks that wait
// yield their core, so that on a machine with other work they get next to nothing of it: what has had less than a quarter of
// the limit in CPU seconds may go on, up to five times the limit.
#pragma once

#include <doctest/doctest.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <mutex>
#include <string>
#include <thread>

namespace voile::testing {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr double usual_limit = 600.0;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr double usual_limit = 600.0;
#else
inline constexpr double usual_limit = 120.0;
#endif
#else
inline constexpr double usual_limit = 120.0;
#endif

class Watchdog {
 public:
  Watchdog() {
    if (const char* given = std::getenv("VOILE_TEST_LIMIT")) limit_ = std::atof(given);
    thread_ = std::thread([this] { watch(); });
    // A process that forks while a thread of it starts leaves the sanitizer's allocator locked in the child.
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return watching_; });
  }
  ~Watchdog() {
    set("", 0.0, true);
    thread_.join();
  }
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// From now on `what` must end within `share` of the limit; empty: nothing runs.
  void expect(std::string what, double fraction = 1.0) { set(std::move(what), fraction * limit_, false); }

 private:
  using Clock = std::chrono::steady_clock;

  void set(std::string what, double seconds, bool over) {
    {
      const std::lock_guard lock(mutex_);
      what_ = std::move(what);
      over_ = over;
      seconds_ = seconds;
      cpu_start_ = std::clock();
      end_ = Clock::now() + duration(seconds);
      last_ = Clock::now() + duration(5.0 * seconds);
    }
    changed_.notify_all();
  }

  void watch() {
    std::unique_lock lock(mutex_);
    watching_ = true;
    changed_.notify_all();
    while (!over_) {
      if (what_.empty())
        changed_.wait(lock);
      else if (changed_.wait_until(lock, end_) == std::cv_status::timeout && !what_.empty() && Clock::now() >= end_)
        judge();
    }
  }

  static std::chrono::milliseconds duration(double seconds) {
    return std::chrono::milliseconds(static_cast<long>(1000.0 * seconds));
  }

  void judge() {
    const double cpu = static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
    if (cpu > 0.25 * seconds_ || Clock::now() >= last_) give_up();
    end_ = Clock::now() + duration(0.1 * seconds_);
  }

  /// No MPI call is safe here; mpirun ends the other ranks.
  [[noreturn]] void give_up() const {
    std::fprintf(stderr, "unit_tests: %s has not ended after %g s (VOILE_TEST_LIMIT)\n", what_.c_str(), seconds_);
    std::fflush(stderr);
    std::_Exit(124);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::string what_;
  bool over_ = false, watching_ = false;
  Clock::time_point end_, last_;
  std::clock_t cpu_start_ = 0;
  double limit_ = usual_limit, seconds_ = 0.0;
  std::thread thread_;
};

/// The one of this process, from the first call to its end.
inline Watchdog& watchdog() {
  static Watchdog dog;
  return dog;
}

/// Tells it of every test case.
class Watched : public doctest::IReporter {
 public:
  explicit Watched(const doctest::ContextOptions&) {}
  void test_case_start(const doctest::TestCaseData& test) override {
    watchdog().expect(std::string("the test case \"") + test.m_name + "\"");
  }
  void test_case_end(const doctest::CurrentTestCaseStats&) override { watchdog().expect(""); }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats&) override {}
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}
};

}  // namespace voile::testing
