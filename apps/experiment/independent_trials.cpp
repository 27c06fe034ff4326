#include "apps/experiment/independent_trials.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Hands out the trials in their order.
class Trials {
 public:
  Trials(int count, const std::string& name, const RunContext& context)
      : count_(count), name_(name), context_(context) {}

  // -1: there are no more.
  int next() {
    const std::lock_guard lock(mutex_);
    return error_ || context_.cancelled() || next_ == count_ ? -1 : next_++;
  }

  void done(int trial, const Expected<void>& result) {
    const std::lock_guard lock(mutex_);
    // Those before it have all begun, so that in the end the first one's error is here.
    if (!result && (!error_ || trial < failed_)) {
      error_ = result.error();
      failed_ = trial;
    }
    ++done_;
    context_.reporter.progress(name_, static_cast<double>(done_) / count_);
  }

  [[nodiscard]] Expected<void> result() const {
    if (error_) return *error_;
    if (done_ < count_) return cancelled_error("stopped before the end");
    return {};
  }

 private:
  int count_;
  const std::string& name_;
  const RunContext& context_;
  std::mutex mutex_;
  int next_ = 0;
  int done_ = 0;
  std::optional<Error> error_;
  int failed_ = 0;
};

}  // namespace

Expected<void> independent_trials(int count, const std::string& name, const RunContext& context,
                                  const std::function<Expected<void>(int)>& trial) {
  Trials trials(count, name, context);
  context.reporter.progress(name, 0.0);
  const auto work = [&] {
    for (int k = trials.next(); k >= 0; k = trials.next()) trials.done(k, trial(k));
  };
  // Threads of our own: what waits inside one trial must not take up another, whose time would count for the first.
  std::vector<std::jthread> helpers;
  for (int i = 1; i < std::min(count, thread_count()); ++i) helpers.emplace_back(work);
  work();
  helpers.clear();
  return trials.result();
}

}  // namespace rigcal
