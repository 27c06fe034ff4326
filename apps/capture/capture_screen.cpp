#include "apps/capture/capture_screen.h"

#include <utility>

namespace rigcal {
namespace {

constexpr std::size_t most_sentences = 256;

}  // namespace

CaptureScreen::CaptureScreen(Reporter& reporter, std::function<void(const CaptureStatus&)> draw)
    : reporter_(reporter), draw_(std::move(draw)), thread_([this] { run(); }) {}

CaptureScreen::~CaptureScreen() { finish(); }

void CaptureScreen::show(const CaptureStatus& status) {
  const std::lock_guard lock(mutex_);
  next_ = status;
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

void CaptureScreen::run() {
  while (true) {
    std::optional<CaptureStatus> status;
    std::deque<Sentence> sentences;
    std::size_t unsaid = 0;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [this] { return next_ || !sentences_.empty() || is_over_; });
      status = std::exchange(next_, std::nullopt);
      sentences.swap(sentences_);
      unsaid = std::exchange(unsaid_, 0);
      if (!status && sentences.empty()) return;
    }
    for (Sentence& sentence : sentences) {
      if (sentence.is_warning) {
        reporter_.warn(std::move(sentence.text));
      } else {
        reporter_.debug(std::move(sentence.text));
      }
    }
    if (unsaid > 0)
      reporter_.warn(std::to_string(unsaid) + " messages came while nothing could be shown, and are left out");
    if (status) draw_(*status);
  }
}

}  // namespace rigcal
