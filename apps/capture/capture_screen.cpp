#include "apps/capture/capture_screen.h"

#include <utility>

namespace rigcal {
namespace {

constexpr std::size_t most_sentences = 256;

}  // namespace

CaptureScreen::CaptureScreen(Reporter& reporter, std::function<void(const CaptureStatus&)> draw,
                             std::function<void(const std::string&)> tell)
    : reporter_(reporter), draw_(std::move(draw)), tell_(std::move(tell)), thread_([this] { run(); }) {}

CaptureScreen::~CaptureScreen() { finish(); }

void CaptureScreen::show(const CaptureStatus& status) {
  const std::lock_guard lock(mutex_);
  next_ = status;
  wanted_.notify_all();
}

void CaptureScreen::show_progress() {
  const std::lock_guard lock(mutex_);
  shows_progress_ = true;
}

void CaptureScreen::progress(std::string_view stage, double fraction) {
  const std::lock_guard lock(mutex_);
  if (!shows_progress_) return;
  progress_ = Progress{std::string(stage), fraction};
  wanted_.notify_all();
}

void CaptureScreen::say(Sentence sentence) {
  const std::lock_guard lock(mutex_);
  if (sentences_.size() >= most_sentences) {
    ++unsaid_;
    return;
  }
  sentences_.push_back(std::move(sentence));
  wanted_.notify_all();
}

void CaptureScreen::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    wanted_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void CaptureScreen::pass_on(Sentence sentence) {
  switch (sentence.kind) {
    case Sentence::Kind::remark:
      reporter_.debug(std::move(sentence.text));
      return;
    case Sentence::Kind::told:
      tell_(sentence.text);
      return;
    case Sentence::Kind::warning:
      reporter_.warn(std::move(sentence.text));
      return;
  }
}

void CaptureScreen::run() {
  while (true) {
    std::optional<CaptureStatus> status;
    std::optional<Progress> progress;
    std::deque<Sentence> sentences;
    std::size_t unsaid = 0;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [this] { return next_ || progress_ || !sentences_.empty() || is_over_; });
      status = std::exchange(next_, std::nullopt);
      progress = std::exchange(progress_, std::nullopt);
      sentences.swap(sentences_);
      unsaid = std::exchange(unsaid_, 0);
      if (!status && !progress && sentences.empty()) return;
    }
    for (Sentence& sentence : sentences) pass_on(std::move(sentence));
    if (unsaid > 0)
      reporter_.warn(std::to_string(unsaid) + " messages came while nothing could be shown, and are left out");
    if (status) draw_(*status);
    if (progress) reporter_.progress(progress->stage, progress->fraction);
  }
}

}  // namespace rigcal
